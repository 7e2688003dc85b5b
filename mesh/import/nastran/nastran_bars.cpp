// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_bars.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <stdexcept>

#include "mesh/import/nastran/nastran_sections.hpp"

namespace flexura::mesh {

using Eigen::Vector3d;

ImportedBar NastranBars::shaped_section(const Card& card) {
  const std::string type = card.text(3);
  ImportedBar bar;
  bar.material = deck_.material(card.integer(1), card.where);
  std::size_t n = 0;
  Eigen::Vector2d shear_centre;
  try {
    n = nastran_dimensions(type);
    std::vector<double> dim;
    for (std::size_t k = 0; k < n; ++k) dim.push_back(card.real(8 + k, 0));
    const BarSection s = nastran_section(type, dim);
    bar.A = s.A, bar.I_yy = s.I_yy, bar.I_zz = s.I_zz, bar.I_yz = s.I_yz, bar.J = s.J;
    bar.kappa_y = s.kappa_y, bar.kappa_z = s.kappa_z;
    bar.outline = s.outline;
    shear_centre << s.shear_y, s.shear_z;
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(
        fmt::format("{}: {} {}: {}", card.where.text(), card.name, card.integer(0), error.what()));
  }
  if (card.name == "PBEAML") {  // CBAR knows one centre only
    bar.centroid = -shear_centre;
    if (type == "BOX1")
      deck_.approximated.add("PBEAML BOX1: its shear centre is taken at the centroid", card.where);
  }
  bar.extra_mass_per_length = card.real(8 + n, 0);
  for (std::size_t k = 8 + n + 1; card.name == "PBEAML" && k < card.fields.size(); ++k)
    if (card.text(k).rfind("YES", 0) == 0 || card.text(k) == "NO") {
      // A station repeats the dimensions of end A where the beam is uniform.
      bool same = card.text(k).rfind("YES", 0) == 0;
      for (std::size_t d = 0; d < n; ++d)
        same = same && (card.blank(k + 2 + d) || card.real(k + 2 + d) == card.real(8 + d, 0));
      if (!same) deck_.approximated.add("PBEAML's stations: end A is used all along", card.where);
      break;
    }
  return bar;
}

// C1, C2 to F1, F2 of PBAR and PBEAM.
std::vector<Eigen::Vector2d> NastranBars::stress_points(const Card& card) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t k = 8; k < 16; k += 2) points.emplace_back(card.real(k, 0), card.real(k + 1, 0));
  return hull(std::move(points));
}

void NastranBars::read_rods() {
  std::map<std::int64_t, const Card*> properties;
  for (const Card* card : deck_.all("PROD")) properties.emplace(card->integer(0), card);
  const auto add = [&](const Card& card, std::size_t nodes, std::int64_t mid, const Card& from,
                       std::size_t first) {
    ImportedBar rod;
    rod.label = card.integer(0);
    rod.nodes = {deck_.node(card.integer(nodes), card.where),
                 deck_.node(card.integer(nodes + 1), card.where)};
    rod.material = deck_.material(mid, from.where);
    rod.A = from.real(first);
    rod.J = from.real(first + 1, 0);
    rod.extra_mass_per_length = from.real(first + 3, 0);
    require_section(rod, fmt::format("{} {}", card.name, rod.label), from.where);
    deck_.model.bars.push_back(rod);
  };
  for (const Card* card : deck_.all("CROD")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    const auto found = properties.find(property);
    if (found == properties.end())
      throw std::invalid_argument(fmt::format("{}: property {} of CROD {} is no PROD of this file",
                                              card->where.text(), property, card->integer(0)));
    add(*card, 2, found->second->integer(1), *found->second, 2);
  }
  for (const Card* card : deck_.all("CONROD")) add(*card, 1, card->integer(3), *card, 4);
}

