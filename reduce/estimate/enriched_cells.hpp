// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/elements/material.hpp"
#include "reduce/elements/solid.hpp"

/// Matrices of cells in the functions w that they gain (enrichment.hpp) and those of their own, v: eight cells of a type
/// are computed together, each in a lane of the machine's registers, in single precision.
namespace flexura::reduce {

class EnrichedCells {
 public:
  static constexpr int kLanes = 8;

  EnrichedCells(mesh::CellType type, const std::vector<Material>& materials);

  int n_gained() const { return g_; }
  int n_own() const { return m_; }
  /// Gained functions first.
  int n() const { return g_ + m_; }

  /// What a lane is given.
  struct Cell {
    NodePositions x;           ///< [m]; no rows: the lane is idle
    std::size_t material = 0;  ///< place in the materials
    std::vector<float> sign;   ///< n: 1; -1 for an edge that runs the other way; 0 leaves a function out
  };
  /// The cells, the first of which is not idle.
  void take(const Cell (&cells)[kLanes]);

  /// What loads the gained functions, for the cells taken.
  void compute_coupling();
  /// The stiffness of all functions and its inverse, for the cells taken.  A cell by itself is free to move: the inverse
  /// is that of a cell with a footing.
  void compute_stiffness();

  /// r = lambda m(u, w) - a(u, w) of a lane for 16 states, after compute_coupling.  u: 3 m x 16 displacements of its nodes by
  /// rows, with the rigid motion of the cell's middle, which is taken out before strains are made in single precision.
  /// r: 3 g x 16.
  void residual(int lane, const double* u, const double* lambda, float* r) const;

  /// Matrices of a lane, by rows.  Functions that are left out stand alone and have no load.
  void copy_diagonal(int lane, float* K_ww) const;  ///< 3 g
  void copy_stiffness(int lane, float* K) const;    ///< 3 n x 3 n
  void copy_inverse(int lane, float* B) const;      ///< 3 n x 3 n

 private:
  struct Term {
    int a, b, from, entry;  ///< K(a, b) += D[entry] H[from]
  };
  int g_, m_;
  const TabulatedRule& rule_;
  const std::vector<Material>& materials_;
  std::vector<Term> terms_;
  std::vector<float> functions_;  ///< of each point: values, then derivatives (n x 3)
  std::vector<float> centre_;     // derivatives of a cell's own functions there (m x 3)
  // Eight lanes each.
  std::vector<float> place_, turn_, map_, D_, density_, sign_, gradients_, coupling_, mass_, diagonal_, K_,
      inverse_;
};

}  // namespace flexura::reduce
