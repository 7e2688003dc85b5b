// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <optional>
#include <set>
#include <stdexcept>

#include "mesh/import/abaqus_keywords.hpp"
#include "mesh/import/bar_sections.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/model/cell.hpp"

namespace flexura::mesh {
namespace {

namespace fs = std::filesystem;

/// An Abaqus solid element: its shape and what its letters mean here.
struct SolidType {
  CellType shape;
  CellVariant variant = CellVariant::standard;
  std::string replaced;  ///< what is computed instead and what it does; empty where it is that element
};

/// Variants (reduced, hybrid, incompatible, modified) share nodes and shape functions.
SolidType variant_of(CellType shape, const std::string& letters) {
  const bool reduced = letters.find('R') != std::string::npos;
  const bool hybrid = letters.find('H') != std::string::npos;
  const bool incompatible = letters.find('I') != std::string::npos;
  SolidType type{shape, CellVariant::standard, ""};
  if (reduced && shape == CellType::hex20) {
    type.variant = CellVariant::reduced;
  } else if (reduced) {
    type.replaced =
        "integrated in full, without hourglass control: stiffer, in bending of linear elements by far";
  } else if (incompatible && shape == CellType::hex8) {
    type.variant = CellVariant::bubbles;
  } else if (shape == CellType::hex8 && letters.empty()) {
    type.replaced =
        "integrated in full where Abaqus takes the mean volume change of the element: the same but for "
        "Poisson's "
        "ratios near 0.5, where it is stiffer";
  } else if (letters.find('M') != std::string::npos) {
    type.replaced = "taken as the standard element, not the modified one: slightly stiffer";
  } else if (letters.find('V') != std::string::npos) {
    type.replaced = "taken with as many nodes as the line has, integrated in full";
  }
  if (hybrid)
    type.replaced +=
        std::string(type.replaced.empty() ? "" : "; ") +
        "in displacements alone: the same but for Poisson's ratios near 0.5, where it is stiffer";
  return type;
}

/// "C3D8R" -> hex8.
std::optional<SolidType> solid_type(const std::string& name) {
  const std::string type = upper(name);
  std::size_t digits = 3;
  if (type.rfind("C3D", 0) != 0 && type.rfind("DC3D", 0) != 0) return {};
  if (type[0] == 'D') return {};
  while (digits < type.size() && std::isdigit(static_cast<unsigned char>(type[digits]))) ++digits;
  static const std::map<std::string, CellType> kTypes = {
      {"4", CellType::tet4},   {"10", CellType::tet10}, {"8", CellType::hex8},     {"20", CellType::hex20},
      {"27", CellType::hex27}, {"6", CellType::wedge6}, {"15", CellType::wedge15}, {"5", CellType::pyramid5}};
  const auto found = kTypes.find(type.substr(3, digits - 3));
  if (found == kTypes.end()) return {};
  return variant_of(found->second, type.substr(digits));
}

/// "S4R" -> quad4.  Conventional shells of six dofs a node; reduced ones and those of five dofs are computed as the full.
std::optional<SolidType> shell_type(const std::string& name) {
  static const std::map<std::string, CellType> kTypes = {
      {"S3", CellType::tri3},   {"S3R", CellType::tri3},   {"S3RS", CellType::tri3},  {"STRI3", CellType::tri3},
      {"S4", CellType::quad4},  {"S4R", CellType::quad4},  {"S4RS", CellType::quad4}, {"S4RSW", CellType::quad4},
      {"S4R5", CellType::quad4}, {"S8", CellType::quad8},   {"S8R", CellType::quad8},  {"S8R5", CellType::quad8},
      {"S6", CellType::tri6},   {"STRI65", CellType::tri6}};
  const auto found = kTypes.find(upper(name));
  if (found == kTypes.end()) return {};
  const bool quadratic = found->second == CellType::quad8 || found->second == CellType::tri6;
  return SolidType{found->second, CellVariant::standard, quadratic ? ModelBuilder::split_shells() : ""};
}

/// Abaqus numbers hex27's centre first and then faces -z, +z, -y, +x, +y, -x.
std::vector<std::int64_t> in_mesh_order(CellType type, const std::vector<std::int64_t>& n) {
  if (type != CellType::hex27) return n;
  std::vector<std::int64_t> out(n.begin(), n.begin() + 20);
  for (const int k : {26, 24, 23, 25, 21, 22, 20}) out.push_back(n[static_cast<std::size_t>(k)]);
  return out;
}

struct ElementLine {
  CellType type;
  CellVariant variant;
  std::int64_t label;
  std::vector<std::int64_t> nodes;
  Where where;
};
struct NodeLine {
  std::int64_t label;
  Eigen::Vector3d x;
  Where where;
};
struct Section {
  std::string set, material;
  Where where;
  double thickness = 0, offset = 0;  // of shells
  double area = 0;                   // of trusses
  std::optional<BarSection> bar = {};
  Eigen::Vector3d n1 = -Eigen::Vector3d::UnitZ();  // of beams: their direction 1
};
/// Elements that are no cells: beams, trusses, point masses, springs.
struct OtherElement {
  std::string type;
  std::int64_t label;
  std::vector<std::int64_t> nodes;
  Where where;
};
/// *MASS, *ROTARY INERTIA, *SPRING: numbers for the elements of a set.
struct ElementData {
  std::string kind, set;
  std::vector<double> values;
  Where where;
};
/// *COUPLING, *RIGID BODY, *MPC.
struct TieKeyword {
  std::string what, reference, set;  // what: COUPLING (of a surface), RIGID BODY (of a node set), MPC (of a node or set)
  ImportedTie::Kind kind = ImportedTie::Kind::rigid;
  std::array<bool, 6> dofs{true, true, true, true, true, true};
  Where where;
};
struct Surface {
  Where where;
  bool of_nodes = false, used = false;
  std::vector<std::pair<std::string, std::string>> entries;  // set or label, face
};

/// How many nodes the elements have that are no cells.
const std::map<std::string, std::size_t>& other_elements() {
  static const std::map<std::string, std::size_t> kTypes = {{"B31", 2},  {"B31H", 2}, {"B33", 2},    {"B33H", 2},
                                                            {"T3D2", 2}, {"MASS", 1}, {"ROTARYI", 1}, {"SPRINGA", 2}};
  return kTypes;
}

/// The corners of a solid's face S1, S2, ... (from 0), in Abaqus' numbering.
std::vector<int> face_corners(CellType type, int face) {
  static const std::map<int, std::vector<std::vector<int>>> kFaces = {
      {4, {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}},
      {6, {{0, 1, 2}, {3, 5, 4}, {0, 3, 4, 1}, {1, 4, 5, 2}, {2, 5, 3, 0}}},
      {8, {{0, 1, 2, 3}, {4, 7, 6, 5}, {0, 4, 5, 1}, {1, 5, 6, 2}, {2, 6, 7, 3}, {3, 7, 4, 0}}}};
  const auto found = kFaces.find(shape_of(type).corners);
  if (found == kFaces.end() || face < 0 || face >= static_cast<int>(found->second.size())) return {};
  return found->second[static_cast<std::size_t>(face)];
}

/// What a part (or the model level) holds, by label.
struct Part {
  std::string name;
  std::vector<NodeLine> nodes;
  std::vector<ElementLine> elements;
  std::map<std::string, std::vector<std::int64_t>> node_sets, element_sets;
  std::vector<Section> sections;
  std::vector<OtherElement> others;
  std::vector<ElementData> data;
};

struct Instance {
  std::string name;
  int part = -1;
  Part own;  // nodes and elements given in the instance itself
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t = Eigen::Vector3d::Zero();
};

struct AssemblySet {
  std::string name, instance;
  bool of_nodes;
  std::vector<std::int64_t> labels;
  std::vector<std::string> names;
  Where where;
};

class Reader {
 public:
  ImportedModel read(const fs::path& path) {
    const std::vector<Keyword> keywords = read_keywords(path, file_names_);
    parts_.emplace_back();  // 0: the model level of a flat file
    for (const Keyword& keyword : keywords) take(keyword);
    return build(path);
  }

