// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "mesh/import/nastran/nastran_deck.hpp"

/// Springs and dampers of a Nastran deck: CELAS1, CELAS2, CBUSH, CBUSH1D, CDAMP1, CDAMP2, CVISC.
namespace flexura::mesh {

class NastranSprings {
 public:
  explicit NastranSprings(NastranDeck& deck) : deck_(deck) {}

  void read();

 private:
  /// Of a property PBUSH.
  struct Bush {
    std::array<double, 6> stiffness{}, damping{};
    double loss = 0;
  };

  /// One component of two nodes: `number` is the stiffness or the coefficient of a damper.  Between nodes that stand apart only
  /// stretch along their line leaves the body free to turn.
  void add_scalar(const Card& card, double number, std::size_t first, bool damps, double loss = 0);
  void add_bush(const Card& card, const Bush& bush);
  void read_dampers();
  void read_bushes();
  void read_lines();

  NastranDeck& deck_;
};

}  // namespace flexura::mesh
