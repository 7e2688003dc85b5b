// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_springs.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>
#include <stdexcept>

namespace flexura::mesh {

using Eigen::Vector3d;

void NastranSprings::add_scalar(const Card& card, double number, std::size_t first, bool damps, double loss) {
  const std::int64_t a = card.integer(first, 0), b = card.integer(first + 2, 0);
  if (a == 0 || b == 0) {
    deck_.unused.add(card.name + " to the ground (a superelement is a free body)", card.where);
    return;
  }
  const std::int64_t c = card.integer(first + 1, 0);
  if (c == 0 && card.integer(first + 3, 0) == 0) {
    deck_.approximated.add(card.name + " between scalar points: left out", card.where);
    return;
  }
  if (c != card.integer(first + 3, 0) || c < 1 || c > 6)
    throw std::invalid_argument(fmt::format(
        "{}: {} {} joins component {} of one node to {} of the other; equal ones from 1 to 6 are read",
        card.where.text(), card.name, card.integer(0), c, card.integer(first + 3, 0)));
  ImportedSpring spring{.label = card.integer(0)};
  spring.nodes = {deck_.node(a, card.where), deck_.node(b, card.where)};
  require_not_negative(number, fmt::format("{} {}", card.name, spring.label),
                       damps ? "coefficient" : "stiffness", card.where);
  (damps ? spring.damping : spring.stiffness)[static_cast<std::size_t>(c - 1)] = number;
  spring.loss = loss;
  spring.R = deck_.axes_at(a, card.where);
  if (!spring.R.isApprox(deck_.axes_at(b, card.where), 1e-9))
    throw std::invalid_argument(
        fmt::format("{}: {} {} joins nodes whose displacement axes (CD) differ; equal ones are read",
                    card.where.text(), card.name, card.integer(0)));
  const Vector3d line = deck_.systems.grid_place(b, card.where) - deck_.systems.grid_place(a, card.where);
  if (c < 4 && line.cross(spring.R.col(static_cast<Eigen::Index>(c - 1))).norm() > 1e-9 * line.norm())
    deck_.approximated.add(
        fmt::format(
            "{} across the line of its nodes, which would resist a turn of the whole body: it acts halfway "
            "between them, on rigid arms",
            card.name),
        card.where);
  deck_.model.springs.push_back(spring);
}

void NastranSprings::read() {
  struct Elas {
    double stiffness, loss;
  };
  std::map<std::int64_t, Elas> elas;
  for (const Card* card : deck_.all("PELAS"))
    for (const std::size_t k : {0u, 4u})
      if (!card->blank(k)) elas[card->integer(k)] = {card->real(k + 1), card->real(k + 2, 0)};
  for (const Card* card : deck_.all("CELAS1")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    if (!elas.contains(property))
      throw std::invalid_argument(fmt::format("{}: property {} of CELAS1 {} is no PELAS of this file",
                                              card->where.text(), property, card->integer(0)));
    add_scalar(*card, elas[property].stiffness, 2, false, elas[property].loss);
  }
  for (const Card* card : deck_.all("CELAS2"))
    deck_.faults.guard([&] { add_scalar(*card, card->real(1), 2, false, card->real(6, 0)); });
  deck_.faults.guard([&] { read_bushes(); });
  deck_.faults.guard([&] { read_lines(); });
  read_dampers();
}

void NastranSprings::read_dampers() {
  std::map<std::int64_t, double> damp;
  for (const Card* card : deck_.all("PDAMP"))
    for (const std::size_t k : {0u, 2u, 4u, 6u})
      if (!card->blank(k)) damp[card->integer(k)] = card->real(k + 1);
  for (const Card* card : deck_.all("CDAMP1")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    if (!damp.contains(property))
      throw std::invalid_argument(fmt::format("{}: property {} of CDAMP1 {} is no PDAMP of this file",
                                              card->where.text(), property, card->integer(0)));
    add_scalar(*card, damp[property], 2, true);
  }
  for (const Card* card : deck_.all("CDAMP2")) add_scalar(*card, card->real(1), 2, true);

  struct Visc {
    double along, about;
  };
  std::map<std::int64_t, Visc> visc;
  for (const Card* card : deck_.all("PVISC"))
    for (const std::size_t k : {0u, 4u})
      if (!card->blank(k)) visc[card->integer(k)] = {card->real(k + 1, 0), card->real(k + 2, 0)};
  for (const Card* card : deck_.all("CVISC")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    if (!visc.contains(property))
      throw std::invalid_argument(fmt::format("{}: property {} of CVISC {} is no PVISC of this file",
                                              card->where.text(), property, card->integer(0)));
    const auto [along, about] = visc[property];
    for (const double c : {along, about})
      require_not_negative(c, fmt::format("CVISC {}", card->integer(0)), "coefficient", card->where);
    ImportedSpring damper{.label = card->integer(0)};
    damper.nodes = {deck_.node(card->integer(2), card->where), deck_.node(card->integer(3), card->where)};
    damper.damping[0] = along, damper.damping[3] = about;
    const Vector3d line = deck_.systems.grid_place(card->integer(3), card->where) -
                          deck_.systems.grid_place(card->integer(2), card->where);
    if (!(line.norm() > 0))
      throw std::invalid_argument(
          fmt::format("{}: CVISC {} has no length, hence no direction", card->where.text(), damper.label));
    const Vector3d x = line.normalized(), y = x.unitOrthogonal();
    damper.R << x, y, x.cross(y);
    deck_.model.springs.push_back(damper);
  }
}

// CBUSH1D, PBUSH1D: along the line of the nodes, or along x of a system.
void NastranSprings::read_lines() {
  std::map<std::int64_t, const Card*> properties;
  for (const Card* card : deck_.all("PBUSH1D")) properties.emplace(card->integer(0), card);
  for (const Card* card : deck_.all("CBUSH1D")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    const auto of = properties.find(property);
    if (of == properties.end())
      throw std::invalid_argument(fmt::format("{}: property {} of CBUSH1D {} is no PBUSH1D of this file",
                                              card->where.text(), property, card->integer(0)));
    if (card->blank(3) || card->integer(3) == 0) {
      deck_.unused.add("CBUSH1D to the ground (a superelement is a free body)", card->where);
      continue;
    }
    ImportedSpring spring{.label = card->integer(0)};
    spring.nodes = {deck_.node(card->integer(2), card->where), deck_.node(card->integer(3), card->where)};
    spring.stiffness[0] = of->second->real(1, 0), spring.damping[0] = of->second->real(2, 0);
    require_not_negative(spring.stiffness[0], fmt::format("PBUSH1D {}", property), "stiffness",
                         of->second->where);
    require_not_negative(spring.damping[0], fmt::format("PBUSH1D {}", property), "coefficient",
                         of->second->where);
    if (of->second->real(3, 0) != 0)
      deck_.approximated.add("PBUSH1D's M: the mass that it adds is missing", of->second->where);
    const Vector3d a = deck_.systems.grid_place(card->integer(2), card->where),
                   line = deck_.systems.grid_place(card->integer(3), card->where) - a;
    if (!card->blank(4)) {
      spring.R = deck_.systems.system(card->integer(4), card->where).axes_at(a);
    } else {
      if (!(line.norm() > 0))
        throw std::invalid_argument(fmt::format("{}: CBUSH1D {} has no length, hence no direction",
                                                card->where.text(), spring.label));
      const Vector3d x = line.normalized(), y = x.unitOrthogonal();
      spring.R << x, y, x.cross(y);
    }
    deck_.model.springs.push_back(spring);
  }
}

void NastranSprings::read_bushes() {
  std::map<std::int64_t, Bush> bush;
  for (const Card* card : deck_.all("PBUSH"))
    for (std::size_t k = 1; k < card->fields.size(); k += 8) {
      const std::string word = card->text(k);
      if (word == "K" || word == "B") {
        Bush& to = bush[card->integer(0)];
        for (std::size_t d = 0; d < 6; ++d)
          (word == "K" ? to.stiffness : to.damping)[d] = card->real(k + 1 + d, 0);
      } else if (word == "GE") {
        bush[card->integer(0)].loss = card->real(k + 1, 0);
        for (std::size_t d = 1; d < 6; ++d)
          if (!card->blank(k + 1 + d) && card->real(k + 1 + d) != card->real(k + 1, 0))
            deck_.approximated.add("PBUSH's GE of several directions: the first is used of all", card->where);
      } else if (word == "M") {
        deck_.approximated.add("PBUSH's M: the mass that it adds is missing", card->where);
      } else if (!card->blank(k)) {
        deck_.unused.add("PBUSH's " + word, card->where);
      }
    }
  for (const Card* card : deck_.all("CBUSH")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    if (!bush.contains(property))
      throw std::invalid_argument(
          fmt::format("{}: property {} of CBUSH {} is no PBUSH with K or B of this file", card->where.text(),
                      property, card->integer(0)));
    if (card->blank(3) || card->integer(3) == 0) {
      deck_.unused.add("CBUSH to the ground (a superelement is a free body)", card->where);
      continue;
    }
    add_bush(*card, bush[property]);
  }
}

void NastranSprings::add_bush(const Card& card, const Bush& bush) {
  ImportedSpring spring{.label = card.integer(0)};
  spring.nodes = {deck_.node(card.integer(2), card.where), deck_.node(card.integer(3), card.where)};
  for (const double k : bush.stiffness)
    require_not_negative(k, fmt::format("CBUSH {}", spring.label), "stiffness", card.where);
  for (const double c : bush.damping)
    require_not_negative(c, fmt::format("CBUSH {}", spring.label), "coefficient", card.where);
  spring.stiffness = bush.stiffness;
  spring.damping = bush.damping;
  spring.loss = bush.loss;
  const Vector3d a = deck_.systems.grid_place(card.integer(2), card.where),
                 line = deck_.systems.grid_place(card.integer(3), card.where) - a;
  if (!card.blank(7)) {
    spring.R = deck_.systems.system(card.integer(7), card.where).axes_at(a);
  } else if (line.norm() > 0) {  // x along the line, y in the plane of the orientation
    Vector3d v = deck_.orientation(card, a, deck_.axes_at(card.integer(2), card.where));
    const auto across = [](const std::array<double, 6>& of) {
      return of[1] != 0 || of[2] != 0 || of[4] != 0 || of[5] != 0;
    };
    const bool along_alone = !across(bush.stiffness) && !across(bush.damping);
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
