// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/abaqus/abaqus_placer.hpp"
#include "mesh/import/abaqus/abaqus_types.hpp"
#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh::abaqus {

std::vector<Index> Placer::named_nodes(const std::string& name, const Where& where) {
  if (const auto label = as_integer(name)) return {builder_.node(0, *label, where)};
  if (const auto set = set_nodes_.find(upper(name)); set != set_nodes_.end()) return set->second;
  if (const auto cells = set_cells_.find(upper(name)); cells != set_cells_.end())
    return nodes_of_elements(cells->second);
  if (const std::size_t dot = name.rfind('.'); dot != std::string::npos)
    if (const auto label = as_integer(name.substr(dot + 1)))
      if (const auto scope = scope_of_.find(upper(name.substr(0, dot))); scope != scope_of_.end())
        return {builder_.node(scope->second, *label, where)};
  throw std::invalid_argument(fmt::format("{}: \"{}\" is no node and no set", where.text(), name));
}

Placer::FoundSurface Placer::find_surface(const std::string& name) {
  const auto get = [&](const std::string& key) {
    const auto found = deck_.surfaces.find(key);
    return found == deck_.surfaces.end() ? nullptr : &found->second;
  };
  const std::size_t dot = name.rfind('.');
  int scope = 0;
  for (const auto& instance : deck_.instances) {
    ++scope;
    const std::string& part = deck_.parts[static_cast<std::size_t>(instance->part)].name;
    const bool named = dot != std::string::npos && name.substr(0, dot) == upper(instance->name);
    if (!named && !(deck_.instances.size() == 1 && !get(name))) continue;
    if (Surface* surface = get(part + "." + (named ? name.substr(dot + 1) : name)))
      return {surface, upper(instance->name) + ".", scope};
  }
  if (Surface* surface = get(name)) return {surface, "", 0};
  for (std::size_t p = 1; p < deck_.parts.size() && deck_.instances.empty();
       ++p)  // parts without an assembly
    if (Surface* surface = get(deck_.parts[p].name + "." + name)) return {surface, "", static_cast<int>(p)};
  return {};
}

std::vector<SurfaceFace> Placer::surface_faces(const std::string& name, const Where& where) {
  std::vector<SurfaceFace> faces;
  const FoundSurface found = find_surface(name);
  if (!found.surface || found.surface->of_nodes) return faces;
  for (const auto& [entry, face] : found.surface->entries) {
    auto set = set_cells_.find(found.prefix + upper(entry));
    if (set == set_cells_.end()) set = set_cells_.find(upper(entry));
    const bool whole = face == "SPOS" || face == "SNEG" || face.empty();
    const auto number = !whole && face[0] == 'S' ? as_integer(face.substr(1)) : std::nullopt;
    if ((!whole && !number) || (set == set_cells_.end() && !as_integer(entry))) {
      if (whole) continue;  // a set of nodes
      throw std::invalid_argument(fmt::format("{}: the surface {} has an entry \"{}, {}\", which is not read",
                                              where.text(), name, entry, face));
    }
    const std::vector<Label> cells =
        set != set_cells_.end() ? set->second : std::vector<Label>{{found.scope, *as_integer(entry)}};
    for (const Label& label : cells) {
      const auto at = cell_of_.find(label);
      if (at == cell_of_.end()) continue;
      const ModelBuilder::Cell& cell = builder_.cells()[at->second];
      if (whole) {
        if (dimension_of(cell.type) == 2 && std::ranges::find(cell.nodes, -1) == cell.nodes.end())
          faces.push_back({cell.type, cell.nodes});
        continue;
      }
      std::vector<int> corners = face_corners(cell.type, static_cast<int>(*number) - 1);
      if (corners.empty())
        throw std::invalid_argument(fmt::format("{}: element {} of the surface {} has no face {}",
                                                where.text(), label.second, name, face));
      std::ranges::sort(corners);
      for (const CellFace& own : shape_of(cell.type).faces) {
        std::vector<int> these(own.nodes.begin(), own.nodes.begin() + shape_of(own.type).corners);
        std::ranges::sort(these);
        if (these != corners) continue;
        SurfaceFace& to = faces.emplace_back(SurfaceFace{own.type, {}});
        for (const int c : own.nodes) to.nodes.push_back(cell.nodes[static_cast<std::size_t>(c)]);
      }
    }
  }
  return faces;
}