 private:
  Part& here() { return instance_ ? instance_->own : parts_[static_cast<std::size_t>(part_)]; }

  /// The name as the file first spelt it: labels are compared without case.
  std::string known(const std::string& name) { return spelling_.emplace(upper(name), name).first->second; }

  void take(const Keyword& k) {
    if (in_step_) {
      in_step_ = k.name != "END STEP";
      return;
    }
    if (k.name != "DENSITY" && k.name != "ELASTIC" && k.name != "MATERIAL" && k.name != "DAMPING")
      in_material_ = false;
    if (k.name == "STEP")
      in_step_ = true;
    else if (k.name == "PART") {
      parts_.emplace_back();
      parts_.back().name = upper(k.get("NAME"));
      part_ = static_cast<int>(parts_.size()) - 1;
    } else if (k.name == "END PART")
      part_ = 0;
    else if (k.name == "ASSEMBLY")
      in_assembly_ = true;
    else if (k.name == "END ASSEMBLY")
      in_assembly_ = false;
    else if (k.name == "INSTANCE")
      start_instance(k);
    else if (k.name == "END INSTANCE")
      instance_ = nullptr;
    else if (k.name == "NODE")
      take_nodes(k);
    else if (k.name == "ELEMENT")
      take_elements(k);
    else if (k.name == "NSET" || k.name == "ELSET")
      take_set(k);
    else if (k.name == "SOLID SECTION")
{
      Section section{known(k.get("ELSET")), known(k.get("MATERIAL")), k.where};
      if (const std::vector<double> area = numbers_of(k, 0); !area.empty()) section.area = area[0];
      here().sections.push_back(section);
    }
    else if (k.name == "SHELL SECTION" || k.name == "SHELL GENERAL SECTION")
      take_shell_section(k);
    else if (k.name == "BEAM SECTION" || k.name == "BEAM GENERAL SECTION")
      take_beam_section(k);
    else if (k.name == "MASS" || k.name == "ROTARY INERTIA" || k.name == "SPRING") {
      std::vector<double> values = numbers_of(k, k.name == "SPRING" && k.data.size() > 1 ? 1 : 0);
      here().data.push_back({k.name, known(k.get("ELSET")), std::move(values), k.where});
    } else if (k.name == "COUPLING" || k.name == "RIGID BODY")
      take_coupling(k);
    else if (k.name == "KINEMATIC" || k.name == "DISTRIBUTING")
      take_coupled_dofs(k);
    else if (k.name == "MPC")
      take_mpc(k);
    else if (k.name == "SURFACE")
      take_surface(k);
    else if (k.name == "MATERIAL") {
      model_.materials.emplace_back();
      model_.materials.back().name = known(k.get("NAME"));
      in_material_ = true;
    } else if (k.name == "DENSITY" && in_material_) {
      model_.materials.back().rho = to_real(field(k, 0, 0), k.where);
    } else if (k.name == "ELASTIC" && in_material_)
      take_elastic(k);
    else if (k.name != "HEADING" && k.name != "PREPRINT" && k.name != "RESTART")
      unused_.add("*" + k.name, k.where);
  }

  static const std::string& field(const Keyword& k, std::size_t line, std::size_t column) {
    if (line >= k.data.size() || column >= k.data[line].fields.size())
      throw std::invalid_argument(fmt::format("{}: *{} wants {} numbers on data line {}", k.where.text(),
                                              k.name, column + 1, line + 1));
    return k.data[line].fields[column];
  }

