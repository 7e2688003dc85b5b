// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <utility>
#include <vector>

#include "mesh/import/nastran/nastran_deck.hpp"

/// What binds nodes of a Nastran deck to each other: RBE1, RBE2, RBE3, RBAR, RROD, MPC.
namespace flexura::mesh {

class NastranConstraints {
 public:
  explicit NastranConstraints(NastranDeck& deck) : deck_(deck) {}

  void read(const std::filesystem::path& path);
  /// Once all elements are read: weights of RBE3 on rotations matter where nodes have some.
  void note_turning_weights();

 private:
  void read_ties();
  void read_rigid_bars();
  void read_rbe1();
  /// MPC of the set that the case control of `path` chooses, with MPCADD.
  void read_equations(const std::filesystem::path& path);

  NastranDeck& deck_;
  std::vector<std::pair<Index, Where>> turning_weights_;
};

}  // namespace flexura::mesh
