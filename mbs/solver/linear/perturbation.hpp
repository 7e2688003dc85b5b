// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "mbs/solver/algebra/tangents.hpp"

/// The equations of small changes about a consistent state, before anything is eliminated.  With dp = T dq, dq in
/// coordinates that move along, and inputs u (Equations::n_inputs):
///
///     dq'  = W dq + dv
///     0    = M dv' + z_q dq + z_v dv + z_c dc + z_a da + z_u u + G^T dlambda              (first n_v rows of z)
///     dc'  =         z_q dq + z_v dv + z_c dc + z_a da + z_u u + c_v_dot dv' + c_lambda dlambda
///     0    =         z_q dq + z_v dv + z_c dc + z_a da + z_u u + b_v_dot dv' + b_lambda dlambda
///     0    = G dq + g_c dc + g_u u                                                         rows with positions
///     0    = h_q dq + G dv + h_c dc + h_u u + h_u' u'
///     0    = a_q dq + a_v dv + a_c dc + a_a da + G dv' + a_u u + a_u' u' + a_u'' u''
///
/// Forces come from exact tangents.  The accelerations of constraint rows, which hold no forces, and what inputs change
/// come from central differences of order 4 with steps of 1e-4 of the typical size, which leave 1e-12 of the terms.
namespace flexura::mbs {

struct Perturbation {
  using Matrix = Eigen::MatrixXd;
  /// `s` with its multipliers and algebraic states; columns of inputs are those of `inputs`.
  Perturbation(const Equations& eq, const State& s, const Eigen::VectorXd& v_dot,
               const std::vector<int>& inputs);

  Tangents t;
  Matrix z_q, h_q, W;
  Matrix g_c, h_c;  ///< 0 where no row follows states
  Matrix a_q, a_v, a_c, a_a;
  Matrix z_u, g_u;
  std::array<Matrix, 2> h_u;
  std::array<Matrix, 3> a_u;
  std::vector<std::string> names;  ///< of the integrals of velocities
  Matrix T_inverse;                ///< dq = T^+ dp (n_v x n_p)

 private:
  void kinematics(const Equations& eq, const State& s);
};

/// Derivative of f at 0 by its argument, which is moved by steps of `step` and twice that: order 4.
template <class Function>
Eigen::VectorXd difference(const Function& f, double step) {
  const Eigen::VectorXd near = f(step) - f(-step), far = f(2.0 * step) - f(-2.0 * step);
  return (8.0 * near - far) / (12.0 * step);
}

/// Dynamic states that hold their value between events, whatever the motion and the inputs do (the position of a relay, a
/// sampled value): their rates are zero at this and at other states.
std::vector<bool> held_states(const Equations& eq, const State& s, const Eigen::VectorXd& v_dot);

}  // namespace flexura::mbs
