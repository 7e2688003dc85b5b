// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_ties.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "mesh/import/abaqus/abaqus_keywords.hpp"
#include "mesh/import/abaqus/abaqus_types.hpp"
#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh::abaqus {

std::vector<Index> TiePlacer::named_nodes(const std::string& name, const Where& where) {
  if (const auto label = as_integer(name)) return {placed_.builder.node(0, *label, where)};
  if (const auto set = placed_.set_nodes.find(upper(name)); set != placed_.set_nodes.end())
    return set->second;
  if (const auto cells = placed_.set_cells.find(upper(name)); cells != placed_.set_cells.end())
    return placed_.nodes_of_elements(cells->second);
  if (const std::size_t dot = name.rfind('.'); dot != std::string::npos)
    if (const auto label = as_integer(name.substr(dot + 1)))
      if (const auto scope = placed_.scope_of.find(upper(name.substr(0, dot)));
          scope != placed_.scope_of.end())
        return {placed_.builder.node(scope->second, *label, where)};
  throw std::invalid_argument(fmt::format("{}: \"{}\" is no node and no set", where.text(), name));
}

TiePlacer::FoundSurface TiePlacer::find_surface(const std::string& name) {
  const auto get = [&](const std::string& key) {
    const auto found = placed_.deck.surfaces.find(key);
    return found == placed_.deck.surfaces.end() ? nullptr : &found->second;
  };
  const std::size_t dot = name.rfind('.');
  int scope = 0;
  for (const auto& instance : placed_.deck.instances) {
    ++scope;
    const std::string& part = placed_.deck.parts[static_cast<std::size_t>(instance->part)].name;
    const bool named = dot != std::string::npos && name.substr(0, dot) == upper(instance->name);
    if (!named && !(placed_.deck.instances.size() == 1 && !get(name))) continue;
    if (Surface* surface = get(part + "." + (named ? name.substr(dot + 1) : name)))
      return {surface, upper(instance->name) + ".", scope};
  }
  if (Surface* surface = get(name)) return {surface, "", 0};
  for (std::size_t p = 1; p < placed_.deck.parts.size() && placed_.deck.instances.empty();
       ++p)  // parts without an assembly
    if (Surface* surface = get(placed_.deck.parts[p].name + "." + name))
      return {surface, "", static_cast<int>(p)};
  return {};
}

