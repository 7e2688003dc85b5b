// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_shells.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "mesh/model/cells/cell.hpp"

namespace flexura::mesh {

using Eigen::Vector3d;

namespace {

std::string key_of(const Eigen::Matrix3d& axes) {
  std::string key;
  for (const double c : axes.reshaped()) key += fmt::format("{:.0f} ", std::round(1e12 * c) + 0.0);
  return key;
}

}  // namespace

NastranShells::ShellProperty NastranShells::layered_property(const Card& card) {
  const std::string of = fmt::format("{} {}", card.name, card.integer(0)), option = card.text(7);
  if (!option.empty() && option != "SYM")
    throw std::invalid_argument(fmt::format("{}: {} has LAM {}, which is not read; SYM and blank are",
                                            card.where.text(), of, option));
  if (card.real(6, 0) != 0)
    deck_.approximated.add(card.name + "'s GE: the loss factors of the layers' materials are used",
                           card.where);
  std::vector<ShellLayer> layers;
  std::int64_t mid = 0;
  double thickness = 0, whole = 0;
  // PCOMPG: a line for each layer, its number first.
  const bool numbered = card.name == "PCOMPG";
  for (std::size_t k = numbered ? 9 : 8; k < card.fields.size(); k += numbered ? 8 : 4) {
    if (card.blank(k) && card.blank(k + 1) && card.blank(k + 2)) continue;
    if (!card.blank(k)) mid = card.integer(k);  // blank: as the layer below
    if (!card.blank(k + 1)) thickness = card.real(k + 1);
    require_positive(thickness, of, "layer thickness", card.where);
    layers.push_back(
        {deck_.shell_material(mid, card.where), thickness, card.real(k + 2, 0) * std::numbers::pi / 180});
    whole += thickness;
  }
  if (!(whole > 0)) throw std::invalid_argument(fmt::format("{}: {} has no layers", card.where.text(), of));
  if (option == "SYM") {
    whole *= 2;
    layers.insert(layers.end(), layers.rbegin(), layers.rend());
  }
  const ShellLayer& first = layers.front();
  const bool alike = std::ranges::all_of(layers, [&](const ShellLayer& layer) {
    return layer.material == first.material &&
           (layer.angle == first.angle ||
            !deck_.model.materials[static_cast<std::size_t>(first.material)].orthotropic);
  });
  ShellProperty shell{first.material, whole, card.real(2, 0), alike ? first.angle : 0.0,
                      card.real(1, -0.5 * whole) + 0.5 * whole};
  if (!alike) shell.layers = std::move(layers);
  return shell;
}

NastranShells::ShellProperty NastranShells::shell_property(const Card& card) {
  const std::int64_t mid = card.integer(1);
  ShellProperty shell{deck_.shell_material(mid, card.where), card.real(2, 0), card.real(7, 0)};
  if (card.blank(3))
    deck_.approximated.add("PSHELL's missing MID2 (membrane alone): bending is computed as well", card.where);
  else if (card.integer(3) != mid)
    deck_.approximated.add("PSHELL's MID2 other than MID1: MID1 is used for bending, too", card.where);
  if (std::abs(card.real(4, 1) - 1) > 1e-6)
    deck_.approximated.add("PSHELL's 12 I / T**3 other than 1: 1 is used", card.where);
  if (std::abs(card.real(6, 5.0 / 6) - 5.0 / 6) > 1e-3)
    deck_.approximated.add("PSHELL's TS/T other than 5/6: 5/6 is used", card.where);
  if (!card.blank(10))
    deck_.approximated.add("PSHELL's MID4: membrane and bending are computed without coupling", card.where);
  if (card.blank(5) && card.blank(6) && !card.blank(3))
    deck_.unused.add("PSHELL without MID3 (shear deformation is computed, that of thick shells)", card.where);
  return shell;
}

Eigen::Matrix3d NastranShells::axes_of_shell(const Card& card, const std::vector<Index>& nodes,
                                             std::size_t n_corners, std::size_t place) {
  const auto at = [&](std::size_t k) { return deck_.builder.place(nodes[k]); };
  const Vector3d normal =
      (n_corners == 3 ? (at(1) - at(0)).cross(at(2) - at(0)) : (at(2) - at(0)).cross(at(3) - at(1)))
          .normalized();
  Vector3d along = at(1) - at(0);
  double angle = 0;
  if (!card.blank(place) && !card.is_real(place)) {
    const NastranSystem& system = deck_.systems.system(card.integer(place), card.where);
    Vector3d middle = Vector3d::Zero();
    for (std::size_t k = 0; k < n_corners; ++k) middle += at(k) / static_cast<double>(n_corners);
    along = system.axes_at(middle).col(0);
  } else {
    angle = card.real(place, 0) * std::numbers::pi / 180;
  }
  const Vector3d in_plane = along - normal * normal.dot(along);
  if (!(in_plane.norm() > 1e-6 * along.norm()))
    throw std::invalid_argument(fmt::format("{}: the first axis of MCID {} stands upright on {} {}",
                                            card.where.text(), card.text(place), card.name, card.integer(0)));
  Eigen::Matrix3d axes;
  axes.col(0) = Eigen::AngleAxisd(angle, normal) * in_plane.normalized();
  axes.col(2) = normal;
  axes.col(1) = normal.cross(axes.col(0));
  return axes;
}

Index NastranShells::material_along(Index material, const Eigen::Matrix3d& axes, double angle) {
  return deck_.material_along(material,
                              axes * Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix());
}

Index NastranShells::material_of_shell(const ShellProperty& property, const Card& card,
                                       const std::vector<Index>& nodes, std::size_t n_corners,
                                       std::size_t place) {
  if (property.layers.empty() &&
      !deck_.model.materials[static_cast<std::size_t>(property.material)].orthotropic)
    return property.material;
  const Eigen::Matrix3d axes = axes_of_shell(card, nodes, n_corners, place);
  if (property.layers.empty()) return material_along(property.material, axes, property.angle);
  ImportedMaterial whole;
  whole.name = fmt::format("PCOMP {}", card.integer(1, card.integer(0)));
  whole.R = axes;
  for (const ShellLayer& layer : property.layers)
    whole.plies.push_back({material_along(layer.material, axes, layer.angle), layer.thickness});
  const auto [found, fresh] = laminates_.emplace(std::pair{whole.name, key_of(axes)},
                                                 static_cast<Index>(deck_.model.materials.size()));
  if (fresh) deck_.model.materials.push_back(std::move(whole));
  return found->second;
}

void NastranShells::read() {
  std::map<std::int64_t, ShellProperty> properties;
  std::set<std::int64_t> passed;  // fluids, and what is faulty
  for (const char* name : {"PSHELL", "PCOMP", "PCOMPG"})
    for (const Card* card : deck_.all(name)) {
      const std::int64_t id = card->integer(0);
      if (std::string(name) == "PSHELL" && !card->blank(1) && deck_.is_fluid(card->integer(1))) {
        passed.insert(id);
        continue;
      }
      deck_.faults.guard([&] {
        passed.insert(id);
        properties.emplace(id,
                           std::string(name) == "PSHELL" ? shell_property(*card) : layered_property(*card));
        passed.erase(id);
      });
    }
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
  std::map<Index, double> extra_mass;  // NSM
  for (const Card& card : deck_.cards()) {
    const auto found = kCards.find(card.name);
    if (found == kCards.end()) continue;
    deck_.mark_read(card.name);
    const ShellCard& places = found->second;
    const auto n_nodes = static_cast<std::size_t>(nodes_per_cell(places.type)),
               n = static_cast<std::size_t>(shape_of(places.type).corners);
    const std::int64_t id = card.integer(0), property = card.integer(1, id);
    if (passed.contains(property)) continue;
    const auto section = properties.find(property);
    if (section == properties.end()) {
      deck_.faults.add(fmt::format("{}: property {} of {} {} is no PSHELL, PCOMP or PCOMPG of this file",
                                   card.where.text(), property, card.name, id));
      continue;
    }
    std::vector<Index> nodes(n_nodes, -1);
    for (std::size_t k = 0; k < n_nodes; ++k)  // mid-side nodes may be left out
      if (k < n || (!card.blank(2 + k) && card.integer(2 + k) != 0))
        nodes[k] = deck_.node(card.integer(2 + k), card.where);
    std::vector<Index> present = nodes;
    std::erase(present, -1);
    deck_.builder.add_to_set("property " + std::to_string(property), present);
    if (n_nodes > n) ++split[card.name];
    if (const double extra = section->second.extra_mass_per_area;
        extra > 0) {  // an equal share for every corner
      const auto at = [&](std::size_t k) { return deck_.builder.place(nodes[k]); };
      const Vector3d across =
          n == 3 ? (at(1) - at(0)).cross(at(2) - at(0)) : (at(2) - at(0)).cross(at(3) - at(1));
      for (std::size_t k = 0; k < n; ++k)
        extra_mass[nodes[k]] += extra * 0.5 * across.norm() / static_cast<double>(n);
    }
    const Index along = material_of_shell(section->second, card, nodes, n, places.offset - 1);
    ModelBuilder::Cell& cell =
        deck_.builder.cells()[deck_.builder.add_cell(0, places.type, id, std::move(nodes), card.where)];
    cell.material = along;
    cell.thickness = section->second.thickness;
    cell.offset = card.real(places.offset, 0) + section->second.height;
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
        deck_.approximated.add(
            card.name + "'s thicknesses that differ from corner to corner: their mean is used", card.where);
  }
  for (const auto& [name, count] : split)
    deck_.model.messages.push_back(fmt::format("{} element{} of type {}: {}", count, count == 1 ? "" : "s",
                                               name, ModelBuilder::split_shells()));
  for (const auto& [node, mass] : extra_mass)
    deck_.model.masses.push_back({.label = 0, .node = node, .mass = mass});
}

}  // namespace flexura::mesh
