// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/builder.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>
#include <tuple>

#include "mbs/base/files/plain_text.hpp"
#include "mesh/model/cells/cell.hpp"
#include "mesh/model/geometry.hpp"
#include "mesh/model/patches.hpp"

namespace flexura::mesh {
void Unused::add(const std::string& card, const Where& where) {
  const auto [at, is_new] = place_.try_emplace(card, entries_.size());
  if (is_new)
    entries_.push_back({card, where.text(), 1});
  else
    ++entries_[at->second].count;
}

std::vector<std::string> Unused::messages(const std::string& noun) const {
  std::vector<std::string> out;
  constexpr std::size_t most = 30;
  for (const Entry& entry : entries_) {
    if (out.size() == most) {
      out.push_back(fmt::format("{} more {}s of other kinds are not used", entries_.size() - most, noun));
      break;
    }
    out.push_back(fmt::format("{} {}{} {} {} not used (first in {})", entry.count, noun,
                              entry.count > 1 ? "s" : "", entry.card.substr(0, 60),
                              entry.count > 1 ? "are" : "is", entry.first));
  }
  return out;
}

std::vector<std::string> Unused::remarks() const {
  std::vector<std::string> out;
  for (const Entry& entry : entries_)
    out.push_back(fmt::format("{}{} (first in {})",
                              entry.count > 1 ? fmt::format("{} times ", entry.count) : "", entry.card,
                              entry.first));
  return out;
}

void Faults::add(const std::string& text) {
  std::string kind;
  const std::size_t at = text.find(", line ");
  for (const char c : text.substr(at == std::string::npos ? 0 : at))
    if (!std::isdigit(static_cast<unsigned char>(c))) kind += c;
  const auto [place, is_new] = place_.try_emplace(kind, kinds_.size());
  if (is_new)
    kinds_.emplace_back(text, 1);
  else
    ++kinds_[place->second].second;
}

void Faults::raise() const {
  if (kinds_.empty()) return;
  constexpr std::size_t most = 20;
  std::string out;
  const auto line = [](const std::pair<std::string, int>& kind) {
    return kind.second == 1 ? kind.first
                            : fmt::format("{} (and {} more of this kind)", kind.first, kind.second - 1);
  };
  if (kinds_.size() == 1) throw std::invalid_argument(line(kinds_.front()));
  for (std::size_t k = 0; k < std::min(most, kinds_.size()); ++k) out += "\n  " + line(kinds_[k]);
  if (kinds_.size() > most) out += fmt::format("\n  and {} kinds more", kinds_.size() - most);
  throw std::invalid_argument(fmt::format("{} kinds of faults stop the deck:{}", kinds_.size(), out));
}

void require_file(const std::filesystem::path& path) {
  std::error_code ignored;
  const auto status = std::filesystem::status(path, ignored);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw std::invalid_argument(path.string() + ": is no file; name the file itself");
}

std::string plain_line(std::string line, const Where& where) {
  if (line.find('\0') != std::string::npos)
    throw std::invalid_argument(where.text() + ": holds a zero character; a text file is wanted");
  const bool is_plain = std::ranges::none_of(
      line, [](unsigned char c) { return c >= 0x7F || (c < 0x20 && c != '\t' && c != '\r'); });
  return is_plain ? line : files::plain_text(line);
}

void Implied::add(std::size_t n, const Where& where) {
  constexpr std::size_t most = 20'000'000;
  total_ += std::min(n, most + 1);
  if (total_ > most)
    throw std::invalid_argument(
        fmt::format("{}: generated sets, sets of sets, THRU and instances stand for more than {} nodes and "
                    "elements in all; are "
                    "their limits right?",
                    where.text(), most));
}

void require_positive(double value, const std::string& of, const char* what, const Where& where) {
  if (!(value > 0 && std::isfinite(value)))
    throw std::invalid_argument(
        fmt::format("{}: {} has the {} {:g}; it must be above 0", where.text(), of, what, value));
}

void require_not_negative(double value, const std::string& of, const char* what, const Where& where) {
  if (!(value >= 0 && std::isfinite(value)))
    throw std::invalid_argument(
        fmt::format("{}: {} has the {} {:g}; it must be at least 0", where.text(), of, what, value));
}

void require(bool good, const std::string& what) {
  if (!good) throw std::invalid_argument(what);
}

void require_mass(const ImportedMass& mass, const std::string& of, const Where& where) {
  if (mass.inertia.isZero(0.0)) return require_positive(mass.mass, of, "mass", where);
  require_not_negative(mass.mass, of, "mass", where);
  const Eigen::Vector3d I =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(mass.inertia, Eigen::EigenvaluesOnly).eigenvalues();
  // Figures come with five digits and more (reduce/assembly/point_mass.cpp).
  if (!(I[0] + I[1] >= (1 - 1e-5) * I[2]))
    throw std::invalid_argument(fmt::format(
        "{}: {} has the principal moments of inertia {:g}, {:g}, {:g}; none may exceed the sum of the others",
        where.text(), of, I[0], I[1], I[2]));
}

void require_section(const ImportedBar& bar, const std::string& of, const Where& where) {
  require_positive(bar.A, of, "area", where);
  require_not_negative(bar.I_yy, of, "second moment of area I_yy", where);
  require_not_negative(bar.I_zz, of, "second moment of area I_zz", where);
  require_not_negative(bar.J, of, "torsion constant", where);
  require_not_negative(bar.kappa_y, of, "shear factor", where);
  require_not_negative(bar.kappa_z, of, "shear factor", where);
  // Decks print six digits: a section without width across its weak axis may miss equality by their rounding.
  if (!(bar.I_yz * bar.I_yz <= (1 + 1e-5) * bar.I_yy * bar.I_zz))
    throw std::invalid_argument(
        fmt::format("{}: {} has the product of area I_yz = {:g}; its square must be at most I_yy I_zz = {:g}",
                    where.text(), of, bar.I_yz, bar.I_yy * bar.I_zz));
}

Index ModelBuilder::add_node(int scope, std::int64_t label, const Eigen::Vector3d& x, const Where& where) {
  const auto number = static_cast<Index>(points_.size());
  if (!numbers_.emplace(std::pair{scope, label}, number).second)
    throw std::invalid_argument(
        fmt::format("{}: node {} is given twice; node numbers must be unique", where.text(), label));
  // In any unit of length farther away than the sun: squares and cubes of it would leave the numbers.
  constexpr double farthest = 1e15;
  if (!(x.cwiseAbs().maxCoeff() <= farthest))
    throw std::invalid_argument(fmt::format(
        "{}: node {} has a coordinate that is no number, or beyond all measure", where.text(), label));
  constexpr std::size_t most = 100'000'000;
  if (points_.size() >= most)
    throw std::invalid_argument(
        fmt::format("{}: more than {} nodes; no memory holds them", where.text(), most));
  points_.push_back(x);
  labels_.push_back(label);
  return number;
}

Index ModelBuilder::node(int scope, std::int64_t label, const Where& where) const {
  const auto found = numbers_.find({scope, label});
  if (found == numbers_.end())
    throw std::invalid_argument(fmt::format("{}: node {} does not exist", where.text(), label));
  return found->second;
}

std::size_t ModelBuilder::add_cell(int scope, CellType type, std::int64_t label, std::vector<Index> nodes,
                                   const Where& where) {
  const auto number = static_cast<Index>(cells_.size());
  if (!cell_numbers_.emplace(std::pair{scope, label}, number).second)
    throw std::invalid_argument(
        fmt::format("{}: element {} is given twice; element numbers must be unique", where.text(), label));
  std::vector<Index> sorted = nodes;
  std::erase(sorted, -1);
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end())
    throw std::invalid_argument(fmt::format(
        "{}: element {} names a node twice; collapsed elements cannot be used", where.text(), label));
  cells_.push_back({.type = type, .label = label, .nodes = std::move(nodes), .material = -1, .where = where});
  return static_cast<std::size_t>(number);
}