  void start_instance(const Keyword& k) {
    auto instance = std::make_unique<Instance>();
    instance->name = known(k.get("NAME"));
    const std::string wanted = upper(k.get("PART"));
    for (std::size_t p = 1; p < parts_.size(); ++p)
      if (parts_[p].name == wanted) instance->part = static_cast<int>(p);
    if (instance->part < 0)
      throw std::invalid_argument(
          fmt::format("{}: *INSTANCE of a part \"{}\" that is not defined", k.where.text(), k.get("PART")));
    const auto numbers = [&](std::size_t line, std::size_t n) {
      Eigen::VectorXd v(n);
      for (std::size_t i = 0; i < n; ++i)
        v[static_cast<Eigen::Index>(i)] = to_real(field(k, line, i), k.data[line].where);
      return v;
    };
    if (!k.data.empty()) instance->t = numbers(0, 3);
    if (k.data.size() >
        1) {  // rotation by an angle (degrees) about a line through two points, after the translation
      const Eigen::VectorXd r = numbers(1, 7);
      const Eigen::Vector3d a = r.head<3>(), b = r.segment<3>(3);
      instance->R = Eigen::AngleAxisd(r[6] * std::numbers::pi / 180, (b - a).normalized()).toRotationMatrix();
      instance->t = a + instance->R * (instance->t - a);
    }
    instances_.push_back(std::move(instance));
    instance_ = instances_.back().get();
  }

  void take_nodes(const Keyword& k) {
    if (k.has("SYSTEM") && upper(k.get("SYSTEM")) != "R")
      throw std::invalid_argument(
          k.where.text() +
          ": *NODE in a cylindrical or spherical SYSTEM is not read; export in rectangular coordinates");
    Part& part = here();
    for (const DataLine& line : k.data) {
      if (line.fields.empty()) continue;
      NodeLine node{to_integer(line.fields[0], line.where), Eigen::Vector3d::Zero(), line.where};
      for (std::size_t i = 1; i < std::min<std::size_t>(4, line.fields.size()); ++i)
        if (!line.fields[i].empty())
          node.x[static_cast<Eigen::Index>(i) - 1] = to_real(line.fields[i], line.where);
      part.nodes.push_back(node);
      if (k.has("NSET")) part.node_sets[known(k.get("NSET"))].push_back(node.label);
    }
  }

  void take_elements(const Keyword& k) {
    std::optional<SolidType> solid = solid_type(k.get("TYPE"));
    if (!solid) solid = shell_type(k.get("TYPE"));
    if (const auto other = other_elements().find(upper(k.get("TYPE"))); other != other_elements().end()) {
      take_others(k, other->second);
      return;
    }
    if (!solid) {
      for (const DataLine& line : k.data) left_out_.add(k.get("TYPE"), line.where);
      return;
    }
    Part& part = here();
    const CellType type = solid->shape;
    if (!solid->replaced.empty()) {
      auto& [count, effect] = replaced_[upper(k.get("TYPE"))];
      count += k.data.size();
      effect = solid->replaced;
    }
    const auto n = static_cast<std::size_t>(nodes_per_cell(type));
    for (const DataLine& line : k.data) {
      if (line.fields.empty()) continue;
      ElementLine element{type, solid->variant, to_integer(line.fields[0], line.where), {}, line.where};
      if (line.fields.size() != n + 1)
        throw std::invalid_argument(fmt::format("{}: element {} of type {} has {} nodes instead of {}",
                                                line.where.text(), element.label, k.get("TYPE"),
                                                line.fields.size() - 1, n));
      for (std::size_t i = 1; i <= n; ++i) element.nodes.push_back(to_integer(line.fields[i], line.where));
      element.nodes = in_mesh_order(type, element.nodes);
      part.elements.push_back(element);
      if (k.has("ELSET")) part.element_sets[known(k.get("ELSET"))].push_back(element.label);
    }
  }

  void take_others(const Keyword& k, std::size_t n) {
    Part& part = here();
    for (const DataLine& line : k.data) {
      if (line.fields.empty()) continue;
      OtherElement element{upper(k.get("TYPE")), to_integer(line.fields[0], line.where), {}, line.where};
      // A third node of a beam gives its direction 1.
      if (line.fields.size() < n + 1)
        throw std::invalid_argument(fmt::format("{}: element {} of type {} has {} nodes instead of {}",
                                                line.where.text(), element.label, element.type,
                                                line.fields.size() - 1, n));
      for (std::size_t i = 1; i < line.fields.size() && i <= n + (n == 2 ? 1 : 0); ++i)
        if (!line.fields[i].empty()) element.nodes.push_back(to_integer(line.fields[i], line.where));
      if (k.has("ELSET")) part.element_sets[known(k.get("ELSET"))].push_back(element.label);
      part.others.push_back(std::move(element));
    }
  }

  static std::vector<double> numbers_of(const Keyword& k, std::size_t line) {
    std::vector<double> out;
    if (line < k.data.size())
      for (const std::string& text : k.data[line].fields)
        out.push_back(text.empty() ? 0.0 : to_real(text, k.data[line].where));
    return out;
  }

  void take_beam_section(const Keyword& k) {
    Section section{known(k.get("ELSET")), known(k.get("MATERIAL")), k.where};
    const std::string type = upper(k.has("SECTION") ? k.get("SECTION") : "GENERAL");
    const std::vector<double> dim = numbers_of(k, 0), n1 = numbers_of(k, 1);
    try {
      if (k.name == "BEAM GENERAL SECTION" && type == "GENERAL") {
        if (dim.size() < 5) throw std::invalid_argument("A, I11, I12, I22 and J are wanted");
        section.bar = BarSection{.A = dim[0], .I_yy = dim[1], .I_zz = dim[3], .I_yz = dim[2], .J = dim[4]};
      } else {
        section.bar = abaqus_section(type, dim);
      }
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument(fmt::format("{}: *{}: {}", k.where.text(), k.name, error.what()));
    }
    if (n1.size() >= 3) section.n1 = Eigen::Vector3d(n1[0], n1[1], n1[2]);
    if (k.name == "BEAM GENERAL SECTION") {  // brings its own material
      const std::vector<double> moduli = numbers_of(k, 2);
      if (moduli.size() < 2 || !(moduli[0] > 0) || !(moduli[1] > 0))
        throw std::invalid_argument(k.where.text() + ": *BEAM GENERAL SECTION without E and G is not read");
      section.material = known("section of " + section.set);
      ImportedMaterial material;
      material.name = section.material;
      material.E = moduli[0], material.nu = moduli[0] / (2 * moduli[1]) - 1;
      material.rho = k.has("DENSITY") ? to_real(k.get("DENSITY"), k.where) : 0;
      model_.materials.push_back(material);
    }
    here().sections.push_back(section);
  }

