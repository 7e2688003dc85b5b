// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/read_mesh.hpp"

#include <gmsh.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <stdexcept>

#include "mesh/gmsh/msh_file.hpp"
#include "mesh/model/cells/record.hpp"
#include "mesh/model/mesh.hpp"

namespace flexura::mesh {
namespace {

const CellRecord* cell_of(int gmsh_type) {
  const auto found = std::ranges::find_if(
      cell_records(), [&](const CellRecord& record) { return record.foreign.gmsh == gmsh_type; });
  return found == cell_records().end() ? nullptr : &*found;
}

}  // namespace

void merge_msh(const std::string& path) {
  if (!begins_as_msh(path)) throw std::runtime_error("is no gmsh mesh (it does not begin with $MeshFormat)");
  gmsh::merge(path);
}

void read_mesh(const std::string& path, int dimension_wanted, ResultRecord& result, Arrays& arrays) {
  merge_msh(path);
  const bool shells = dimension_wanted == 2;
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters, -1, -1, false, false);
  std::map<std::size_t, std::size_t> at;  // tag -> place, each node once
  for (std::size_t k = 0; k < tags.size(); ++k) at.emplace(tags[k], k);

  std::map<std::size_t, std::int64_t> index;  // tag -> node number, for nodes of solid cells
  std::vector<std::pair<std::vector<std::size_t>, std::vector<std::size_t>>> blocks;
  std::vector<int> types;
  gmsh::model::mesh::getElementTypes(types, 3, -1);
  if (shells && !types.empty())
    throw std::runtime_error(
        "holds solid cells, where [shell] wants those of a sheet's middle surface alone: save these, or "
        "leave "
        "[shell] out");
  if (shells) gmsh::model::mesh::getElementTypes(types, 2, -1);
  for (const int type : types) {
    const CellRecord* const record = cell_of(type);
    std::vector<std::size_t> cells, nodes;
    gmsh::model::mesh::getElementsByType(type, cells, nodes, -1);
    if (cells.empty()) continue;
    if (!record) {
      std::string name;
      int dimension, order, n, n_primary;
      std::vector<double> local;
      gmsh::model::mesh::getElementProperties(type, name, dimension, order, n, local, n_primary);
      throw std::runtime_error("holds " + std::to_string(cells.size()) + " cells of type \"" + name +
                               "\", which have no counterpart here; " +
                               (shells ? "triangles and quadrilaterals of three and four nodes do"
                                       : "tetrahedra, hexahedra, wedges and pyramids of order 1 and "
                                         "2 (15-node wedges, 13-node pyramids) do"));
    }
    for (const std::size_t node : nodes) index.emplace(node, 0);
    result.blocks.push_back({static_cast<int>(record->type), cells.size()});
    const auto n = static_cast<std::size_t>(record->nodes.rows());
    const std::vector<int>& order = record->foreign.gmsh_order;
    std::vector<std::size_t> ordered(nodes.size());
    for (std::size_t c = 0; c < cells.size(); ++c)
      for (std::size_t k = 0; k < n; ++k)
        ordered[c * n + k] = nodes[c * n + (order.empty() ? k : static_cast<std::size_t>(order[k]))];
    blocks.emplace_back(std::move(cells), std::move(ordered));
  }
  if (blocks.empty())
    throw std::runtime_error(
        shells ? "holds no triangles or quadrilaterals"
               : "holds no solid cells; save the volume elements too, or, where its surface cells are sheet "
                 "metal, give their thickness in a table [shell]");

  std::int64_t next = 0;
  for (auto& [tag, number] : index) {
    number = next++;
    arrays.integers.push_back(static_cast<std::int64_t>(tag));
    const auto found = at.find(tag);
    if (found == at.end())
      throw std::runtime_error("has cells on node " + std::to_string(tag) + ", which it does not hold");
    const std::size_t place = found->second;
    arrays.points.insert(arrays.points.end(), coordinates.begin() + static_cast<std::ptrdiff_t>(3 * place),
                         coordinates.begin() + static_cast<std::ptrdiff_t>(3 * place + 3));
  }
  if (const std::size_t spare = at.size() - index.size(); spare > 0)
    result.messages.push_back(std::to_string(spare) + " nodes belong to no such cell and are left out");
  for (const auto& [cells, nodes] : blocks) {
    for (const std::size_t cell : cells) arrays.integers.push_back(static_cast<std::int64_t>(cell));
    for (const std::size_t node : nodes) arrays.integers.push_back(index.at(node));
  }

  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups);
  std::set<std::string> names;
  for (const auto& [dimension, tag] : groups) {
    std::string name;
    gmsh::model::getPhysicalName(dimension, tag, name);
    if (name.empty()) name = "group " + std::to_string(tag);
    if (!names.insert(name).second) {
      static const char* const kKinds[] = {"points", "curves", "surfaces", "volumes"};
      name += std::string(" (") + kKinds[dimension] + ")";
    }
    std::vector<std::size_t> nodes;
    std::vector<double> unused;
    gmsh::model::mesh::getNodesForPhysicalGroup(dimension, tag, nodes, unused);
    std::uint64_t n = 0;
    for (const std::size_t node : nodes)
      if (const auto found = index.find(node); found != index.end()) {
        arrays.integers.push_back(found->second);
        ++n;
      }
    result.groups.push_back({name, n});
  }
}

}  // namespace flexura::mesh
