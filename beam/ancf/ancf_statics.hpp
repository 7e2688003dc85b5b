// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/ancf/problem.hpp"

/// Static equilibria by Newton's method with load steps.
///
/// Each load step is tried with full Newton steps and the extrapolated stress of Element::add_force in the
/// tangent first: some six iterations whatever the slenderness.  Where that fails, by plain Newton with a
/// line search: a step s dq is taken when the simplified correction from the trial point, solved with the
/// same factor, is shorter, |dq_bar(q + s dq)| <= (1 - s/4) |dq| (natural monotonicity, P. Deuflhard, Newton
/// Methods for Nonlinear Problems, ch. 3).  It measures displacements, so the residual's units (a stretch
/// costs 1e6 times a bend) do not matter, as they do when the residual itself has to fall.  Where both fail
/// the load step is halved.
namespace flexura::beam::ancf {

struct StaticOptions {
  int steps = 1;             ///< load steps to start with; halved and grown as convergence asks
  double tolerance = 1e-11;  ///< on the last correction: slopes as they are, positions over the body's length
  int max_iterations = 40;   ///< of one load step
  double smallest_step = 1e-5;
};

struct StaticResult {
  Eigen::VectorXd q, lambda;
  int iterations = 0;  ///< Newton iterations in all
  int steps = 0;       ///< load steps taken
};

/// From q_start at load factor 0 to the solution at 1; drives follow the factor too.  Throws
/// std::runtime_error naming the factor at which the solution was lost, std::invalid_argument for sizes that
/// do not fit.
StaticResult solve_static(const Problem& problem, const Eigen::VectorXd& q_start,
                          const StaticOptions& options = {});

}  // namespace flexura::beam::ancf