  void take_coupling(const Keyword& k) {
    TieKeyword tie{.what = k.name, .reference = k.get("REF NODE"), .where = k.where};
    if (k.name == "COUPLING") {
      tie.set = upper(k.get("SURFACE"));
      if (k.has("ORIENTATION")) unused_.add("*COUPLING's ORIENTATION", k.where);
    } else {
      for (const char* word : {"TIE NSET", "PIN NSET", "ELSET"})
        if (k.has(word)) {
          tie.set = upper(k.get(word));
          if (std::string(word) == "PIN NSET") tie.dofs = {true, true, true, false, false, false};
        }
      if (k.has("ANALYTICAL SURFACE") || tie.set.empty()) {
        unused_.add("*RIGID BODY without TIE NSET, PIN NSET or ELSET", k.where);
        return;
      }
    }
    ties_.push_back(std::move(tie));
  }

  // The lines "first dof, last dof" after *KINEMATIC and *DISTRIBUTING.
  void take_coupled_dofs(const Keyword& k) {
    if (ties_.empty() || ties_.back().what != "COUPLING")
      throw std::invalid_argument(fmt::format("{}: *{} without *COUPLING before it", k.where.text(), k.name));
    TieKeyword& tie = ties_.back();
    if (k.name == "DISTRIBUTING") tie.kind = ImportedTie::Kind::average;
    if (k.has("WEIGHTING METHOD") && upper(k.get("WEIGHTING METHOD")) != "UNIFORM")
      unused_.add("*DISTRIBUTING's WEIGHTING METHOD", k.where);
    if (k.data.empty()) return;
    tie.dofs.fill(false);
    for (const DataLine& line : k.data) {
      if (line.fields.empty() || line.fields[0].empty()) continue;
      const std::int64_t first = to_integer(line.fields[0], line.where),
                         last = line.fields.size() > 1 && !line.fields[1].empty() ? to_integer(line.fields[1], line.where)
                                                                                  : first;
      for (std::int64_t d = std::max<std::int64_t>(first, 1); d <= std::min<std::int64_t>(last, 6); ++d)
        tie.dofs[static_cast<std::size_t>(d - 1)] = true;
    }
  }

  void take_mpc(const Keyword& k) {
    for (const DataLine& line : k.data) {
      if (line.fields.size() < 3) continue;
      const std::string type = upper(line.fields[0]);
      if (type != "BEAM" && type != "TIE" && type != "PIN") {
        unused_.add("*MPC of type " + type, line.where);
        continue;
      }
      TieKeyword tie{.what = "MPC", .reference = line.fields[2], .set = line.fields[1], .where = line.where};
      if (type == "PIN") tie.dofs = {true, true, true, false, false, false};
      ties_.push_back(std::move(tie));
    }
  }

  void take_surface(const Keyword& k) {
    Surface surface;
    surface.where = k.where;
    surface.of_nodes = upper(k.get("TYPE")) == "NODE";
    for (const DataLine& line : k.data)
      if (!line.fields.empty() && !line.fields[0].empty())
        surface.entries.emplace_back(line.fields[0], line.fields.size() > 1 ? upper(line.fields[1]) : "");
    surfaces_[upper(k.get("NAME"))] = std::move(surface);
  }

  void take_set(const Keyword& k) {
    const bool of_nodes = k.name == "NSET";
    AssemblySet set{
        known(k.get(of_nodes ? "NSET" : "ELSET")), upper(k.get("INSTANCE")), of_nodes, {}, {}, k.where};
    for (const DataLine& line : k.data) {
      if (line.fields.empty()) continue;
      if (k.has("GENERATE")) {
        const std::int64_t first = to_integer(line.fields[0], line.where),
                           last = to_integer(line.fields.size() > 1 ? line.fields[1] : line.fields[0],
                                             line.where),
                           step = line.fields.size() > 2 ? to_integer(line.fields[2], line.where) : 1;
        if (step <= 0)
          throw std::invalid_argument(line.where.text() +
                                      ": the increment of a generated set must be greater than zero");
        constexpr std::int64_t most = 100'000'000;  // labels: more elements than fit into any memory
        if (first < 0 || last > most * std::min<std::int64_t>(step, 1000))
          throw std::invalid_argument(fmt::format(
              "{}: a generated set from {} to {} by {}: labels lie between 0 and {}, at most {} in a set",
              line.where.text(), first, last, step, most * 1000, most));
        for (std::int64_t label = first; label <= last; label += step) set.labels.push_back(label);
        continue;
      }
      for (const std::string& entry : line.fields) {
        if (entry.empty()) continue;
        if (const auto label = as_integer(entry))
          set.labels.push_back(*label);
        else
          set.names.push_back(known(entry));
      }
    }
    if (in_assembly_ && !instance_) {
      assembly_sets_.push_back(std::move(set));
      return;
    }
    auto& sets = of_nodes ? here().node_sets : here().element_sets;
    for (const std::string& name : set.names) {
      const auto found = sets.find(name);
      if (found == sets.end())
        throw std::invalid_argument(fmt::format("{}: set \"{}\" names a set \"{}\" that is not defined",
                                                k.where.text(), set.name, name));
      set.labels.insert(set.labels.end(), found->second.begin(), found->second.end());
    }
    auto& own = sets[set.name];
    own.insert(own.end(), set.labels.begin(), set.labels.end());
    if (set.names.empty()) return;
    // Sets of sets, a set of itself among them, would double with each line.
    std::ranges::sort(own);
    const auto again = std::ranges::unique(own);
    own.erase(again.begin(), again.end());
  }

