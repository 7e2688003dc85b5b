// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>
#include <map>
#include <optional>

#include "mbs/files/inputs.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/text_file.hpp"

// MotionSolve Reference Guide, Reference_FlexData. The guide's own example is not well-formed XML (tags that
// do not match in case, "< ! -- -->" as a comment), so the reader looks for blocks and numbers only.
namespace flexura::superelement {
namespace {

struct Reader {
  std::string text;
  std::string file;

  int line_at(std::size_t at) const {
    return 1 +
           static_cast<int>(std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n'));
  }
  [[noreturn]] void fail(std::size_t at, const std::string& what) const {
    throw std::invalid_argument(fmt::format("{}:{}: {}", file, line_at(std::min(at, text.size())), what));
  }
};

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

struct Block {
  std::size_t begin = 0, end = 0;
};

// What stands between <tag and </tag, whatever their case.
std::optional<Block> find_block(const Reader& reader, const std::string& lowered, const std::string& tag) {
  const std::size_t open = lowered.find("<" + tag);
  if (open == std::string::npos) return std::nullopt;
  const std::size_t close = lowered.find("</" + tag, open);
  if (close == std::string::npos) reader.fail(open, "<" + tag + "> is not closed; the file is cut short");
  return Block{open + tag.size() + 1, close};
}

int attribute(const Reader& reader, const std::string& lowered, const std::string& name, bool required) {
  std::size_t at = lowered.find(name + " ");
  if (at == std::string::npos) at = lowered.find(name + "=");
  const std::size_t quote = at == std::string::npos ? at : lowered.find('"', at);
  int value = 0;
  if (quote == std::string::npos ||
      std::from_chars(lowered.data() + quote + 1, lowered.data() + lowered.size(), value).ec != std::errc()) {
    if (required)
      reader.fail(at == std::string::npos ? 0 : at, "the attribute " + name + " = \"number\" is missing");
    return 0;
  }
  if (value < 0 || value > 10'000'000) reader.fail(at, fmt::format("{} = {} cannot be", name, value));
  return value;
}

// All numbers of a block; what stands between "<" and ">" is a tag or comment.
class Numbers {
 public:
  Numbers(const Reader& reader, Block block) : reader_(reader), at_(block.begin), end_(block.end) {
    const std::size_t close = reader.text.find('>', at_);  // the rest of the opening tag
    if (close < end_ && reader.text.find('<', at_) > close) at_ = close + 1;
  }
  double next(const char* what) {
    const std::string& text = reader_.text;
    for (;;) {
      while (at_ < end_ && (std::isspace(static_cast<unsigned char>(text[at_])) || text[at_] == ',')) ++at_;
      if (at_ >= end_) reader_.fail(end_, fmt::format("the block ends where {} is wanted", what));
      if (text[at_] != '<') break;
      at_ = std::min(text.find('>', at_), end_ - 1) + 1;
    }
    const std::size_t start = at_ + (text[at_] == '+' ? 1 : 0);
    double value = 0.0;
    const auto [stop, failure] = std::from_chars(text.data() + start, text.data() + end_, value);
    if (failure != std::errc()) {
      reader_.fail(at_, fmt::format("\"{}\" stands where {} is wanted",
                                    text.substr(at_, std::min<std::size_t>(12, end_ - at_)), what));
    }
    at_ = static_cast<std::size_t>(stop - text.data());
    return value;
  }

