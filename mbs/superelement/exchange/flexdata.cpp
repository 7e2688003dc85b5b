// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "mbs/base/files/inputs.hpp"
#include "mbs/base/files/json_text.hpp"
#include "mbs/superelement/exchange/exchange.hpp"
#include "mbs/superelement/exchange/flexdata_comment.hpp"
#include "mbs/superelement/exchange/flexdata_text.hpp"
#include "mbs/superelement/text_file.hpp"

// MotionSolve Reference Guide, Reference_FlexData.
namespace flexura::superelement {
namespace {

using flexdata::Block;
using Reader = flexdata::Text;

// All numbers of a block; what stands between "<" and ">" is a tag or comment.
class Numbers {
 public:
  Numbers(const Reader& reader, Block block) : reader_(reader), at_(block.begin), end_(block.end) {
    const std::size_t close = reader.text.find('>', at_);  // the rest of the opening tag
    if (close < end_ && reader.text.find('<', at_) > close) at_ = close + 1;
  }
  double next(const char* what) {
    const std::string& text = reader_.text;
    skip();
    if (at_ >= end_) reader_.fail(end_, fmt::format("the block ends where {} is wanted", what));
    const std::size_t start = at_ + (text[at_] == '+' ? 1 : 0);
    double value = 0.0;
    auto [stop, failure] = std::from_chars(text.data() + start, text.data() + end_, value);
    auto after = static_cast<std::size_t>(stop - text.data());
    if (failure == std::errc() && after < end_ && (text[after] == 'D' || text[after] == 'd')) {  // Fortran's
      std::string number = text.substr(start, std::min<std::size_t>(end_ - start, 60));
      number[after - start] = 'e';
      const auto again = std::from_chars(number.data(), number.data() + number.size(), value);
      failure = again.ec;
      after = start + static_cast<std::size_t>(again.ptr - number.data());
    }
    if (failure != std::errc() || !std::isfinite(value)) {
      reader_.fail(at_, fmt::format("\"{}\" stands where {} is wanted",
                                    text.substr(at_, std::min<std::size_t>(12, end_ - at_)), what));
    }
    at_ = after;
    return value;
  }
  int whole(const char* what) {
    const double value = next(what);
    if (!(std::abs(value) < 2e9) || value != std::floor(value))
      reader_.fail(at_, fmt::format("{} stands where {} is wanted", value, what));
    return static_cast<int>(value);
  }
  [[noreturn]] void refuse(const std::string& what) const { reader_.fail(at_, what); }
  bool more() {
    skip();
    return at_ < end_;
  }
  /// Refuses what is left.
  void end(const std::string& count) {
    skip();
    if (at_ >= end_) return;
    reader_.fail(at_, fmt::format("the block goes on with \"{}\" after {}",
                                  reader_.text.substr(at_, std::min<std::size_t>(12, end_ - at_)), count));
  }