  void take_shell_section(const Keyword& k) {
    if (k.has("COMPOSITE"))
      throw std::invalid_argument(k.where.text() +
                                  ": *" + k.name + ", COMPOSITE is not read; layers of one material are");
    if (!k.has("MATERIAL"))
      throw std::invalid_argument(k.where.text() + ": *" + k.name + " without MATERIAL is not read");
    Section section{known(k.get("ELSET")), known(k.get("MATERIAL")), k.where};
    section.thickness = to_real(field(k, 0, 0), k.where);
    require_positive(section.thickness, "*" + k.name, "thickness", k.where);
    if (k.has("OFFSET")) {  // of the reference surface (the nodes) from the middle, in thicknesses along the normal
      const std::string offset = upper(k.get("OFFSET"));
      const double fraction = offset == "SPOS" ? 0.5 : offset == "SNEG" ? -0.5 : to_real(offset, k.where);
      section.offset = -fraction * section.thickness;
    }
    if (k.has("ORIENTATION")) unused_.add("*" + k.name + "'s ORIENTATION", k.where);
    for (const char* word : {"NODAL THICKNESS", "SHELL THICKNESS", "STACK DIRECTION"})
      if (k.has(word)) unused_.add("*" + k.name + "'s " + word, k.where);
    here().sections.push_back(section);
  }

  void take_elastic(const Keyword& k) {
    ImportedMaterial& material = model_.materials.back();
    const std::string type = upper(k.has("TYPE") ? k.get("TYPE") : "ISOTROPIC");
    if (type == "ISOTROPIC" || type == "ISO") {
      material.E = to_real(field(k, 0, 0), k.where);
      material.nu = to_real(field(k, 0, 1), k.where);
    } else if (type == "ENGINEERING CONSTANTS") {
      material.orthotropic = true;
      for (int i = 0; i < 9; ++i)
        material.engineering[i] =
            to_real(field(k, static_cast<std::size_t>(i / 8), static_cast<std::size_t>(i % 8)), k.where);
    } else {
      throw std::invalid_argument(
          fmt::format("{}: *ELASTIC, TYPE={} is not read; isotropic and engineering constants are",
                      k.where.text(), type));
    }
  }

  /// One part, or the own content of an instance, goes into the model under a scope.
  void place(const Part& part, int scope, const Instance* instance, const std::string& prefix) {
    for (const NodeLine& node : part.nodes)
      builder_.add_node(scope, node.label,
                        instance ? Eigen::Vector3d(instance->R * node.x + instance->t) : node.x, node.where);
    for (const ElementLine& element : part.elements) {
      std::vector<Index> nodes;
      for (const std::int64_t label : element.nodes) {
        if (!builder_.has_node(scope, label))
          throw std::invalid_argument(fmt::format("{}: element {} names node {}, which does not exist",
                                                  element.where.text(), element.label, label));
        nodes.push_back(builder_.node(scope, label, element.where));
      }
      cell_of_[{scope, element.label}] =
          builder_.add_cell(scope, element.type, element.label, std::move(nodes), element.where);
      builder_.cells().back().variant = element.variant;
    }
    for (const OtherElement& element : part.others) place_other(element, scope);
    for (const auto& [name, labels] : part.node_sets) {
      builder_.add_to_set(prefix + name, nodes_of(scope, labels));
      set_nodes_[upper(prefix + name)] = nodes_of(scope, labels);
      set_nodes_.try_emplace(upper(name), nodes_of(scope, labels));
    }
    for (const auto& [name, labels] : part.element_sets) {
      set_cells_[upper(prefix + name)] = set_cells_[upper(name)] = {scope, labels};
    }
    for (const auto& [name, labels] : part.element_sets)
      if (!part.node_sets.contains(name))
        builder_.add_to_set(prefix + name, nodes_of_elements(scope, labels));
    for (const Section& section : part.sections) assign(section, part, scope, instance);
    for (const ElementData& data : part.data) assign(data, part, scope, instance);
  }

  void place_other(const OtherElement& element, int scope) {
    std::vector<Index> nodes;
    for (const std::int64_t label : element.nodes) nodes.push_back(builder_.node(scope, label, element.where));
    const std::pair<int, std::int64_t> key{scope, element.label};
    if (cell_of_.contains(key) || !other_labels_.insert(key).second)
      throw std::invalid_argument(fmt::format("{}: element {} is given twice; element numbers must be unique",
                                              element.where.text(), element.label));
    if (element.type[0] == 'B' || element.type[0] == 'T') {
      ImportedBar bar;
      bar.label = element.label;
      bar.nodes = {nodes[0], nodes[1]};
      if (element.type[0] == 'B' && nodes.size() > 2) unused_.add("a beam's third node (its section's n1 is used)", element.where);
      bar_of_[key] = {model_.bars.size(), element.type};
      model_.bars.push_back(bar);
    } else if (element.type == "SPRINGA") {
      spring_of_[key] = model_.springs.size();
      model_.springs.push_back({.label = element.label, .nodes = {nodes[0], nodes[1]}});
    } else {
      mass_of_[key] = model_.masses.size();
      model_.masses.push_back({.label = element.label, .node = nodes[0]});
    }
  }

  const std::vector<std::int64_t>& labels_of(const std::string& name, const Part& part, const Where& where) {
    const auto set = part.element_sets.find(name);
    if (set == part.element_sets.end())
      throw std::invalid_argument(fmt::format("{}: element set \"{}\" is not defined", where.text(), name));
    return set->second;
  }

