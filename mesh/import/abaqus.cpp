// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "mesh/import/abaqus_deck.hpp"
#include "mesh/import/abaqus_keywords.hpp"
#include "mesh/import/abaqus_types.hpp"
#include "mesh/import/bar_sections.hpp"
#include "mesh/import/builder.hpp"
#include "mesh/model/cell.hpp"

namespace flexura::mesh::abaqus {
namespace {

/// Places what a deck says: labels become nodes and cells, names become sets, sections go to their elements.
class Placer {
 public:
  explicit Placer(Deck&& deck) : deck_(std::move(deck)) { model_.materials = std::move(deck_.materials); }

  ImportedModel build(const std::filesystem::path& path) {
    place(deck_.parts[0], 0, nullptr, "");
    if (deck_.instances.empty() && deck_.parts.size() > 2)
      model_.messages.push_back("the file has parts but no assembly; each part is taken as it stands");
    const std::size_t placed = deck_.instances.empty() ? deck_.parts.size() - 1 : deck_.instances.size();
    std::map<std::string, int>& scope_of = scope_of_;
    int scope = 0;
    for (const auto& instance : deck_.instances) {
      const std::string prefix = placed > 1 ? instance->name + "." : "";
      Part all = deck_.parts[static_cast<std::size_t>(instance->part)];
      append(all, instance->own);
      scope_of[upper(instance->name)] = ++scope;
      place(all, scope, instance.get(), prefix);
    }
    if (deck_.instances.empty())
      for (std::size_t p = 1; p < deck_.parts.size(); ++p)
        place(deck_.parts[p], ++scope, nullptr, placed > 1 ? deck_.parts[p].name + "." : "");
    for (const AssemblySet& set : deck_.assembly_sets) {
      if (!set.names.empty()) {
        deck_.unused.add(
            std::string(set.of_nodes ? "*NSET" : "*ELSET") + " of the assembly that names other sets",
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
    merge_surface_ties();
    finish_others();
    resolve_ties();
    for (const auto& [name, surface] : deck_.surfaces)
      if (!surface.used) deck_.unused.add("*SURFACE", surface.where);
    drop_bare_shells();
    if (builder_.cells().empty() && model_.bars.empty())
      throw std::invalid_argument(
          path.string() +
          ": holds no solid, shell or beam elements (C3D4, C3D10, C3D8, C3D20, S3, S4, B31, ...)");
    for (const auto& [type, what] : deck_.replaced)
      model_.messages.push_back(fmt::format("{} element{} of type {}: {}", what.first,
                                            what.first == 1 ? "" : "s", type, what.second));
    for (const std::string& message : deck_.unused.messages("keyword")) model_.messages.push_back(message);
    model_.warnings = deck_.left_out.messages("element");
    for (const std::string& message : deck_.unbound.messages("keyword"))
      model_.warnings.push_back(message + ": what it binds stays apart");
    builder_.finish(model_);
    return std::move(model_);
  }

 private:
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
    for (const std::int64_t label : element.nodes)
      nodes.push_back(builder_.node(scope, label, element.where));
    const std::pair<int, std::int64_t> key{scope, element.label};
    if (cell_of_.contains(key) || !other_labels_.insert(key).second)
      throw std::invalid_argument(fmt::format("{}: element {} is given twice; element numbers must be unique",
                                              element.where.text(), element.label));
    if (element.type[0] == 'B' || element.type[0] == 'T') {
      ImportedBar bar;
      bar.label = element.label;
      bar.nodes = {nodes[0], nodes[1]};
      if (element.type[0] == 'B' && nodes.size() > 2)
        deck_.unused.add("a beam's third node (its section's n1 is used)", element.where);
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
    const auto found = deck_.surfaces.find(name);
    if (found == deck_.surfaces.end()) return named_nodes(name, where);
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
            fmt::format("{}: the surface {} has an entry \"{}, {}\", which is not read", where.text(), name,
                        entry, face));
      const std::pair<int, std::vector<std::int64_t>> cells =
          set != set_cells_.end() ? set->second : std::pair{0, std::vector<std::int64_t>{*as_integer(entry)}};
      for (const std::int64_t label : cells.second) {
        const auto at = cell_of_.find({cells.first, label});
        if (at == cell_of_.end()) continue;
        const ModelBuilder::Cell& cell = builder_.cells()[at->second];
        const std::vector<int> corners = face_corners(cell.type, static_cast<int>(*number) - 1);
        if (corners.empty())
          throw std::invalid_argument(fmt::format("{}: element {} of the surface {} has no face {}",
                                                  where.text(), label, name, face));
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

  // *TIE: nodes of the slave that lie on nodes of the master become one with them, rotations too.  Between nodes the
  // surfaces stay apart, which is a warning.
  void merge_surface_ties() {
    for (const SurfaceTie& tie : deck_.surface_ties) {
      std::vector<Index> slaves = surface_nodes(tie.slave, tie.where),
                         masters = surface_nodes(tie.master, tie.where);
      for (std::vector<Index>* nodes : {&slaves, &masters}) {
        std::ranges::sort(*nodes);
        nodes->erase(std::unique(nodes->begin(), nodes->end()), nodes->end());
      }
      double tolerance = tie.tolerance;
      if (!(tolerance > 0)) {
        // The least distance of a master's node from the others, on the mean of a few.
        double sum = 0;
        const std::size_t step = std::max<std::size_t>(1, masters.size() / 20);
        std::size_t count = 0;
        for (std::size_t k = 0; k < masters.size(); k += step, ++count) {
          double least = HUGE_VAL;
          for (const Index other : masters)
            if (other != masters[k])
              least = std::min(least, (builder_.place(other) - builder_.place(masters[k])).norm());
          sum += least;
        }
        tolerance = count > 0 && std::isfinite(sum) ? 0.05 * sum / static_cast<double>(count) : 0;
      }
      std::map<Index, Index> same;
      std::size_t apart = 0;
      for (const Index slave : slaves) {
        const auto nearest = std::ranges::min_element(
            masters, {}, [&](Index m) { return (builder_.place(m) - builder_.place(slave)).squaredNorm(); });
        if (nearest != masters.end() &&
            (builder_.place(*nearest) - builder_.place(slave)).norm() <= tolerance) {
          if (*nearest != slave) same[slave] = *nearest;
        } else {
          ++apart;
        }
      }
      builder_.join(same);
      each_attached_node(model_, [&](Index& node) {
        if (const auto found = same.find(node); found != same.end()) node = found->second;
      });
      for (auto& [name, nodes] : set_nodes_)
        for (Index& node : nodes)
          if (const auto found = same.find(node); found != same.end()) node = found->second;
      model_.messages.push_back(fmt::format("*TIE in {}: {} nodes of {} are joined to nodes of {}",
                                            tie.where.text(), same.size(), tie.slave, tie.master));
      if (apart > 0)
        model_.warnings.push_back(
            fmt::format("*TIE in {}: {} of the {} nodes of {} lie on no node of {} (within {:.3g}) and stay "
                        "apart: only nodes that "
                        "coincide are joined, so mesh both sides alike there",
                        tie.where.text(), apart, slaves.size(), tie.slave, tie.master, tolerance));
    }
  }

  void resolve_ties() {
    std::map<std::pair<Index, std::array<bool, 6>>, std::size_t> of_reference;
    for (const TieKeyword& from : deck_.ties) {
      const std::vector<Index> reference = named_nodes(from.reference, from.where);
      if (reference.size() != 1)
        throw std::invalid_argument(fmt::format("{}: *{}: the reference \"{}\" is {} nodes, not one",
                                                from.where.text(), from.what, from.reference,
                                                reference.size()));
      std::vector<Index> nodes =
          from.what == "COUPLING" ? surface_nodes(from.set, from.where) : named_nodes(from.set, from.where);
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
    model_.messages.push_back(fmt::format("{} shell element{} (S3, S4, ...) {} no section and {} not used",
                                          count, count == 1 ? "" : "s", count == 1 ? "has" : "have",
                                          count == 1 ? "is" : "are"));
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
        throw std::invalid_argument(
            fmt::format("beam element {} has no section (*BEAM SECTION, *BEAM GENERAL SECTION; trusses: "
                        "*SOLID SECTION with an area)",
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
      else if (const auto found = cell_of_.find({scope, label}); found != cell_of_.end()) {
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
        throw std::invalid_argument(
            fmt::format("{}: truss element {} has a section of beams; *SOLID SECTION with an area "
                        "is wanted",
                        section.where.text(), bar.label));
      require_positive(bar.A, fmt::format("truss element {}", bar.label), "area", section.where);
      return;
    }
    if (!section.bar)
      throw std::invalid_argument(fmt::format("{}: beam element {} has a section that is none of beams",
                                              section.where.text(), bar.label));
    const BarSection& s = *section.bar;
    bar.centroid << -s.node_y, -s.node_z;
    bar.A = s.A, bar.I_yy = s.I_yy, bar.I_zz = s.I_zz, bar.I_yz = s.I_yz, bar.J = s.J;
    if (type.rfind("B31", 0) == 0) bar.kappa_y = s.kappa_y, bar.kappa_z = s.kappa_z;  // B33 knows no shear
    require_section(bar, fmt::format("beam element {}", bar.label), section.where);
    bar.orientation = instance ? Eigen::Vector3d(instance->R * section.n1) : section.n1;
  }

  Deck deck_;
  ImportedModel model_;
  ModelBuilder builder_;
  std::map<std::pair<int, std::int64_t>, std::size_t> cell_of_, mass_of_, spring_of_;
  std::map<std::pair<int, std::int64_t>, std::pair<std::size_t, std::string>>
      bar_of_;  // with the element's type
  std::set<std::pair<int, std::int64_t>> other_labels_;
  std::set<std::size_t> spring_set_;
  std::map<std::string, std::vector<Index>> set_nodes_;
  std::map<std::string, std::pair<int, std::vector<std::int64_t>>> set_cells_;
  std::map<std::string, int> scope_of_;
};

}  // namespace
}  // namespace flexura::mesh::abaqus

namespace flexura::mesh {

ImportedModel read_abaqus(const std::filesystem::path& path) {
  return abaqus::Placer(abaqus::read_deck(path)).build(path);
}

}  // namespace flexura::mesh
