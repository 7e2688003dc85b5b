// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "beam/ancf/problem.hpp"

/// Small vibrations about an equilibrium, at rest or in steady rotation.  In the frame of the problem's spin
/// the coordinates of a steadily rotating body are constant, and with q = q_0 + x e^(s t)
///
///     (s^2 M + s (D + 2 m (x) Omega~) + K + m (x) Omega~^2) x + G^T lambda = 0,   G x = 0:
///
/// Coriolis and centrifugal terms are constant matrices, geometric stiffening sits in the tangent K at q_0.
namespace flexura::beam::ancf {

struct Vibrations {
  /// Eigenvalues s = -delta + i omega with omega >= 0, ordered by |s| [1/s]; real eigenvalues appear too.
  Eigen::VectorXcd s;
  Eigen::MatrixXcd modes;  ///< n_q x s.size(), largest coordinate 1
};

/// `scale` [rad/s] is of the order of the frequencies of interest: the quadratic problem is turned inside out
/// about s = scale, so the lowest modes come out most exactly, and it is solved dense, O(n^3).  q and lambda
/// are an equilibrium of the problem (solve_static).  Throws std::invalid_argument for scale <= 0,
/// std::runtime_error when the shifted matrix is singular.
Vibrations vibrations(const Problem& problem, const Eigen::VectorXd& q, const Eigen::VectorXd& lambda,
                      double scale);

}  // namespace flexura::beam::ancf
