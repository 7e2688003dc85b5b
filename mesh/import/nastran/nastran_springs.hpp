// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

#include "mesh/import/nastran/nastran_deck.hpp"

/// Springs of a Nastran deck: CELAS1, CELAS2, CBUSH.
namespace flexura::mesh {

class NastranSprings {
 public:
  explicit NastranSprings(NastranDeck& deck) : deck_(deck) {}

  void read();

 private:
  /// One component of two nodes.  Between nodes that stand apart only stretch along their line leaves the body free to
  /// turn.
  void add_scalar_spring(const Card& card, double stiffness, std::size_t first);
  void add_bush(const Card& card, const std::array<double, 6>& stiffness);

  NastranDeck& deck_;
};

}  // namespace flexura::mesh
