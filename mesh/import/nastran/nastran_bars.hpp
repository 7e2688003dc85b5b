// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mesh/import/nastran/nastran_deck.hpp"

/// Beams and rods of a Nastran deck: CBAR, CBEAM, CROD, CONROD, CTUBE with PBAR, PBARL, PBEAM, PBEAML, PROD, PTUBE.
namespace flexura::mesh {

class NastranBars {
 public:
  explicit NastranBars(NastranDeck& deck) : deck_(deck) {}

  void read();

 private:
  static std::vector<Eigen::Vector2d> stress_points(const Card& card);
  static std::string axes_of_vectors(const Card& card, const Card* defaults);
  /// PBARL, PBEAML.
  ImportedBar shaped_section(const Card& card);
  ImportedBar section(std::int64_t property, const Card& bar);
  void read_bars();
  /// CROD with PROD, CONROD alone: stretch and, with J, torsion.
  void read_rods();
  void read_tubes();

  NastranDeck& deck_;
};

}  // namespace flexura::mesh
