// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"

/// Consistent initial values from wished-for ones.
///
///     position      0 = g(p, t)       Levenberg-Marquardt steps d = -D^2 G^T (G D^2 G^T + mu)^-1 g with
///                                     D = M_ii^-1/2, each the smallest change in the norm of the masses;
///                                     p moves by retract(p, d)
///     velocity      0 = G v + g_t     the smallest change in the norm of M: impulses close the loops
///     acceleration                    see accelerations.hpp
namespace flexura::mbs {

/// The mechanism cannot be assembled; the text names the constraints with the largest residuals.
class AssemblyError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

struct AssembleOptions {
  /// Velocity coordinates (n_v, or empty for none) whose positions or velocities the user prescribed: they
  /// stay where they are if the constraints can be met by moving the others.
  std::vector<bool> keep_position, keep_velocity;
  int max_iterations = 200;
};

struct AssembleReport {
  int iterations = 0;
  double position_residual = 0.0;  ///< largest |g| left
  double velocity_residual = 0.0;  ///< largest |G v + g_t| left
  double position_change = 0.0;    ///< largest single step component taken, summed over the iterations
  bool positions_kept = true;      ///< false: prescribed positions had to be moved
  bool velocities_kept = true;     ///< false: prescribed velocities had to be changed
  int constraint_rank = 0;  ///< of G at the assembled state; below n_lambda rows depend on each other here
  std::vector<std::string> notes;  ///< sentences for the user about what could not be kept
};

/// Position level alone.  Throws AssemblyError.
AssembleReport assemble_positions(const Equations& eq, State& s, const AssembleOptions& options = {});

/// Velocity level alone, at assembled positions.  Throws AssemblyError.
void assemble_velocities(const Equations& eq, State& s, const AssembleOptions& options,
                         AssembleReport& report);

/// All levels: s.p, s.v, s.lambda, s.a and v_dot (n_v).  Throws AssemblyError or std::runtime_error.
AssembleReport assemble(const Equations& eq, State& s, Eigen::VectorXd& v_dot,
                        const AssembleOptions& options = {});

}  // namespace flexura::mbs