 private:
  const Reader& reader_;
  std::size_t at_, end_;
};

}  // namespace

FlexData make_flexdata(const Superelement& se, const ModeAnalysis& modes) {
  FlexData data;
  const Eigen::MatrixXd Y = exchange::elastic_shapes(se, modes);
  for (Eigen::Index j = 0; j < Y.cols(); ++j) {
    const Mode& mode = modes.modes[static_cast<std::size_t>(modes.n_rigid + j)];
    data.modes.push_back(
        {modes.n_rigid + static_cast<int>(j) + 1, mode.frequency_hz, mode.omega2, mode.damping});
  }
  data.shapes = Eigen::MatrixXd::Zero(6 * static_cast<Eigen::Index>(se.interfaces.size()), Y.cols());
  for (std::size_t k = 0; k < se.interfaces.size(); ++k) {
    const Interface& interface = se.interfaces[k];
    data.nodes.push_back({static_cast<int>(k) + 1, interface.p_BoN_B});
    for (std::size_t i = 0; i < interface.directions.size(); ++i) {
      data.shapes.row(6 * static_cast<Eigen::Index>(k) + static_cast<int>(interface.directions[i])) =
          Y.row(interface.first_dof + static_cast<int>(i));
    }
  }
  data.num_nodes = static_cast<int>(se.surface.vertices.rows());
  return data;
}

void write_flexdata(const std::filesystem::path& path, const FlexData& data) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  fmt::format_to(to,
                 "<Reference_FlexData\n     id            = \"{}\"\n     num_nodes     = \"{}\"\n"
                 "     num_sel_modes = \"{}\"\n     num_sel_nodes = \"{}\">\n<ModeData>\n"
                 "<!-- ID Frequency Eigenvalue Damping -->\n",
                 data.id, data.num_nodes, data.modes.size(), data.nodes.size());
  for (const auto& mode : data.modes) {
    fmt::format_to(to, "{:8} {:22.14E} {:22.14E} {:22.14E}\n", mode.id, mode.frequency, mode.eigenvalue,
                   mode.damping);
  }
  fmt::format_to(to, "</ModeData>\n<NodeData>\n<!-- ID X Y Z -->\n");
  for (const auto& node : data.nodes) {
    fmt::format_to(to, "{:8} {:22.14E} {:22.14E} {:22.14E}\n", node.id, node.position[0], node.position[1],
                   node.position[2]);
  }
  fmt::format_to(to, "<!-- Mode Shape -->\n");
  for (Eigen::Index j = 0; j < data.shapes.cols(); ++j) {
    for (Eigen::Index i = 0; i < data.shapes.rows(); ++i) {
      fmt::format_to(to, "{:22.14E}{}", data.shapes(i, j), i % 6 == 5 ? "\n" : " ");
    }
  }
  fmt::format_to(to, "</NodeData>\n</Reference_FlexData>\n");
  write_whole(path, {out.data(), out.size()});
}

FlexData read_flexdata(const std::filesystem::path& path) {
  Reader reader;
  reader.file = path.string();
  flexura::files::note_input(path);
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw std::invalid_argument(reader.file + ": there is no such file or it cannot be read; check the path");
  reader.text.assign((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::string lowered = lower(reader.text);
  const std::size_t start = lowered.find("<reference_flexdata");
  if (start == std::string::npos) reader.fail(0, "holds no Reference_FlexData");
  const auto mode_block = find_block(reader, lowered, "modedata");
  if (!mode_block) reader.fail(start, "has no ModeData block");
  const auto node_block = find_block(reader, lowered, "nodedata");
  if (!node_block) reader.fail(start, "has no NodeData block");

  const std::string header = lowered.substr(start, mode_block->begin - start);
  FlexData data;
  data.id = attribute(reader, header, " id", false);
  if (data.id == 0) data.id = attribute(reader, header, "\nid", true);
  data.num_nodes = attribute(reader, header, "num_nodes", false);
  const int n_modes = attribute(reader, header, "num_sel_modes", true);
  const int n_nodes = attribute(reader, header, "num_sel_nodes", true);

  Numbers mode_numbers(reader, *mode_block);
  for (int j = 0; j < n_modes; ++j) {
    FlexData::ModeLine mode;
    mode.id = static_cast<int>(mode_numbers.next("a mode's number"));
    mode.frequency = mode_numbers.next("a frequency");
    mode.eigenvalue = mode_numbers.next("an eigenvalue");
    mode.damping = mode_numbers.next("a damping ratio");
    data.modes.push_back(mode);
  }
  Numbers node_numbers(reader, *node_block);
  for (int k = 0; k < n_nodes; ++k) {
    FlexData::NodeLine node;
    node.id = static_cast<int>(node_numbers.next("a node's number"));
    for (int a = 0; a < 3; ++a) node.position[a] = node_numbers.next("a coordinate");
    data.nodes.push_back(node);
  }
  // Read number by number: a count that is not true ends at the end of the block, before memory is taken for
  // it.
  std::vector<double> values;
  for (long long i = 0; i < 6LL * n_nodes * n_modes; ++i)
    values.push_back(node_numbers.next("a mode shape's entry"));
  data.shapes = Eigen::Map<const Eigen::MatrixXd>(values.data(), 6 * n_nodes, n_modes);
  return data;
}

}  // namespace flexura::superelement
