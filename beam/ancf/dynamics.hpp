// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include "beam/ancf/problem.hpp"

/// Implicit dynamics of one body by the generalised-alpha method for constrained systems of index 3 (M.
/// Arnold, O. Bruels, Multibody Syst. Dyn. 18 (2007) 185), second order in q, v and lambda, with fixed steps:
///
///     (1 - alpha_m) w_n+1 + alpha_m w_n = (1 - alpha_f) a_n+1 + alpha_f a_n
///     q_n+1 = q_n + dt v_n + dt^2 ((1/2 - beta) w_n + beta w_n+1)
///     v_n+1 = v_n + dt ((1 - gamma) w_n + gamma w_n+1)
///     alpha_m = (2 rho_inf - 1)/(rho_inf + 1),  alpha_f = rho_inf/(rho_inf + 1)
namespace flexura::beam::ancf {

struct DynamicOptions {
  double dt = 1e-3;          ///< [s]
  double rho_inf = 0.8;      ///< spectral radius at infinite frequency, 0 to 1 (1: no numerical damping)
  double tolerance = 1e-10;  ///< on the last correction: slopes as they are, positions over the body's length
  int max_iterations = 20;
};

struct DynamicState {
  double t = 0.0;
  Eigen::VectorXd q, v, a, lambda;
};

using Observer = std::function<void(const DynamicState&)>;

/// From (q, v) at t = 0 to t_end; the observer sees every state, the first too.  Driven coordinates take
/// their motion. Throws std::runtime_error naming the time where a step did not converge,
/// std::invalid_argument for options out of range.
DynamicState simulate(const Problem& problem, const Eigen::VectorXd& q, const Eigen::VectorXd& v,
                      double t_end, const DynamicOptions& options = {}, const Observer& observer = {});

}  // namespace flexura::beam::ancf
