// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "reduce/beams/numbering.hpp"
#include "reduce/beams/statics.hpp"
#include "reduce/recovery/stiffening.hpp"

/// Geometric stiffening of a structure of beams, as reduce/recovery/stiffening.hpp for solids: for the axial
/// forces N(x) of the same unit loads, K_0 = T^T K_G T with
///
///     q^T K_G q = sum of elements int N (v'^2 + w'^2 + r^2 theta_x'^2) dx,     r^2 = (I_y + I_z) / A
///
/// (J. S. Przemieniecki, Theory of Matrix Structural Analysis, 1968, chapter 15), v and w the exact static
/// shapes of the element.  Bending moments, shear forces and torques have no term: these are the terms of
/// beams that are pulled or pressed (blades, columns, strings, frames that buckle by their columns), not of
/// beams that tilt sideways out of bending.
namespace flexura::reduce {

/// The axial forces of the unit loads, in the order of the terms: 12 of motion (K0t, K0r, K0omega), then those on the interface dofs
/// (K0F), then the load cases (K0p).
class UnitTensions {
 public:
  static constexpr int kInertiaLoads = 12;

  /// The loads are balanced at the first interface that keeps all six directions.  Throws std::invalid_argument where there
  /// is none, and for a structure with solids.  Structure and cases outlive it.
  UnitTensions(const Structure& structure, const std::vector<BeamInterface>& interfaces,
               const std::vector<LoadCase>& cases);
  Eigen::Index first_case() const { return kInertiaLoads + static_cast<Eigen::Index>(dof_of_load_.size()); }
  Eigen::Index loads() const { return first_case() + static_cast<Eigen::Index>(cases_.size()); }
  const std::vector<int>& dof_of_load() const {
    return dof_of_load_;
  }  ///< of each interface dof; -1: it balances
  /// Of each load at x of the mesh's element e [N].
  Eigen::VectorXd at(int e, const beam::Element& element, double x) const;
  double radius2(int e, double x) const;  ///< r^2 there [m^2]

 private:
  const beam::BeamMesh& mesh_;
  const std::vector<LoadCase>& cases_;
  std::vector<std::array<beam::LineLoad, kInertiaLoads>> lines_;  // on each element
  std::vector<int> dof_of_load_;
  Eigen::MatrixXd U_;  // n_dofs x loads
};

/// `T` (n_dofs x n) the shapes on all dofs of the structure.  Throws as UnitTensions.
StiffeningTerms beam_stiffening_terms(const Structure& structure,
                                      const std::vector<BeamInterface>& interfaces, const Eigen::MatrixXd& T,
                                      const std::vector<LoadCase>& cases = {});

}  // namespace flexura::reduce