void ModelBuilder::join(const std::map<Index, Index>& same) {
  const auto replace = [&](Index& node) {
    if (const auto found = same.find(node); found != same.end()) node = found->second;
  };
  for (auto& [label, node] : numbers_) replace(node);
  for (Cell& cell : cells_)
    for (Index& node : cell.nodes) replace(node);
  for (auto& [name, nodes] : sets_)
    for (Index& node : nodes) replace(node);
}

void ModelBuilder::add_to_set(const std::string& name, const std::vector<Index>& nodes) {
  std::vector<Index>& set = sets_[name];
  set.insert(set.end(), nodes.begin(), nodes.end());
}

const char* ModelBuilder::split_shells() {
  return "each split into shells of three or four nodes between its own: as good as such a mesh of half the "
         "size, not as a "
         "quadratic element";
}

void ModelBuilder::split_quadratic_shells() {
  std::vector<Cell> cells;
  cells.reserve(cells_.size());
  for (const Cell& cell : cells_) {
    if (cell.type != CellType::tri6 && cell.type != CellType::quad8) {
      cells.push_back(cell);
      continue;
    }
    const std::size_t n = cell.type == CellType::quad8 ? 4 : 3;
    const auto add = [&](std::vector<Index> nodes) {
      Cell part = cell;
      part.type = nodes.size() == 4 ? CellType::quad4 : CellType::tri3;
      part.nodes = std::move(nodes);
      cells.push_back(std::move(part));
    };
    const auto add_point = [&](const Eigen::Vector3d& x) {
      points_.push_back(x);
      labels_.push_back(-1);
      return static_cast<Index>(points_.size() - 1);
    };
    const auto c = [&](std::size_t k) { return cell.nodes[k % n]; };
    const auto m = [&](std::size_t k) { return cell.nodes[n + (k + n) % n]; };  // between corners k and k + 1
    const auto lacking =
        std::count(cell.nodes.begin() + static_cast<std::ptrdiff_t>(n), cell.nodes.end(), -1);
    Eigen::Vector3d corners = Eigen::Vector3d::Zero(), middles = corners;
    for (std::size_t k = 0; k < n; ++k) {
      corners += place(c(k));
      if (m(k) >= 0) middles += place(m(k));
    }
    if (lacking == static_cast<std::ptrdiff_t>(n)) {
      add({cell.nodes.begin(), cell.nodes.begin() + static_cast<std::ptrdiff_t>(n)});
    } else if (lacking > 0) {  // a fan about the middle
      const Index centre = add_point(corners / static_cast<double>(n));
      for (std::size_t k = 0; k < n; ++k) {
        if (m(k) < 0) {
          add({centre, c(k), c(k + 1)});
          continue;
        }
        add({centre, c(k), m(k)});
        add({centre, m(k), c(k + 1)});
      }
    } else if (n == 3) {
      for (std::size_t k = 0; k < 3; ++k) add({c(k), m(k), m(k + 2)});
      add({m(0), m(1), m(2)});
    } else {  // the serendipity element's own centre
      const Index centre = add_point(0.5 * middles - 0.25 * corners);
      for (std::size_t k = 0; k < 4; ++k) add({c(k), m(k), centre, m(k + 3)});
    }
  }
  cells_ = std::move(cells);
}

