// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus/abaqus_placed.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "mesh/import/abaqus/abaqus_keywords.hpp"

namespace flexura::mesh::abaqus {

std::vector<PlacedDeck::Label> PlacedDeck::in_scope(int scope, const std::vector<std::int64_t>& labels) {
  std::vector<Label> out;
  for (const std::int64_t label : labels) out.emplace_back(scope, label);
  return out;
}

std::vector<Index> PlacedDeck::nodes_of(int scope, const std::vector<std::int64_t>& labels) const {
  std::vector<Index> nodes;  // GENERATE may name labels that do not exist: Abaqus leaves them out, too
  for (const std::int64_t label : labels)
    if (builder.has_node(scope, label)) nodes.push_back(builder.node(scope, label, {}));
  return nodes;
}

std::vector<Index> PlacedDeck::nodes_of_elements(const std::vector<Label>& labels) const {
  std::vector<Index> nodes;
  for (const Label& label : labels)
    if (const auto found = cell_of.find(label); found != cell_of.end()) {
      const auto& cell = builder.cells()[found->second].nodes;
      nodes.insert(nodes.end(), cell.begin(), cell.end());
    } else {
      for (auto [bar, end] = bar_of.equal_range(label); bar != end; ++bar) {
        const auto& ends = model.bars[bar->second.first].nodes;
        nodes.insert(nodes.end(), ends.begin(), ends.end());
      }
    }
  std::erase(nodes, -1);
  return nodes;
}

const Orientation& PlacedDeck::found_orientation(const std::string& name, const std::string& part,
                                                 const Where& where) const {
  auto found = deck.orientations.find(part + "." + name);
  if (found == deck.orientations.end()) found = deck.orientations.find(name);
  if (found == deck.orientations.end())
    throw std::invalid_argument(fmt::format("{}: ORIENTATION=\"{}\" is not defined", where.text(), name));
  if (!found->second.not_read.empty())
    throw std::invalid_argument(
        fmt::format("{}: *ORIENTATION {} has {}, which is not read; axes by coordinates are",
                    found->second.where.text(), name, found->second.not_read));
  return found->second;
}

Eigen::Matrix3d PlacedDeck::orientation(const std::string& name, const std::string& part,
                                        const Where& where) const {
  if (name.empty()) return Eigen::Matrix3d::Identity();
  const Orientation& found = found_orientation(name, part, where);
  if (found.system.kind != 'R')
    throw std::invalid_argument(
        fmt::format("{}: *ORIENTATION {} is a cylindrical or spherical system, which springs, masses and "
                    "couplings do not read; rectangular axes are",
                    found.where.text(), name));
  return found.axes_at(Eigen::Vector3d::Zero());
}

}  // namespace flexura::mesh::abaqus
