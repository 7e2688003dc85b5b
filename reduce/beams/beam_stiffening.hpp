// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

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

/// `T` (n_dofs x n) the shapes on all dofs of the structure.  The loads are balanced at the first interface
/// that keeps all six directions.  Throws std::invalid_argument where there is none, and for a structure with
/// solids.
StiffeningTerms beam_stiffening_terms(const Structure& structure,
                                      const std::vector<BeamInterface>& interfaces, const Eigen::MatrixXd& T,
                                      const std::vector<LoadCase>& cases = {});

}  // namespace flexura::reduce