std::vector<SurfaceFace> TiePlacer::surface_faces(const std::string& name, const Where& where) {
  std::vector<SurfaceFace> faces;
  const FoundSurface found = find_surface(name);
  if (!found.surface || found.surface->of_nodes) return faces;
  for (const auto& [entry, face] : found.surface->entries) {
    auto set = placed_.set_cells.find(found.prefix + upper(entry));
    if (set == placed_.set_cells.end()) set = placed_.set_cells.find(upper(entry));
    const bool whole = face == "SPOS" || face == "SNEG" || face.empty();
    const auto number = !whole && face[0] == 'S' ? as_integer(face.substr(1)) : std::nullopt;
    if ((!whole && !number) || (set == placed_.set_cells.end() && !as_integer(entry))) {
      if (whole) continue;  // a set of nodes
      throw std::invalid_argument(fmt::format("{}: the surface {} has an entry \"{}, {}\", which is not read",
                                              where.text(), name, entry, face));
    }
    const std::vector<PlacedDeck::Label> cells =
        set != placed_.set_cells.end() ? set->second
                                       : std::vector<PlacedDeck::Label>{{found.scope, *as_integer(entry)}};
    for (const PlacedDeck::Label& label : cells) {
      const auto at = placed_.cell_of.find(label);
      if (at == placed_.cell_of.end()) continue;
      const ModelBuilder::Cell& cell = placed_.builder.cells()[at->second];
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

std::vector<Index> TiePlacer::surface_nodes(const std::string& name, const Where& where) {
  const FoundSurface found = find_surface(name);
  if (!found.surface) return named_nodes(name, where);
  found.surface->used = true;
  std::vector<Index> nodes;
  for (const auto& [entry, face] : found.surface->entries)
    if (found.surface->of_nodes || face == "SPOS" || face == "SNEG" || face.empty()) {
      const std::string own = found.prefix + upper(entry);
      const std::vector<Index> some = named_nodes(
          placed_.set_nodes.contains(own) || placed_.set_cells.contains(own) || as_integer(entry) ? own
                                                                                                  : entry,
          where);
      nodes.insert(nodes.end(), some.begin(), some.end());
    }
  for (const SurfaceFace& face : surface_faces(name, where))
    nodes.insert(nodes.end(), face.nodes.begin(), face.nodes.end());
  return nodes;
}

void TiePlacer::merge_surface_ties() {
  for (const SurfaceTie& tie : placed_.deck.surface_ties) {
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
            least =
                std::min(least, (placed_.builder.place(other) - placed_.builder.place(masters[k])).norm());
        sum += least;
      }
      tolerance = count > 0 && std::isfinite(sum) ? 0.05 * sum / static_cast<double>(count) : 0;
    }
    std::map<Index, Index> same;
    std::vector<Index> between;
    const std::set<Index> turns = turning_nodes();
    std::size_t with_arms = 0;
    for (const Index slave : slaves) {
      const auto nearest = std::ranges::min_element(masters, {}, [&](Index m) {
        return (placed_.builder.place(m) - placed_.builder.place(slave)).squaredNorm();
      });
      const double apart = nearest == masters.end()
                               ? HUGE_VAL
                               : (placed_.builder.place(*nearest) - placed_.builder.place(slave)).norm();
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
    placed_.builder.join(same);
    each_attached_node(placed_.model, [&](Index& node) {
      if (const auto found = same.find(node); found != same.end()) node = found->second;
    });
    for (auto& [name, nodes] : placed_.set_nodes)
      for (Index& node : nodes)
        if (const auto found = same.find(node); found != same.end()) node = found->second;
    if (with_arms > 0)
      placed_.model.messages.push_back(
          fmt::format("*TIE in {}: {} nodes of {} follow nodes of {} by rigid arms (ADJUST=NO)",
                      tie.where.text(), with_arms, tie.slave, tie.master));
    if (!same.empty() || (between.empty() && with_arms == 0))
      placed_.model.messages.push_back(fmt::format("*TIE in {}: {} nodes of {} are joined to nodes of {}",
                                                   tie.where.text(), same.size(), tie.slave, tie.master));
    if (!between.empty()) tie_between_nodes(tie, between, tie.tolerance);
  }
}

// Shares of the surface's faces, each of a face's nodes alike; of a surface of nodes all alike.
std::vector<double> TiePlacer::nodal_areas(const TieKeyword& tie, const std::vector<Index>& nodes) {
  std::map<Index, double> area;
  if (tie.what == "COUPLING")
    for (const SurfaceFace& face : surface_faces(tie.set, tie.where)) {
      const auto corners = static_cast<std::size_t>(shape_of(face.type).corners);
      const auto at = [&](std::size_t k) -> const Eigen::Vector3d& {
        return placed_.builder.place(face.nodes[k]);
      };
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

void TiePlacer::resolve_ties() {
  std::map<std::pair<Index, std::array<bool, 6>>, std::size_t> of_reference;
  for (const TieKeyword& from : placed_.deck.ties) {
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
        if (const double apart = (placed_.builder.place(node) - placed_.builder.place(reference[0])).norm();
            apart > 0)
          placed_.deck.otherwise.add(
              fmt::format("*MPC {} of nodes that stand {:.3g} apart: they are joined by a rigid arm",
                          *from.joins_places, apart),
              from.where);
    if (nodes.empty())
      throw std::invalid_argument(fmt::format("{}: *{} ties no nodes", from.where.text(), from.what));
    // Pairs of one node make one rigid piece.
    const auto [at, fresh] =
        of_reference.emplace(std::pair{reference[0], from.dofs}, placed_.model.ties.size());
    if (!fresh && from.what == "MPC") {
      auto& all = placed_.model.ties[at->second].nodes;
      all.insert(all.end(), nodes.begin(), nodes.end());
      continue;
    }
    ImportedTie tie;
    tie.kind = from.kind;
    tie.label = static_cast<std::int64_t>(placed_.model.ties.size()) + 1;
    tie.reference = reference[0];
    tie.dofs = from.dofs;
    if (tie.kind == ImportedTie::Kind::average) {
      tie.weights = nodal_areas(from, nodes);
      if (!from.orientation.empty() && std::ranges::count(from.dofs, true) < 6)
        placed_.deck.otherwise.add(
            "*COUPLING's ORIENTATION with *DISTRIBUTING of some directions: the model's axes are used",
            from.where);
    } else if (!from.orientation.empty()) {
      tie.axes.assign(nodes.size(), placed_.orientation(from.orientation, "", from.where));
    }
    tie.nodes = std::move(nodes);
    placed_.model.messages.push_back(
        fmt::format("*{} in {} is tie {}", from.what, from.where.text(), tie.label));
    placed_.model.ties.push_back(std::move(tie));
  }
}

}  // namespace flexura::mesh::abaqus