 private:
  void skip() {
    const std::string& text = reader_.text;
    while (at_ < end_) {
      const char c = text[at_];
      if (c == '<')
        at_ = std::min(text.find('>', at_), end_ - 1) + 1;
      else if (std::isspace(static_cast<unsigned char>(c)) || c == ',')
        ++at_;
      else
        return;
    }
  }
  const Reader& reader_;
  std::size_t at_, end_;
};

// The six numbers on rigid modes of unit modal mass.
Eigen::Matrix<double, 6, 1> on_rigid_modes(const FlexDataBody& body,
                                           const Eigen::Matrix<double, 6, 1>& resultant) {
  const Eigen::Vector3d centre = body.S_x / body.mass, force = resultant.head<3>(),
                        torque = resultant.tail<3>() - centre.cross(force);
  const Eigen::Matrix3d second = body.S_xx - body.mass * centre * centre.transpose(),
                        inertia = second.trace() * Eigen::Matrix3d::Identity() - second;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(inertia);
  Eigen::Matrix<double, 6, 1> out;
  out.head<3>() = force / std::sqrt(body.mass);
  for (int k = 0; k < 3; ++k) {
    const double I = axes.eigenvalues()(k);
    out(3 + k) = I > 0.0 ? axes.eigenvectors().col(k).dot(torque) / std::sqrt(I) : 0.0;
  }
  return out;
}

// A ModeLoad's numbers, of whichever modes they are.
FlexData::LoadLine read_load(const Reader& reader, const flexdata::LoadBlock& block, const FlexData& data,
                             int number) {
  Numbers numbers(reader, block.numbers);
  std::vector<double> values;
  while (numbers.more()) values.push_back(numbers.next("a modal load"));
  const auto n = values.size(), m = data.modes.size();
  FlexData::LoadLine load{.id = block.id.value_or(number)};
  load.name = fmt::format("load_{}", load.id);
  load.on_modes.resize(static_cast<Eigen::Index>(m));
  bool by_number = true;
  for (const FlexData::ModeLine& mode : data.modes)
    by_number = by_number && mode.id > 6 && static_cast<std::size_t>(mode.id) <= n;
  if (n != m && n != m + 6 && !by_number)
    numbers.refuse(
        fmt::format("the ModeLoad {} has {} numbers; wanted are one for each of the {} modes, or {}, six on "
                    "rigid modes before them, or one "
                    "for each mode by its number in ModeData",
                    load.id, n, m, m + 6));
  load.has_rigid =
      n != m && std::any_of(values.begin(), values.begin() + 6, [](double value) { return value != 0.0; });
  for (std::size_t j = 0; j < m; ++j)
    load.on_modes(static_cast<Eigen::Index>(j)) =
        values[n == m       ? j
               : n == m + 6 ? 6 + j
                            : static_cast<std::size_t>(data.modes[j].id) - 1];
  return load;
}

// A count that the reduction's report holds.
std::optional<int> count_in(const nlohmann::json& report, const char* table, const char* key) {
  if (!report.is_object() || !report.contains(table) || !report[table].is_object()) return std::nullopt;
  const auto& in = report[table];
  if (!in.contains(key) || !in[key].is_number_integer()) return std::nullopt;
  const auto count = in[key].get<std::int64_t>();
  return count >= 0 && count <= 2'000'000'000 ? std::optional(static_cast<int>(count)) : std::nullopt;
}

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
    data.shapes.middleRows<6>(6 * static_cast<Eigen::Index>(k)) = interface_motion(se, interface) * Y;
  }
  // Of the model; a superelement whose report does not tell it has its surface, or its interfaces at least.
  const auto report = flexura::files::try_read_json(se.report_json);
  data.num_nodes = static_cast<int>(
      std::max<Eigen::Index>(se.surface.vertices.rows(), static_cast<Eigen::Index>(se.interfaces.size())));
  data.num_nodes = std::max({data.num_nodes, count_in(report, "mesh", "nodes").value_or(0),
                             count_in(report, "flexdata", "num_nodes").value_or(0)});
  data.id = count_in(report, "flexdata", "id").value_or(data.id);
  FlexDataBody& body = data.body.emplace();
  const InertiaIntegrals& I = se.inertia;
  body.mass = I.mass, body.S_x = I.S_x, body.S_xx = I.S_xx;
  body.modal_damping = se.modal_damping;
  for (const Interface& interface : se.interfaces) {
    body.names.push_back(interface.name);
    std::vector<Direction>& directions = body.directions.emplace_back(interface.directions);
    directions.insert(directions.end(), interface.following.begin(), interface.following.end());
    std::ranges::sort(directions);
  }
  body.S_phi = I.S_phi * Y;
  body.S_xphi = I.S_xphi * Y;
  for (std::size_t k = 0; k < 6; ++k) body.S_phiphi[k] = Y.transpose() * I.S_phiphi[k] * Y;
  const Eigen::MatrixXd R = rigid_motions(se);
  for (std::size_t k = 0; k < se.load_cases.size(); ++k) {
    const LoadCase& load = se.load_cases[k];
    data.loads.push_back({.id = static_cast<int>(k) + 1,
                          .name = load.name,
                          .on_modes = Y.transpose() * load.p_se,
                          .resultant = R.transpose() * load.p_se,
                          .is_preload = load.is_preload});
  }
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
    fmt::format_to(to, "{:8} {:24.16E} {:24.16E} {:24.16E}\n", mode.id, mode.frequency, mode.eigenvalue,
                   mode.damping);
  }
  fmt::format_to(to, "</ModeData>\n<NodeData>\n<!-- ID X Y Z -->\n");
  for (const auto& node : data.nodes) {
    fmt::format_to(to, "{:8} {:24.16E} {:24.16E} {:24.16E}\n", node.id, node.position[0], node.position[1],
                   node.position[2]);
  }
  fmt::format_to(to, "<!-- Mode Shape -->\n");
  for (Eigen::Index j = 0; j < data.shapes.cols(); ++j) {
    for (Eigen::Index i = 0; i < data.shapes.rows(); ++i) {
      fmt::format_to(to, "{:24.16E}{}", data.shapes(i, j), i % 6 == 5 ? "\n" : " ");
    }
  }
  fmt::format_to(to, "</NodeData>\n");
  for (const FlexData::LoadLine& load : data.loads) {
    fmt::format_to(to, "<ModeLoad loadcase_id = \"{}\">\n", load.id);
    Eigen::VectorXd values(6 + load.on_modes.size());
    values << Eigen::Matrix<double, 6, 1>::Zero(), load.on_modes;
    if (data.body && load.resultant) values.head<6>() = on_rigid_modes(*data.body, *load.resultant);
    for (Eigen::Index k = 0; k < values.size(); ++k)
      fmt::format_to(to, "{:24.16E}{}", values(k), k % 6 == 5 || k + 1 == values.size() ? "\n" : " ");
    fmt::format_to(to, "</ModeLoad>\n");
  }
  if (data.body) fmt::format_to(to, "{}", flexdata::comment_of(*data.body, data.loads));
  fmt::format_to(to, "</Reference_FlexData>\n");
  write_whole(path, {out.data(), out.size()});
}

