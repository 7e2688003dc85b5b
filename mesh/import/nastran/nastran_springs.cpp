// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_springs.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <stdexcept>

namespace flexura::mesh {

using Eigen::Vector3d;

void NastranSprings::add_scalar_spring(const Card& card, double stiffness, std::size_t first) {
  const std::int64_t a = card.integer(first, 0), b = card.integer(first + 2, 0);
  if (a == 0 || b == 0) {
    deck_.unused.add(card.name + " to the ground (a superelement is a free body)", card.where);
    return;
  }
  const std::int64_t c = card.integer(first + 1, 0);
  if (c != card.integer(first + 3, 0) || c < 1 || c > 6)
    throw std::invalid_argument(fmt::format(
        "{}: {} {} joins component {} of one node to {} of the other; equal ones from 1 to 6 are read",
        card.where.text(), card.name, card.integer(0), c, card.integer(first + 3, 0)));
  ImportedSpring spring{.label = card.integer(0)};
  spring.nodes = {deck_.node(a, card.where), deck_.node(b, card.where)};
  require_not_negative(stiffness, fmt::format("{} {}", card.name, spring.label), "stiffness", card.where);
  spring.stiffness[static_cast<std::size_t>(c - 1)] = stiffness;
  spring.R = deck_.axes_at(a, card.where);
  if (!spring.R.isApprox(deck_.axes_at(b, card.where), 1e-9))
    throw std::invalid_argument(
        fmt::format("{}: {} {} joins nodes whose displacement axes (CD) differ; equal ones are read",
                    card.where.text(), card.name, card.integer(0)));
  const Vector3d line = deck_.systems.grid_place(b, card.where) - deck_.systems.grid_place(a, card.where);
  if (c < 4 && line.cross(spring.R.col(static_cast<Eigen::Index>(c - 1))).norm() > 1e-9 * line.norm())
    throw std::invalid_argument(
        fmt::format("{}: {} {} acts in direction {} between nodes that do not lie one behind the other in "
                    "it, so that a "
                    "turn of the whole body would strain it; use CBUSH",
                    card.where.text(), card.name, card.integer(0), c));
  deck_.model.springs.push_back(spring);
}

void NastranSprings::read() {
  std::map<std::int64_t, double> elas;
  for (const Card* card : deck_.all("PELAS"))
    for (const std::size_t k : {0u, 4u})
      if (!card->blank(k)) elas[card->integer(k)] = card->real(k + 1);
  for (const Card* card : deck_.all("CELAS1")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    if (!elas.contains(property))
      throw std::invalid_argument(fmt::format("{}: property {} of CELAS1 {} is no PELAS of this file",
                                              card->where.text(), property, card->integer(0)));
    add_scalar_spring(*card, elas[property], 2);
  }
  for (const Card* card : deck_.all("CELAS2")) add_scalar_spring(*card, card->real(1), 2);

  std::map<std::int64_t, std::array<double, 6>> bush;
  for (const Card* card : deck_.all("PBUSH"))
    for (std::size_t k = 1; k < card->fields.size(); k += 8) {
      if (card->text(k) == "K") {
        auto& stiffness = bush[card->integer(0)];
        for (std::size_t d = 0; d < 6; ++d) stiffness[d] = card->real(k + 1 + d, 0);
      } else if (card->text(k) == "M") {
        deck_.approximated.add("PBUSH's M: the mass that it adds is missing", card->where);
      } else if (!card->blank(k)) {
        deck_.unused.add("PBUSH's " + card->text(k), card->where);
      }
    }
  for (const Card* card : deck_.all("CBUSH")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    if (!bush.contains(property))
      throw std::invalid_argument(fmt::format("{}: property {} of CBUSH {} is no PBUSH with K of this file",
                                              card->where.text(), property, card->integer(0)));
    if (card->blank(3) || card->integer(3) == 0) {
      deck_.unused.add("CBUSH to the ground (a superelement is a free body)", card->where);
      continue;
    }
    add_bush(*card, bush[property]);
  }
}

void NastranSprings::add_bush(const Card& card, const std::array<double, 6>& stiffness) {
  ImportedSpring spring{.label = card.integer(0)};
  spring.nodes = {deck_.node(card.integer(2), card.where), deck_.node(card.integer(3), card.where)};
  for (const double k : stiffness)
    require_not_negative(k, fmt::format("CBUSH {}", spring.label), "stiffness", card.where);
  spring.stiffness = stiffness;
  const Vector3d a = deck_.systems.grid_place(card.integer(2), card.where),
                 line = deck_.systems.grid_place(card.integer(3), card.where) - a;
  if (!card.blank(7)) {
    spring.R = deck_.systems.system(card.integer(7), card.where).axes_at(a);
  } else if (line.norm() > 0) {  // x along the line, y in the plane of the orientation
    Vector3d v = deck_.orientation(card, a, deck_.axes_at(card.integer(2), card.where));
    const bool along_alone = stiffness[1] == 0 && stiffness[2] == 0 && stiffness[4] == 0 && stiffness[5] == 0;
    if (along_alone && v.cross(line).norm() == 0) v = line.unitOrthogonal();
    if (!(v.cross(line).norm() > 1e-9 * v.norm() * line.norm()))
      throw std::invalid_argument(
          fmt::format("{}: CBUSH {} has no orientation vector", card.where.text(), card.integer(0)));
    const Vector3d x = line.normalized(), z = x.cross(v).normalized();
    spring.R << x, z.cross(x), z;
  }
  spring.place = card.real(8, 0.5);
  if (!card.blank(9) && card.integer(9) >= 0)
    spring.at = deck_.systems.system(card.integer(9), card.where)
                    .place({card.real(10, 0), card.real(11, 0), card.real(12, 0)});
  deck_.model.springs.push_back(spring);
}

}  // namespace flexura::mesh
