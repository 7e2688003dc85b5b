// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "mesh/import/nastran/nastran_reader.hpp"
#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh {

using Eigen::Vector3d;

NastranReader::ShellProperty NastranReader::shell_property(const Card& card) {
  ShellProperty shell{material(card.integer(1), card.where), card.real(2, 0), card.real(7, 0)};
  const std::int64_t mid = card.integer(1);
  if (card.blank(3))
    approximated_.add("PSHELL's missing MID2 (membrane alone): bending is computed as well", card.where);
  else if (card.integer(3) != mid)
    approximated_.add("PSHELL's MID2 other than MID1: MID1 is used for bending, too", card.where);
  if (std::abs(card.real(4, 1) - 1) > 1e-6)
    approximated_.add("PSHELL's 12 I / T**3 other than 1: 1 is used", card.where);
  if (std::abs(card.real(6, 5.0 / 6) - 5.0 / 6) > 1e-3)
    approximated_.add("PSHELL's TS/T other than 5/6: 5/6 is used", card.where);
  if (!card.blank(10)) approximated_.add("PSHELL's MID4: membrane and bending are computed without coupling", card.where);
  if (card.blank(5) && card.blank(6) && !card.blank(3))
    unused_.add("PSHELL without MID3 (shear deformation is computed, that of thick shells)", card.where);
  return shell;
}

void NastranReader::read_shells() {
  std::map<std::int64_t, ShellProperty> properties;
  for (const Card* card : all("PSHELL")) properties.emplace(card->integer(0), shell_property(*card));
  std::set<std::int64_t> layered;
  for (const char* name : {"PCOMP", "PCOMPG"})
    for (const Card* card : by_name_[name]) layered.insert(card->integer(0));
  // Where the nodes end, there stand: THETA or MCID, ZOFFS; TFLAG and the corners' thicknesses.
  struct ShellCard {
    CellType type;
    std::size_t offset, flag, thickness;
  };
  static const std::map<std::string, ShellCard> kCards = {
      {"CQUAD4", {CellType::quad4, 7, 9, 10}},   {"CQUADR", {CellType::quad4, 7, 9, 10}},
      {"CTRIA3", {CellType::tri3, 6, 9, 10}},    {"CTRIAR", {CellType::tri3, 6, 9, 10}},
      {"CQUAD8", {CellType::quad8, 15, 16, 10}}, {"CTRIA6", {CellType::tri6, 9, 13, 10}}};
  std::map<std::string, int> split;
  for (const Card& card : cards_) {
    const auto found = kCards.find(card.name);
    if (found == kCards.end()) continue;
    used_.insert(card.name);
    const ShellCard& places = found->second;
    const auto n_nodes = static_cast<std::size_t>(nodes_per_cell(places.type)),
               n = static_cast<std::size_t>(shape_of(places.type).corners);
    const std::int64_t id = card.integer(0), property = card.integer(1, id);
    const auto section = properties.find(property);
    if (section == properties.end())
      throw std::invalid_argument(fmt::format(
          "{}: property {} of {} {} is no PSHELL of this file{}", card.where.text(), property, card.name, id,
          layered.contains(property)
              ? "; layers (PCOMP) are not read: give a PSHELL with their effective material"
              : ""));
    std::vector<Index> nodes(n_nodes, -1);
    for (std::size_t k = 0; k < n_nodes; ++k)  // mid-side nodes may be left out
      if (k < n || (!card.blank(2 + k) && card.integer(2 + k) != 0))
        nodes[k] = builder_.node(0, card.integer(2 + k), card.where);
    std::vector<Index> present = nodes;
    std::erase(present, -1);
    builder_.add_to_set("property " + std::to_string(property), present);
    if (n_nodes > n) ++split[card.name];
    if (const double extra = section->second.extra_mass_per_area;
        extra > 0) {  // an equal share for every corner
      const auto at = [&](std::size_t k) { return builder_.place(nodes[k]); };
      const Vector3d across =
          n == 3 ? (at(1) - at(0)).cross(at(2) - at(0)) : (at(2) - at(0)).cross(at(3) - at(1));
      for (std::size_t k = 0; k < n; ++k)
        extra_mass_[nodes[k]] += extra * 0.5 * across.norm() / static_cast<double>(n);
    }
    ModelBuilder::Cell& cell =
        builder_.cells()[builder_.add_cell(0, places.type, id, std::move(nodes), card.where)];
    cell.material = section->second.material;
    cell.thickness = section->second.thickness;
    cell.offset = card.real(places.offset, 0);  // an isotropic material has no direction THETA
    double sum = 0;
    std::size_t given = 0;
    for (std::size_t k = places.thickness; k < places.thickness + n; ++k)
      if (!card.blank(k)) sum += card.real(k), ++given;
    if (given == 0) continue;
    const bool scaled = card.integer(places.flag, 0) == 1;  // TFLAG: T1 to T4 are fractions of T
    const double others = static_cast<double>(n - given) * (scaled ? 1 : cell.thickness);
    const double mean = (sum + others) / static_cast<double>(n);
    cell.thickness = scaled ? mean * cell.thickness : mean;
    for (std::size_t k = places.thickness; k < places.thickness + n; ++k)
      if (!card.blank(k) && std::abs(card.real(k) * (scaled ? section->second.thickness : 1) -
                                     cell.thickness) > 1e-6 * cell.thickness)
        approximated_.add(card.name + "'s thicknesses that differ from corner to corner: their mean is used",
                          card.where);
  }
  for (const auto& [name, count] : split)
    model_.messages.push_back(fmt::format("{} element{} of type {}: {}", count, count == 1 ? "" : "s", name,
                                          ModelBuilder::split_shells()));
}

}  // namespace flexura::mesh
