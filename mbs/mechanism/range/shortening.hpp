// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/superelement/superelement.hpp"

/// What bending does to the distance between two interfaces, and what it costs where something holds them apart.
///
/// A line that bends by w between its ends gets shorter by u = 1/2 int w'^2 dx, against its chord.  Displacements
/// linear in the modal coordinates know nothing of it: free ends stand wrong by u, held ends lack the membrane force
/// N = h u / c that it takes to keep them apart, c the compliance of the body for a pair of forces at its ends,
/// h = 1 - c_m / c with c_m that of the mechanism with the body in it: 1 for rigid surroundings, 0 for none.  Beside a
/// strain energy U of the linear deformation, 1/2 k w^2, the held ends' is N u / 2 = 1/4 k_3 w^4 with the force
/// k w + k_3 w^3, so N u / U = k_3 w^2 / k is the part of the stiffness that is left out.
namespace flexura::mbs {

/// A line of places of the surface from one interface of a body to another.
struct BendingLine {
  int from = 0, to = 0;     ///< nodes of the body
  double compliance = 0.0;  ///< c of the whole superelement, for a pair of unit forces along the line [m/N]
  Eigen::MatrixXd Q{};      ///< m x m: u = s^T Q s, the chord's own turn taken out
  Eigen::VectorXd pull{};   ///< m: what s does to the distance, to first order
};

/// Of a body with the modal coordinates of `data` (u_se = Y s).  Pairs of interfaces that the surface does not lead
/// straight from one to the other have none, nor those without all translations.  Needs matrices, surface and shapes.
std::vector<BendingLine> bending_lines(const superelement::Superelement& se, const ModalData& data);

/// h of a line of `body` in the state s, within the time `span` [s] (inertia holds what is slow to move; 0: statics);
/// 0 where the modes do not let the distance change, so that nothing is known.
double how_held(const Mechanism& mechanism, int body, const BendingLine& line, const State& s, double span);

}  // namespace flexura::mbs