FlexData read_flexdata(const std::filesystem::path& path, std::optional<int> id) {
  flexura::files::note_input(path);
  std::ifstream in(path, std::ios::binary);
  if (!in)
    throw std::invalid_argument(path.string() +
                                ": there is no such file or it cannot be read; check the path");
  const Reader whole{path.string(), {(std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>()}},
      reader{path.string(), flexdata::without_comments(whole.text)};
  const std::vector<flexdata::Element> elements = flexdata::elements_of(reader);
  const flexdata::Element& element = flexdata::chosen(reader, elements, id);
  FlexData data;
  data.id = element.required(reader, "id");
  data.num_nodes = element.whole(reader, "num_nodes").value_or(0);
  const int n_modes = element.required(reader, "num_sel_modes");
  const int n_nodes = element.required(reader, "num_sel_nodes");

  Numbers mode_numbers(reader, element.modes);
  for (int j = 0; j < n_modes; ++j) {
    FlexData::ModeLine mode;
    mode.id = mode_numbers.whole("a mode's number");
    mode.frequency = mode_numbers.next("a frequency");
    mode.eigenvalue = mode_numbers.next("an eigenvalue");
    mode.damping = mode_numbers.next("a damping ratio");
    if (!(mode.eigenvalue > 0.0))
      mode_numbers.refuse(
          fmt::format("mode {} has the eigenvalue {:g}; only elastic modes, above 0, belong here", mode.id,
                      mode.eigenvalue));
    // Printed digits: four at least.
    if (std::abs(2.0 * std::numbers::pi * mode.frequency / std::sqrt(mode.eigenvalue) - 1.0) > 1e-3)
      mode_numbers.refuse(fmt::format(
          "mode {} has the frequency {:g} Hz and the eigenvalue {:g}, which is {:g} Hz; both must be of one "
          "mode",
          mode.id, mode.frequency, mode.eigenvalue, std::sqrt(mode.eigenvalue) / (2.0 * std::numbers::pi)));
    data.modes.push_back(mode);
  }
  mode_numbers.end(fmt::format("num_sel_modes = {} modes", n_modes));
  Numbers node_numbers(reader, element.nodes);
  for (int k = 0; k < n_nodes; ++k) {
    FlexData::NodeLine node;
    node.id = node_numbers.whole("a node's number");
    for (int a = 0; a < 3; ++a) node.position[a] = node_numbers.next("a coordinate");
    data.nodes.push_back(node);
  }
  // Read number by number: a count that is not true ends at the end of the block, before memory is taken for
  // it.
  std::vector<double> values;
  for (long long i = 0; i < 6LL * n_nodes * n_modes; ++i)
    values.push_back(node_numbers.next("a mode shape's entry"));
  data.shapes = Eigen::Map<const Eigen::MatrixXd>(values.data(), 6 * n_nodes, n_modes);
  node_numbers.end(fmt::format("{} mode shapes at {} nodes", n_modes, n_nodes));
  for (std::size_t k = 0; k < element.loads.size(); ++k) {
    FlexData::LoadLine load = read_load(reader, element.loads[k], data, static_cast<int>(k) + 1);
    if (std::ranges::find(data.loads, load.id, &FlexData::LoadLine::id) != data.loads.end())
      reader.fail(element.loads[k].numbers.begin, fmt::format("the loadcase_id {} is given twice", load.id));
    data.loads.push_back(std::move(load));
  }
  data.body = flexdata::body_in_comment(whole, element, n_nodes, n_modes, data.loads);
  return data;
}

}  // namespace flexura::superelement
