// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/solver/linear/linearise.hpp"

/// The linear system about a state without elimination, as descriptor matrices:
///
///     E x' = A x + B u,   y = C x + D u,   x = (q, v, c, a, lambda)
///
/// q are the n_v integrals of the velocities, in coordinates that move along (dp = T dq), so that
///
///     q'   = (T^+ (d(Tv)/dp T - T')) q + v                           E = diag(1, M, 1, 0, 0)
///     M v' = -z_q q - z_v v - z_c c - z_a a - G^T lambda + u
///     c'   = f_c,      0 = b,      0 = G q + g_c c + g_u u   (h_q q + G v + h_c c + h_u u for a row without a position level)
///
/// of index 3 where there are constraints.  E and A keep the mechanism's sparsity.  Its finite eigenvalues
/// are those of the system in independent coordinates (linearise()), plus zeros for what the constraints
/// hold.
namespace flexura::mbs {

struct DescriptorSystem {
  Eigen::MatrixXd E, A, B, C, D;
  std::vector<std::string> states, inputs, outputs;
  Eigen::VectorXd x_0, u_0, y_0;
};

/// `s` must be consistent (assembled).  Throws std::runtime_error.
DescriptorSystem linearise_as_descriptor(const Equations& eq, const State& s,
                                         const LineariseOptions& options = {});

}  // namespace flexura::mbs