  void assign(const ElementData& data, const Part& part, int scope, const Instance* instance) {
    const Eigen::Matrix3d R = instance ? instance->R : Eigen::Matrix3d::Identity();
    if (data.values.empty() || (data.kind == "ROTARY INERTIA" && data.values.size() < 3))
      throw std::invalid_argument(fmt::format("{}: *{} has no numbers", data.where.text(), data.kind));
    for (const std::int64_t label : labels_of(data.set, part, data.where)) {
      const std::pair<int, std::int64_t> key{scope, label};
      if (const auto spring = spring_of_.find(key); data.kind == "SPRING" && spring != spring_of_.end()) {
        ImportedSpring& to = model_.springs[spring->second];
        require_not_negative(data.values[0], "*" + data.kind, "stiffness", data.where);
        to.stiffness[0] = data.values[0];
        spring_set_.insert(spring->second);
      }
      const auto mass = mass_of_.find(key);
      if (mass == mass_of_.end()) continue;
      ImportedMass& to = model_.masses[mass->second];
      if (data.kind == "MASS") to.mass = data.values[0];
      if (data.kind != "ROTARY INERTIA") continue;
      std::vector<double> I = data.values;  // I11, I22, I33, I12, I13, I23: of the inertia tensor
      I.resize(6, 0.0);
      Eigen::Matrix3d J;
      J << I[0], I[3], I[4], I[3], I[1], I[5], I[4], I[5], I[2];
      to.inertia = R * J * R.transpose();
    }
  }

  // Nodes that a keyword names by a number, a set, or INSTANCE.number.
  std::vector<Index> named_nodes(const std::string& name, const Where& where) {
    if (const auto label = as_integer(name)) return {builder_.node(0, *label, where)};
    if (const auto set = set_nodes_.find(upper(name)); set != set_nodes_.end()) return set->second;
    if (const auto cells = set_cells_.find(upper(name)); cells != set_cells_.end())
      return nodes_of_elements(cells->second.first, cells->second.second);
    if (const std::size_t dot = name.rfind('.'); dot != std::string::npos)
      if (const auto label = as_integer(name.substr(dot + 1)))
        if (const auto scope = scope_of_.find(upper(name.substr(0, dot))); scope != scope_of_.end())
          return {builder_.node(scope->second, *label, where)};
    throw std::invalid_argument(fmt::format("{}: \"{}\" is no node and no set", where.text(), name));
  }

  std::vector<Index> surface_nodes(const std::string& name, const Where& where) {
    const auto found = surfaces_.find(name);
    if (found == surfaces_.end()) return named_nodes(name, where);
    found->second.used = true;
    std::vector<Index> nodes;
    for (const auto& [entry, face] : found->second.entries) {
      const bool whole = found->second.of_nodes || face == "SPOS" || face == "SNEG" || face.empty();
      if (whole) {
        const std::vector<Index> some = named_nodes(entry, where);
        nodes.insert(nodes.end(), some.begin(), some.end());
        continue;
      }
      const auto set = set_cells_.find(upper(entry));
      const auto number = face[0] == 'S' ? as_integer(face.substr(1)) : std::nullopt;
      if (!number || (set == set_cells_.end() && !as_integer(entry)))
        throw std::invalid_argument(
            fmt::format("{}: the surface {} has an entry \"{}, {}\", which is not read", where.text(), name, entry, face));
      const std::pair<int, std::vector<std::int64_t>> cells =
          set != set_cells_.end() ? set->second : std::pair{0, std::vector<std::int64_t>{*as_integer(entry)}};
      for (const std::int64_t label : cells.second) {
        const auto at = cell_of_.find({cells.first, label});
        if (at == cell_of_.end()) continue;
        const ModelBuilder::Cell& cell = builder_.cells()[at->second];
        const std::vector<int> corners = face_corners(cell.type, static_cast<int>(*number) - 1);
        if (corners.empty())
          throw std::invalid_argument(fmt::format("{}: element {} of the surface {} has no face {}", where.text(),
                                                  label, name, face));
        const auto on = [&](int c) { return std::find(corners.begin(), corners.end(), c) != corners.end(); };
        for (const int c : corners) nodes.push_back(cell.nodes[static_cast<std::size_t>(c)]);
        const CellShape& shape = shape_of(cell.type);
        for (std::size_t e = 0; e < shape.edges.size(); ++e)
          if (const std::size_t middle = static_cast<std::size_t>(shape.corners) + e;
              middle < cell.nodes.size() && on(shape.edges[e][0]) && on(shape.edges[e][1]))
            nodes.push_back(cell.nodes[middle]);
      }
    }
    return nodes;
  }

  void resolve_ties() {
    std::map<std::pair<Index, std::array<bool, 6>>, std::size_t> of_reference;
    for (const TieKeyword& from : ties_) {
      const std::vector<Index> reference = named_nodes(from.reference, from.where);
      if (reference.size() != 1)
        throw std::invalid_argument(
            fmt::format("{}: *{}: the reference \"{}\" is {} nodes, not one", from.where.text(), from.what,
                        from.reference, reference.size()));
      std::vector<Index> nodes = from.what == "COUPLING" ? surface_nodes(from.set, from.where)
                                                         : named_nodes(from.set, from.where);
      std::ranges::sort(nodes);
      nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
      std::erase(nodes, reference[0]);
      if (nodes.empty())
        throw std::invalid_argument(fmt::format("{}: *{} ties no nodes", from.where.text(), from.what));
      // Pairs of one node make one rigid piece.
      const auto [at, fresh] = of_reference.emplace(std::pair{reference[0], from.dofs}, model_.ties.size());
      if (!fresh && from.what == "MPC") {
        auto& all = model_.ties[at->second].nodes;
        all.insert(all.end(), nodes.begin(), nodes.end());
        continue;
      }
      ImportedTie tie;
      tie.kind = from.kind;
      tie.label = static_cast<std::int64_t>(model_.ties.size()) + 1;
      tie.reference = reference[0];
      tie.dofs = from.dofs;
      if (tie.kind == ImportedTie::Kind::average) tie.weights.assign(nodes.size(), 1.0);
      tie.nodes = std::move(nodes);
      model_.messages.push_back(fmt::format("*{} in {} is tie {}", from.what, from.where.text(), tie.label));
      model_.ties.push_back(std::move(tie));
    }
  }

