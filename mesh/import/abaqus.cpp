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
#include "mesh/import/builder.hpp"

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
};

/// What a part (or the model level) holds, by label.
struct Part {
  std::string name;
  std::vector<NodeLine> nodes;
  std::vector<ElementLine> elements;
  std::map<std::string, std::vector<std::int64_t>> node_sets, element_sets;
  std::vector<Section> sections;
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
      here().sections.push_back({known(k.get("ELSET")), known(k.get("MATERIAL")), k.where});
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
    const std::optional<SolidType> solid = solid_type(k.get("TYPE"));
    if (!solid) {
      for (const DataLine& line : k.data) unused_.add("*ELEMENT of type " + k.get("TYPE"), line.where);
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
    for (const auto& [name, labels] : part.node_sets)
      builder_.add_to_set(prefix + name, nodes_of(scope, labels));
    for (const auto& [name, labels] : part.element_sets)
      if (!part.node_sets.contains(name))
        builder_.add_to_set(prefix + name, nodes_of_elements(scope, labels));
    for (const Section& section : part.sections) assign(section, part, scope);
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

  void assign(const Section& section, const Part& part, int scope) {
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
      if (const auto found = cell_of_.find({scope, label}); found != cell_of_.end())
        builder_.cells()[found->second].material = static_cast<Index>(material - model_.materials.begin());
  }

  ImportedModel build(const fs::path& path) {
    place(parts_[0], 0, nullptr, "");
    if (instances_.empty() && parts_.size() > 2)
      model_.messages.push_back("the file has parts but no assembly; each part is taken as it stands");
    const std::size_t placed = instances_.empty() ? parts_.size() - 1 : instances_.size();
    std::map<std::string, int> scope_of;
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
    }
    if (builder_.cells().empty())
      throw std::invalid_argument(path.string() +
                                  ": holds no solid elements (C3D4, C3D10, C3D8, C3D20, ...)");
    for (const auto& [type, what] : replaced_)
      model_.messages.push_back(fmt::format("{} element{} of type {}: {}", what.first,
                                            what.first == 1 ? "" : "s", type, what.second));
    for (const std::string& message : unused_.messages("keyword")) model_.messages.push_back(message);
    builder_.finish(model_, {});
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
  }

  ImportedModel model_;
  ModelBuilder builder_;
  Unused unused_;
  std::map<std::string, std::pair<std::size_t, std::string>> replaced_;  // type: how many, what it becomes
  std::set<std::string> file_names_;
  std::map<std::string, std::string> spelling_;
  std::vector<Part> parts_;
  std::vector<std::unique_ptr<Instance>> instances_;
  std::vector<AssemblySet> assembly_sets_;
  std::map<std::pair<int, std::int64_t>, std::size_t> cell_of_;
  Instance* instance_ = nullptr;
  int part_ = 0;
  bool in_step_ = false, in_assembly_ = false, in_material_ = false;
};

}  // namespace

ImportedModel read_abaqus(const std::filesystem::path& path) {
  return Reader().read(path);
}

}  // namespace flexura::mesh