// CTUBE, PTUBE: a rod of outer diameter OD and wall T, solid without one.
void NastranBars::read_tubes() {
  std::map<std::int64_t, const Card*> properties;
  for (const Card* card : deck_.all("PTUBE")) properties.emplace(card->integer(0), card);
  for (const Card* card : deck_.all("CTUBE")) {
    const std::int64_t property = card->integer(1, card->integer(0));
    const auto found = properties.find(property);
    if (found == properties.end())
      throw std::invalid_argument(fmt::format("{}: property {} of CTUBE {} is no PTUBE of this file",
                                              card->where.text(), property, card->integer(0)));
    const Card& of = *found->second;
    const double outer = of.real(2), wall = of.real(3, 0), second = of.real(5, outer);
    require_positive(outer, fmt::format("PTUBE {}", property), "diameter", of.where);
    if (!(wall >= 0 && wall <= outer / 2))
      throw std::invalid_argument(
          fmt::format("{}: PTUBE {} has the wall {:g}; it must be from 0 to half of OD = {:g}",
                      of.where.text(), property, wall, outer));
    if (second != outer) deck_.approximated.add("PTUBE's OD2 other than OD: OD is used all along", of.where);
    const BarSection s = wall > 0 && wall < outer / 2 ? tube(outer / 2, outer / 2 - wall) : circle(outer / 2);
    ImportedBar rod;
    rod.label = card->integer(0);
    rod.nodes = {deck_.node(card->integer(2), card->where), deck_.node(card->integer(3), card->where)};
    rod.material = deck_.material(of.integer(1), of.where);
    rod.A = s.A, rod.J = s.J;
    rod.extra_mass_per_length = of.real(4, 0);
    deck_.model.bars.push_back(rod);
  }
}

ImportedBar NastranBars::section(std::int64_t property, const Card& bar) {
  for (const Card* card : deck_.all("PBAR")) {
    if (card->integer(0) != property) continue;
    ImportedBar s;
    s.material = deck_.material(card->integer(1), card->where);
    s.A = card->real(2, 0);
    s.I_zz = card->real(3, 0);  // plane 1 is the x-y plane
    s.I_yy = card->real(4, 0);
    s.J = card->real(5, 0);
    s.extra_mass_per_length = card->real(6, 0);
    s.kappa_y = card->real(16, 0);
    s.kappa_z = card->real(17, 0);
    s.I_yz = card->real(18, 0);
    s.outline = stress_points(*card);
    return s;
  }
  for (const Card* card : deck_.all("PBEAM")) {
    if (card->integer(0) != property) continue;
    ImportedBar s;
    s.material = deck_.material(card->integer(1), card->where);
    s.A = card->real(2);
    s.I_zz = card->real(3);
    s.I_yy = card->real(4);
    s.I_yz = card->real(5, 0);
    s.J = card->real(6, 0);
    s.extra_mass_per_length = card->real(7, 0);
    s.kappa_y = s.kappa_z = 1;  // the card's default
    // Stress points, then stations (each with stress points of its own after YES), then K1, K2.
    const auto is_station = [&](std::size_t k) {
      return card->text(k).rfind("YES", 0) == 0 || card->text(k) == "NO";
    };
    std::size_t at = is_station(8) ? 8 : 16;
    bool tapered = false;
    while (is_station(at)) {
      for (std::size_t d = 0; d < 6; ++d)  // A, I1, I2, I12, J, NSM; blank: as at end A
        tapered =
            tapered || (!card->blank(at + 2 + d) &&
                        std::abs(card->real(at + 2 + d) - card->real(2 + d, 0)) >
                            1e-4 * std::abs(card->real(at + 2 + d)));  // fields of eight characters round
      at += card->text(at) == "YES" ? 16 : 8;
    }
    s.kappa_y = card->real(at, 1);
    s.kappa_z = card->real(at + 1, 1);
    s.extra_mass_at = {card->real(at + 8, 0), card->real(at + 9, 0)};
    s.centroid = {card->real(at + 12, 0), card->real(at + 13, 0)};
    if (!is_station(8)) s.outline = stress_points(*card);
    for (Eigen::Vector2d& point : s.outline) point -= s.centroid;  // given from the line of shear centres
    for (const std::size_t k : {8u, 9u, 12u, 13u})
      tapered = tapered || (!card->blank(at + k + 2) && card->real(at + k + 2) != card->real(at + k, 0));
    if (tapered) deck_.approximated.add("PBEAM's taper: end A is used all along", card->where);
    return s;
  }
  for (const char* name : {"PBARL", "PBEAML"})
    for (const Card* card : deck_.all(name))
      if (card->integer(0) == property) return shaped_section(*card);
  throw std::invalid_argument(
      fmt::format("{}: property {} of {} {} is no PBAR, PBARL, PBEAM or PBEAML of this file",
                  bar.where.text(), property, bar.name, bar.integer(0)));
}