  // Shells on the faces of solids without a section of their own mark these faces (as meshers write them): no stiffness.
  void drop_bare_shells() {
    std::vector<ModelBuilder::Cell>& cells = builder_.cells();
    const auto is_bare = [](const ModelBuilder::Cell& cell) {
      return dimension_of(cell.type) == 2 && cell.material < 0;
    };
    const bool has_solids = std::ranges::any_of(
        cells, [](const ModelBuilder::Cell& cell) { return dimension_of(cell.type) == 3; });
    const auto count = std::ranges::count_if(cells, is_bare);
    if (!has_solids || count == 0) return;
    std::erase_if(cells, is_bare);
    model_.messages.push_back(fmt::format("{} shell element{} (S3, S4, ...) {} no section and {} not used", count,
                                          count == 1 ? "" : "s", count == 1 ? "has" : "have", count == 1 ? "is" : "are"));
  }

  // Point masses that stand in one place are one; elements without a section are refused.
  void finish_others() {
    std::map<Index, std::size_t> at;
    std::vector<ImportedMass> merged;
    for (const ImportedMass& mass : model_.masses) {
      const auto [place, fresh] = at.emplace(mass.node, merged.size());
      if (fresh) {
        merged.push_back(mass);
      } else {
        merged[place->second].mass += mass.mass;
        merged[place->second].inertia += mass.inertia;
      }
    }
    model_.masses = std::move(merged);
    for (const ImportedBar& bar : model_.bars)
      if (!(bar.A > 0))
        throw std::invalid_argument(fmt::format(
            "beam element {} has no section (*BEAM SECTION, *BEAM GENERAL SECTION; trusses: *SOLID SECTION with an area)",
            bar.label));
    for (std::size_t k = 0; k < model_.springs.size(); ++k)
      if (!spring_set_.contains(k))
        throw std::invalid_argument(
            fmt::format("spring element {} has no stiffness (*SPRING)", model_.springs[k].label));
    for (ImportedSpring& spring : model_.springs) {  // along their line
      const Eigen::Vector3d line = builder_.place(spring.nodes[1]) - builder_.place(spring.nodes[0]);
      if (!(line.norm() > 0))
        throw std::invalid_argument(
            fmt::format("spring element {} (SPRINGA) has no length, hence no direction", spring.label));
      const Eigen::Vector3d x = line.normalized(), y = x.unitOrthogonal();
      spring.R << x, y, x.cross(y);
    }
  }

  void renumber_others(const std::vector<Index>& number) {
    each_other_node([&](Index& node) { node = number[static_cast<std::size_t>(node)]; });
  }

  template <class Visit>
  void each_other_node(const Visit& visit) {
    for (ImportedBar& bar : model_.bars)
      for (Index& node : bar.nodes) visit(node);
    for (ImportedSpring& spring : model_.springs)
      for (Index& node : spring.nodes) visit(node);
    for (ImportedMass& mass : model_.masses) visit(mass.node);
    for (ImportedTie& tie : model_.ties) {
      visit(tie.reference);
      for (Index& node : tie.nodes) visit(node);
    }
  }

  std::vector<Index> nodes_of(int scope, const std::vector<std::int64_t>& labels) const {
    std::vector<Index> nodes;  // GENERATE may name labels that do not exist: Abaqus leaves them out, too
    for (const std::int64_t label : labels)
      if (builder_.has_node(scope, label)) nodes.push_back(builder_.node(scope, label, {}));
    return nodes;
  }

  std::vector<Index> nodes_of_elements(int scope, const std::vector<std::int64_t>& labels) {
    std::vector<Index> nodes;
    for (const std::int64_t label : labels)
      if (const auto found = cell_of_.find({scope, label}); found != cell_of_.end()) {
        const auto& cell = builder_.cells()[found->second].nodes;
        nodes.insert(nodes.end(), cell.begin(), cell.end());
      }
    return nodes;
  }

  void assign(const Section& section, const Part& part, int scope, const Instance* instance) {
    const auto material = std::find_if(model_.materials.begin(), model_.materials.end(),
                                       [&](const ImportedMaterial& m) { return m.name == section.material; });
    if (material == model_.materials.end())
      throw std::invalid_argument(
          fmt::format("{}: material \"{}\" is not defined", section.where.text(), section.material));
    const auto set = part.element_sets.find(section.set);
    if (set == part.element_sets.end())
      throw std::invalid_argument(
          fmt::format("{}: element set \"{}\" is not defined", section.where.text(), section.set));
    for (const std::int64_t label : set->second)
      if (const auto bar = bar_of_.find({scope, label}); bar != bar_of_.end())
        assign_bar(section, model_.bars[bar->second.first], bar->second.second,
                   static_cast<Index>(material - model_.materials.begin()), instance);
      else if (const auto found = cell_of_.find({scope, label}); found != cell_of_.end())
{
        ModelBuilder::Cell& cell = builder_.cells()[found->second];
        cell.material = static_cast<Index>(material - model_.materials.begin());
        cell.thickness = section.thickness;
        cell.offset = section.offset;
      }
  }

