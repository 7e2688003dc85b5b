// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "mbs/solver/prepare.hpp"
#include "mbs/solver/run.hpp"
#include "mbs/study/shadows.hpp"

/// Fidelity and tolerance for a wanted accuracy.
///
/// A screening run with every body rigid is cheap, and its shadows (shadows.hpp) say for every stored output
/// what each body's deformation would change, and what it would still change with 1, 2, 3, ... modes.  A body
/// that changes nothing beyond its share of the wanted accuracy stays rigid; the others get the fewest modes
/// that keep the rest within their share.  Half of the accuracy is for the dropped modes (shared equally by
/// the bodies), half for what the first-order screening does not see and for the integrator.  Then the chosen
/// mechanism runs with its own shadows; where they say that the choice was wrong, it is run again with twice
/// the modes of the body that contributes most.
///
/// The tolerance follows from the accuracy by tol = accuracy^2 / 100 within [1e-9, 1e-4]: on the scenes of
/// cases/trade forces and deflections err by about 3 sqrt(tol), because multipliers and high modes are not
/// under error control.
namespace flexura::study {

struct RowOfRun {
  mbs::State state;
  Eigen::VectorXd v_dot;
  mbs::EnergyAccount energy;
};

struct ChosenRun {
  mbs::PreparedMechanism prepared;
  std::vector<std::string> overrides;  ///< it was prepared with
  mbs::RunResult result;
  std::vector<RowOfRun> rows;  ///< what the callback `row` would have been given
  bool has_estimate = false;
  TruncationEstimate estimate;
  std::vector<std::string> reasons;  ///< one line for each body, tolerance and repeated run
  double screening_wall = 0.0;       ///< [s] of all runs but the last
};

/// Runs it.  `overrides` are the run's own and the command line's.  Throws what prepare() throws, and
/// std::invalid_argument for an accuracy outside (0, 1].
ChosenRun run_within(double accuracy, const std::filesystem::path& file,
                     const std::vector<std::string>& overrides, const mbs::RunCallbacks& callbacks);

}  // namespace flexura::study
