// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/solver/position/assemble.hpp"

/// The position level of assemble.hpp with all that may be asked of it.  Prescribed coordinates stay where they
/// are if the others can close the loops; else they move as if 1e4 times as heavy, so by little more than the
/// others leave open.
namespace flexura::mbs {

struct ClosingOptions {
  std::vector<bool> keep;  ///< n_v, or empty for none: coordinates with prescribed positions
  /// n_v, or empty for none: coordinates that do not move at all, as deformations of bodies while joints close
  /// the loops.
  std::vector<bool> hold;
  /// Where nothing near the start closes the loops, starts far from it (up to 2.4 rad or typical sizes)
  /// are tried, too: what they find stands on another branch perhaps, but no body is bent.
  bool search_far = false;
  int max_iterations = 200;
  /// n_v, or empty for Equations::velocity_scale(): what counts as a large step of a coordinate, 1 rad or the mechanism's
  /// own length.
  Eigen::VectorXd large = {};
};

struct Closing {
  bool closed = false;       ///< or but for parts that do not fit exactly
  bool to_round_off = true;  ///< 1e-12 of the size of the mechanism
  AssembleReport report;
  // Where not closed:
  Eigen::VectorXd p, g;  ///< where the loops are open the least of all that was tried, and what is left there
  std::string worst;     ///< the rows that are open the widest
  std::string out_of_reach;  ///< rows that nothing can change, where all that is open is so by them; else ""
};

/// Moves s.p where the loops close, else leaves it.
Closing close_positions(const Equations& eq, State& s, const ClosingOptions& options);

/// What is open, by rows, and the remedy.
std::string why_open(const Closing& closing);

}  // namespace flexura::mbs
