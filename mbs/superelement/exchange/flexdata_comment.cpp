// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/exchange/flexdata_comment.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstring>
#include <iterator>

#include "mbs/base/files/plain_text.hpp"

namespace flexura::superelement::flexdata {
namespace {

constexpr const char* kComment = "<!-- Flexura: the body's inertia integrals (SI)";
constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};

// Names as they may stand in a comment: "--" would end it.
std::string encoded(const std::string& name) {
  std::string out;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.')
      out += c;
    else
      out += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

std::string decoded(const std::string& text) {
  std::string out;
  for (std::size_t k = 0; k < text.size(); ++k) {
    unsigned value = 0;
    if (text[k] == '%' && k + 2 < text.size() &&
        std::from_chars(text.data() + k + 1, text.data() + k + 3, value, 16).ec == std::errc()) {
      out += static_cast<char>(value);
      k += 2;
    } else {
      out += text[k];
    }
  }
  return out;
}

}  // namespace

std::string comment_of(const FlexDataBody& body, const std::vector<FlexData::LoadLine>& loads) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  const auto numbers = [&](const char* name, const auto& A) {
    fmt::format_to(to, "{}", name);
    for (Eigen::Index j = 0; j < A.cols(); ++j)
      for (Eigen::Index i = 0; i < A.rows(); ++i)
        fmt::format_to(to, "{}{:.16E}", i % 6 == 0 ? "\n" : " ", A(i, j));
    fmt::format_to(to, "\n");
  };
  fmt::format_to(to, "{}\nmass {:.16E}\nmodal_damping {:.16E}\n", kComment, body.mass, body.modal_damping);
  numbers("S_x", body.S_x);
  numbers("S_xx", body.S_xx);
  for (std::size_t k = 0; k < body.names.size(); ++k) {
    fmt::format_to(to, "interface {}", encoded(body.names[k]));
    for (const Direction d : body.directions[k]) fmt::format_to(to, " {}", kDirections[static_cast<int>(d)]);
    fmt::format_to(to, " ;\n");
  }
  numbers("S_phi", body.S_phi);
  numbers("S_xphi", body.S_xphi);
  for (const Eigen::MatrixXd& S : body.S_phiphi) numbers("S_phiphi", S);
  for (const FlexData::LoadLine& load : loads) {
    if (!load.resultant) continue;
    fmt::format_to(to, "load {} {} {}", load.id, encoded(load.name),
                   load.is_preload ? "preload" : "external");
    numbers("", *load.resultant);
  }
  fmt::format_to(to, "-->\n");
  return fmt::to_string(out);
}

namespace {

// The words of the comment, one after the other.
class Words {
 public:
  Words(const Text& reader, Block block) : reader_(reader), at_(block.begin), end_(block.end) {}
  std::string next(const std::string& wanted) {
    const std::string& text = reader_.text;
    while (at_ < end_ && std::isspace(static_cast<unsigned char>(text[at_]))) ++at_;
    if (at_ >= end_)
      reader_.fail(end_, "the comment of the inertia integrals ends where " + wanted + " is wanted");
    begin_ = at_;
    while (at_ < end_ && !std::isspace(static_cast<unsigned char>(text[at_]))) ++at_;
    return text.substr(begin_, at_ - begin_);
  }
  void expect(const std::string& word) {
    if (const std::string found = next(word); found != word)
      reader_.fail(begin_, fmt::format("\"{}\" stands where {} is wanted", found.substr(0, 20), word));
  }
  double number(const std::string& of) {
    const std::string word = next("a number of " + of);
    double value = 0.0;
    const auto [stop, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (failure != std::errc() || stop != word.data() + word.size() || !std::isfinite(value))
      reader_.fail(begin_,
                   fmt::format("\"{}\" stands where a number of {} is wanted", word.substr(0, 20), of));
    return value;
  }
  Eigen::MatrixXd matrix(const std::string& name, Eigen::Index rows, Eigen::Index columns) {
    expect(name);
    std::vector<double> values;  // one by one: a count that is not true takes no memory
    for (Eigen::Index k = 0; k < rows * columns; ++k) values.push_back(number(name));
    return Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, columns);
  }
  bool more() {
    while (at_ < end_ && std::isspace(static_cast<unsigned char>(reader_.text[at_]))) ++at_;
    return at_ < end_;
  }
  [[noreturn]] void fail(const std::string& what) const { reader_.fail(begin_, what); }

 private:
  const Text& reader_;
  std::size_t at_, end_, begin_ = 0;
};

}  // namespace

std::optional<FlexDataBody> body_in_comment(const Text& text, const Element& element, int n_nodes,
                                            int n_modes, std::vector<FlexData::LoadLine>& loads) {
  const std::size_t comment = text.text.find(kComment, element.begin),
                    begin = comment + std::strlen(kComment);
  if (comment >= element.end) return std::nullopt;
  const std::size_t close = text.text.find("-->", comment);
  if (close == std::string::npos)
    text.fail(comment, "the comment of the inertia integrals is not closed; the file is cut short");
  Words words(text, {begin, close});
  FlexDataBody body;
  words.expect("mass");
  body.mass = words.number("mass");
  words.expect("modal_damping");
  body.modal_damping = words.number("modal_damping");
  body.S_x = words.matrix("S_x", 3, 1);
  body.S_xx = words.matrix("S_xx", 3, 3);
  for (int k = 0; k < n_nodes; ++k) {
    words.expect("interface");
    body.names.push_back(files::plain_text(decoded(words.next("a name"))));
    std::vector<Direction>& directions = body.directions.emplace_back();
    for (std::string word; (word = words.next("a direction or \";\"")) != ";";) {
      const auto found = std::find(std::begin(kDirections), std::end(kDirections), word);
      if (found == std::end(kDirections) ||
          (!directions.empty() && static_cast<int>(directions.back()) >= found - std::begin(kDirections)))
        words.fail("the directions of an interface are x, y, z, rx, ry, rz in this order, or some of them");
      directions.push_back(static_cast<Direction>(found - std::begin(kDirections)));
    }
  }
  body.S_phi = words.matrix("S_phi", 3, n_modes);
  body.S_xphi = words.matrix("S_xphi", 9, n_modes);
  for (Eigen::MatrixXd& S : body.S_phiphi) S = words.matrix("S_phiphi", n_modes, n_modes);
  while (words.more()) {
    words.expect("load");
    const double id = words.number("a load case's number");
    const auto load =
        std::ranges::find(loads, id, [](const FlexData::LoadLine& l) { return static_cast<double>(l.id); });
    if (load == loads.end()) words.fail(fmt::format("there is no ModeLoad of the loadcase_id {:g}", id));
    load->name = files::plain_text(decoded(words.next("a name")));
    load->is_preload = words.next("preload or external") == "preload";
    Eigen::Matrix<double, 6, 1>& resultant = load->resultant.emplace();
    for (double& value : resultant) value = words.number("the load's force and torque");
  }
  return body;
}

}  // namespace flexura::superelement::flexdata
