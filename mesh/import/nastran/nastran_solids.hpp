// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/import/nastran/nastran_deck.hpp"

namespace flexura::mesh {

/// Reads the solids of a Nastran deck (CTETRA, CHEXA, CPENTA, CPYRAM, linear and quadratic) with PSOLID.
class NastranSolids {
 public:
  explicit NastranSolids(NastranDeck& deck) : deck_(deck) {}

  void read();

 private:
  struct Property {
    Index material;
    std::int64_t system;  // CORDM
    Where where;
  };
  void read_properties();
  /// Along the axes of the property where the material has directions.
  Index material_of(const Property& property, const std::vector<Index>& nodes);

  NastranDeck& deck_;
  std::map<std::int64_t, Property> property_;
  std::set<std::int64_t> bubbles_, no_scheme_;  // PSOLID whose IN is BUBBLE, blank
  std::set<std::int64_t> fluids_, faulty_;
};

}  // namespace flexura::mesh