void ModelBuilder::finish(ImportedModel& model) {
  split_quadratic_shells();
  mend_solids(model);
  Mesh& mesh = model.mesh;
  mesh = Mesh();
  std::vector<Index> number(points_.size(), -1);
  for (const Cell& cell : cells_)
    for (const Index node : cell.nodes) number[node] = 0;
  each_attached_node(model, [&](Index& node) { number[node] = 0; });
  Index n = 0;
  for (Index& k : number)
    if (k == 0) k = n++;
  mesh.points.resize(n, 3);
  mesh.node_label.resize(static_cast<std::size_t>(n));
  for (std::size_t k = 0; k < number.size(); ++k)
    if (number[k] >= 0) {
      mesh.points.row(number[k]) = points_[k].transpose();
      mesh.node_label[static_cast<std::size_t>(number[k])] = labels_[k];
    }
  if (const std::size_t dropped = number.size() - static_cast<std::size_t>(n); dropped > 0)
    model.messages.push_back(fmt::format("{} node{} to no element and {} left out", dropped,
                                         dropped == 1 ? " belongs" : "s belong",
                                         dropped == 1 ? "is" : "are"));

  using Kind = std::pair<CellType, CellVariant>;
  std::vector<Kind> kinds;
  std::size_t with_material = 0;
  for (const Cell& cell : cells_) {
    if (const Kind kind{cell.type, cell.variant}; std::find(kinds.begin(), kinds.end(), kind) == kinds.end())
      kinds.push_back(kind);
    with_material += cell.material >= 0;
  }
  if (with_material > 0 && with_material < cells_.size()) {
    const auto bare =
        std::find_if(cells_.begin(), cells_.end(), [](const Cell& c) { return c.material < 0; });
    throw std::invalid_argument(
        fmt::format("{}: element {} has no section or material, as {} others; others have one",
                    bare->where.text(), bare->label, cells_.size() - with_material - 1));
  }
  for (const Kind& kind : kinds) {
    CellBlock block;
    std::tie(block.type, block.variant) = kind;
    const auto rows = std::count_if(cells_.begin(), cells_.end(), [&](const Cell& c) {
      return Kind{c.type, c.variant} == kind;
    });
    block.nodes.resize(rows, nodes_per_cell(block.type));
    const bool is_shell = dimension_of(block.type) == 2;
    Index row = 0;
    for (const Cell& cell : cells_) {
      if (Kind{cell.type, cell.variant} != kind) continue;
      for (std::size_t k = 0; k < cell.nodes.size(); ++k)
        block.nodes(row, static_cast<Eigen::Index>(k)) = number[cell.nodes[k]];
      block.label.push_back(cell.label);
      if (with_material > 0) block.material.push_back(cell.material);
      if (is_shell) {
        if (!(cell.thickness > 0 && std::isfinite(cell.thickness)))
          throw std::invalid_argument(fmt::format(
              "{}: shell element {} has the thickness {:g}; it must be above 0 (*SHELL SECTION, T of PSHELL)",
              cell.where.text(), cell.label, cell.thickness));
        block.thickness.push_back(cell.thickness);
        block.offset.push_back(cell.offset);
      }
      ++row;
    }
    if (std::ranges::all_of(block.offset, [](double offset) { return offset == 0; })) block.offset.clear();
    (is_shell ? mesh.shells : mesh.solids).push_back(std::move(block));
  }
  for (const auto& [name, nodes] : sets_) {
    NodeSet set;
    for (const Index node : nodes)
      if (number[node] >= 0) set.nodes.push_back(number[node]);
    std::sort(set.nodes.begin(), set.nodes.end());
    set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
    if (!set.nodes.empty()) mesh.sets[name] = std::move(set);
  }
  extract_boundary(mesh);
  attach_faces_to_sets(mesh);
  each_attached_node(model, [&](Index& node) { node = number[node]; });
  for (auto* dofs : {&model.fixed, &model.kept}) {
    for (ImportedDofs& entry : *dofs) entry.node = number[entry.node];
    std::erase_if(*dofs, [](const ImportedDofs& entry) { return entry.node < 0; });
  }
}

}  // namespace flexura::mesh