std::vector<Index> Placer::surface_nodes(const std::string& name, const Where& where) {
  const FoundSurface found = find_surface(name);
  if (!found.surface) return named_nodes(name, where);
  found.surface->used = true;
  std::vector<Index> nodes;
  for (const auto& [entry, face] : found.surface->entries)
    if (found.surface->of_nodes || face == "SPOS" || face == "SNEG" || face.empty()) {
      const std::string own = found.prefix + upper(entry);
      const std::vector<Index> some = named_nodes(
          set_nodes_.contains(own) || set_cells_.contains(own) || as_integer(entry) ? own : entry, where);
      nodes.insert(nodes.end(), some.begin(), some.end());
    }
  for (const SurfaceFace& face : surface_faces(name, where))
    nodes.insert(nodes.end(), face.nodes.begin(), face.nodes.end());
  return nodes;
}

void Placer::merge_surface_ties() {
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
    std::vector<Index> between;
    const std::set<Index> turns = turning_nodes();
    std::size_t with_arms = 0;
    for (const Index slave : slaves) {
      const auto nearest = std::ranges::min_element(
          masters, {}, [&](Index m) { return (builder_.place(m) - builder_.place(slave)).squaredNorm(); });
      const double apart =
          nearest == masters.end() ? HUGE_VAL : (builder_.place(*nearest) - builder_.place(slave)).norm();
      constexpr double kSame = 1e-6;  // of the reach: digits of coordinates
      if (apart <= tolerance && (tie.adjust || apart <= kSame * tolerance)) {
        if (*nearest != slave) same[slave] = *nearest;
      } else if (apart <= tolerance && turns.contains(slave) && turns.contains(*nearest)) {
        follow_with_arm(tie, slave, *nearest);
        ++with_arms;
      } else {
        between.push_back(slave);
      }
    }
    builder_.join(same);
    each_attached_node(model_, [&](Index& node) {
      if (const auto found = same.find(node); found != same.end()) node = found->second;
    });
    for (auto& [name, nodes] : set_nodes_)
      for (Index& node : nodes)
        if (const auto found = same.find(node); found != same.end()) node = found->second;
    if (with_arms > 0)
      model_.messages.push_back(
          fmt::format("*TIE in {}: {} nodes of {} follow nodes of {} by rigid arms (ADJUST=NO)",
                      tie.where.text(), with_arms, tie.slave, tie.master));
    if (!same.empty() || (between.empty() && with_arms == 0))
      model_.messages.push_back(fmt::format("*TIE in {}: {} nodes of {} are joined to nodes of {}",
                                            tie.where.text(), same.size(), tie.slave, tie.master));
    if (!between.empty()) tie_between_nodes(tie, between, tie.tolerance);
  }
}

// Shares of the surface's faces, each of a face's nodes alike; of a surface of nodes all alike.
std::vector<double> Placer::nodal_areas(const TieKeyword& tie, const std::vector<Index>& nodes) {
  std::map<Index, double> area;
  if (tie.what == "COUPLING")
    for (const SurfaceFace& face : surface_faces(tie.set, tie.where)) {
      const auto corners = static_cast<std::size_t>(shape_of(face.type).corners);
      const auto at = [&](std::size_t k) -> const Eigen::Vector3d& { return builder_.place(face.nodes[k]); };
      const double twice = corners == 3 ? (at(1) - at(0)).cross(at(2) - at(0)).norm()
                                        : (at(2) - at(0)).cross(at(3) - at(1)).norm();
      for (const Index node : face.nodes) area[node] += 0.5 * twice / static_cast<double>(face.nodes.size());
    }
  std::vector<double> weights;
  for (const Index node : nodes) {
    const auto found = area.find(node);
    if (found == area.end() || !(found->second > 0)) return std::vector<double>(nodes.size(), 1.0);
    weights.push_back(found->second);
  }
  return weights;
}

void Placer::resolve_ties() {
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
    if (from.joins_places)
      for (const Index node : nodes)
        if (const double apart = (builder_.place(node) - builder_.place(reference[0])).norm(); apart > 0)
          deck_.otherwise.add(
              fmt::format("*MPC {} of nodes that stand {:.3g} apart: they are joined by a rigid arm",
                          *from.joins_places, apart),
              from.where);
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
    if (tie.kind == ImportedTie::Kind::average) {
      tie.weights = nodal_areas(from, nodes);
      if (!from.orientation.empty() && std::ranges::count(from.dofs, true) < 6)
        deck_.otherwise.add(
            "*COUPLING's ORIENTATION with *DISTRIBUTING of some directions: the model's axes are used",
            from.where);
    } else if (!from.orientation.empty()) {
      tie.axes.assign(nodes.size(), orientation(from.orientation, "", from.where));
    }
    tie.nodes = std::move(nodes);
    model_.messages.push_back(fmt::format("*{} in {} is tie {}", from.what, from.where.text(), tie.label));
    model_.ties.push_back(std::move(tie));
  }
}

}  // namespace flexura::mesh::abaqus
