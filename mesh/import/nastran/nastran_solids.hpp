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
  void read_properties();

  NastranDeck& deck_;
  std::map<std::int64_t, Index> property_;      // its material
  std::set<std::int64_t> bubbles_, no_scheme_;  // PSOLID whose IN is BUBBLE, blank
};

}  // namespace flexura::mesh
