// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/solver/linear/linearise.hpp"

/// Modes of a mechanism as a results file: what `flexura view` shows one at a time.
namespace flexura::app {

/// Name of the velocity coordinate whose part in a shape is largest; `sizes` n_v, absolute values.
std::string moves_most(const mbs::Mechanism& m, const Eigen::VectorXd& sizes);

/// One run for each of the first `count` modes: the mechanism in 24 phases of it about run.prepared's state, times being
/// parts of a period, frequency and damping in the summary.  `mechanism` is the name of its file.  The largest coordinate
/// moves by `amplitude` [rad or m]; NaN: as much as moves nothing by more than a tenth of the mechanism's size.  Throws
/// std::runtime_error where the file or a superelement's picture cannot be written or read.
void write_mode_pictures(const std::filesystem::path& output, const NamedRun& run,
                         const std::string& mechanism, const std::vector<mbs::NaturalMode>& modes, int count,
                         double amplitude);

}  // namespace flexura::app