// OFFT, three letters: of the orientation (G displacement axes, B basic system) and of the offset at each end (G, O: the
// element's own axes, x from node to node and y in the plane of the orientation).
std::string NastranBars::axes_of_vectors(const Card& card, const Card* defaults) {
  std::string offt = card.text(7);
  if (offt.empty() && defaults) offt = defaults->text(7);
  if (offt.empty() || card.is_real(7)) return "GGG";  // CBEAM has BIT there, too
  // Once the field told whether the orientation is a vector (1) or a grid point (2), which fields 6 to 8 tell by themselves.
  if (offt == "1" || offt == "2") return "GGG";
  const bool known = offt.size() == 3 && (offt[0] == 'G' || offt[0] == 'B') &&
                     (offt[1] == 'G' || offt[1] == 'O') && (offt[2] == 'G' || offt[2] == 'O');
  if (!known)
    throw std::invalid_argument(
        fmt::format("{}: OFFT of {} {} is \"{}\"; GGG, BGG, GGO, BGO, GOG, BOG, GOO and BOO are known",
                    card.where.text(), card.name, card.integer(0), offt.substr(0, 20)));
  return offt;
}

void NastranBars::read() {
  deck_.faults.guard([&] { read_bars(); });
  deck_.faults.guard([&] { read_rods(); });
  deck_.faults.guard([&] { read_tubes(); });
}

void NastranBars::read_bars() {
  for (const char* name : {"CBAR", "CBEAM"}) {
    const std::vector<const Card*>& given = deck_.all(std::string(name) == "CBAR" ? "BAROR" : "BEAMOR");
    const Card* defaults = given.empty() ? nullptr : given.front();
    for (const Card* card : deck_.all(name))
      deck_.faults.guard([&] {
        const std::int64_t id = card->integer(0);
        ImportedBar bar = section(card->integer(1, defaults ? defaults->integer(1, id) : id), *card);
        bar.label = id;
        bar.nodes = {deck_.node(card->integer(2), card->where), deck_.node(card->integer(3), card->where)};
        const Vector3d a = deck_.systems.grid_place(card->integer(2), card->where),
                       x = deck_.systems.grid_place(card->integer(3), card->where) - a;
        const std::string offt = axes_of_vectors(*card, defaults);
        const bool has_own = !(card->blank(4) && card->blank(5) && card->blank(6));
        bar.orientation = deck_.orientation(
            has_own || !defaults ? *card : *defaults, a,
            offt[0] == 'B' ? Eigen::Matrix3d::Identity() : deck_.axes_at(card->integer(2), card->where));
        Eigen::Matrix3d own;  // of the element
        const Vector3d z = x.cross(bar.orientation).normalized();
        own << x.normalized(), z.cross(x.normalized()), z;
        for (std::size_t end = 0; end < 2; ++end) {
          const Vector3d offset(card->real(10 + 3 * end, 0), card->real(11 + 3 * end, 0),
                                card->real(12 + 3 * end, 0));
          if (!offset.isZero(0.0))
            bar.offset[end] =
                (offt[1 + end] == 'O' ? own : deck_.axes_at(card->integer(2 + end), card->where)) * offset;
        }
        bar.released = {components(card->text(8), *card), components(card->text(9), *card)};
        if (!(bar.orientation.norm() > 0))
          throw std::invalid_argument(
              fmt::format("{}: {} {} has no orientation vector", card->where.text(), name, id));
        require_section(bar, fmt::format("{} {}", name, id), card->where);
        deck_.model.bars.push_back(bar);
      });
  }
}

}  // namespace flexura::mesh