  static void assign_bar(const Section& section, ImportedBar& bar, const std::string& type, Index material,
                         const Instance* instance) {
    bar.material = material;
    if (type[0] == 'T') {
      bar.A = section.area;
      if (section.bar)
        throw std::invalid_argument(fmt::format("{}: truss element {} has a section of beams; *SOLID SECTION with an area "
                                                "is wanted",
                                                section.where.text(), bar.label));
      require_positive(bar.A, fmt::format("truss element {}", bar.label), "area", section.where);
      return;
    }
    if (!section.bar)
      throw std::invalid_argument(fmt::format("{}: beam element {} has a section that is none of beams",
                                              section.where.text(), bar.label));
    const BarSection& s = *section.bar;
    bar.A = s.A, bar.I_yy = s.I_yy, bar.I_zz = s.I_zz, bar.I_yz = s.I_yz, bar.J = s.J;
    if (type.rfind("B31", 0) == 0) bar.kappa_y = s.kappa_y, bar.kappa_z = s.kappa_z;  // B33 knows no shear
    require_section(bar, fmt::format("beam element {}", bar.label), section.where);
    bar.orientation = instance ? Eigen::Vector3d(instance->R * section.n1) : section.n1;
  }

  ImportedModel build(const fs::path& path) {
    place(parts_[0], 0, nullptr, "");
    if (instances_.empty() && parts_.size() > 2)
      model_.messages.push_back("the file has parts but no assembly; each part is taken as it stands");
    const std::size_t placed = instances_.empty() ? parts_.size() - 1 : instances_.size();
    std::map<std::string, int>& scope_of = scope_of_;
    int scope = 0;
    for (const auto& instance : instances_) {
      const std::string prefix = placed > 1 ? instance->name + "." : "";
      Part all = parts_[static_cast<std::size_t>(instance->part)];
      append(all, instance->own);
      scope_of[upper(instance->name)] = ++scope;
      place(all, scope, instance.get(), prefix);
    }
    if (instances_.empty())
      for (std::size_t p = 1; p < parts_.size(); ++p)
        place(parts_[p], ++scope, nullptr, placed > 1 ? parts_[p].name + "." : "");
    for (const AssemblySet& set : assembly_sets_) {
      if (!set.names.empty()) {
        unused_.add(std::string(set.of_nodes ? "*NSET" : "*ELSET") + " of the assembly that names other sets",
                    set.where);
        continue;
      }
      const auto found = scope_of.find(set.instance);
      if (!set.instance.empty() && found == scope_of.end())
        throw std::invalid_argument(fmt::format("{}: set \"{}\" is of an instance \"{}\" that is not defined",
                                                set.where.text(), set.name, set.instance));
      const int in = set.instance.empty() ? 0 : found->second;
      builder_.add_to_set(set.name,
                          set.of_nodes ? nodes_of(in, set.labels) : nodes_of_elements(in, set.labels));
      if (set.of_nodes) {
        auto& all = set_nodes_[upper(set.name)];
        const std::vector<Index> some = nodes_of(in, set.labels);
        all.insert(all.end(), some.begin(), some.end());
      } else {
        set_cells_[upper(set.name)] = {in, set.labels};
      }
    }
    finish_others();
    resolve_ties();
    for (const auto& [name, surface] : surfaces_)
      if (!surface.used) unused_.add("*SURFACE", surface.where);
    drop_bare_shells();
    if (builder_.cells().empty() && model_.bars.empty())
      throw std::invalid_argument(path.string() +
                                  ": holds no solid, shell or beam elements (C3D4, C3D10, C3D8, C3D20, S3, S4, B31, ...)");
    for (const auto& [type, what] : replaced_)
      model_.messages.push_back(fmt::format("{} element{} of type {}: {}", what.first,
                                            what.first == 1 ? "" : "s", type, what.second));
    for (const std::string& message : unused_.messages("keyword")) model_.messages.push_back(message);
    model_.warnings = left_out_.messages("element");
    std::vector<Index> used;
    each_other_node([&](Index& node) { used.push_back(node); });
    renumber_others(builder_.finish(model_, used));
    return std::move(model_);
  }

  static void append(Part& to, const Part& from) {
    to.nodes.insert(to.nodes.end(), from.nodes.begin(), from.nodes.end());
    to.elements.insert(to.elements.end(), from.elements.begin(), from.elements.end());
    for (const auto& [name, labels] : from.node_sets) {
      auto& own = to.node_sets[name];
      own.insert(own.end(), labels.begin(), labels.end());
    }
    for (const auto& [name, labels] : from.element_sets) {
      auto& own = to.element_sets[name];
      own.insert(own.end(), labels.begin(), labels.end());
    }
    to.sections.insert(to.sections.end(), from.sections.begin(), from.sections.end());
    to.others.insert(to.others.end(), from.others.begin(), from.others.end());
    to.data.insert(to.data.end(), from.data.begin(), from.data.end());
  }

  ImportedModel model_;
  ModelBuilder builder_;
  Unused unused_, left_out_;  // keywords; elements
  std::map<std::string, std::pair<std::size_t, std::string>> replaced_;  // type: how many, what it becomes
  std::set<std::string> file_names_;
  std::map<std::string, std::string> spelling_;
  std::vector<Part> parts_;
  std::vector<std::unique_ptr<Instance>> instances_;
  std::vector<AssemblySet> assembly_sets_;
  std::map<std::pair<int, std::int64_t>, std::size_t> cell_of_, mass_of_, spring_of_;
  std::map<std::pair<int, std::int64_t>, std::pair<std::size_t, std::string>> bar_of_;  // with the element's type
  std::set<std::pair<int, std::int64_t>> other_labels_;
  std::set<std::size_t> spring_set_;
  std::vector<TieKeyword> ties_;
  std::map<std::string, Surface> surfaces_;
  std::map<std::string, std::vector<Index>> set_nodes_;
  std::map<std::string, std::pair<int, std::vector<std::int64_t>>> set_cells_;
  std::map<std::string, int> scope_of_;
  Instance* instance_ = nullptr;
  int part_ = 0;
  bool in_step_ = false, in_assembly_ = false, in_material_ = false;
};

}  // namespace

ImportedModel read_abaqus(const std::filesystem::path& path) {
  return Reader().read(path);
}

}  // namespace flexura::mesh
