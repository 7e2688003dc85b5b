// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "mbs/solver/prepare.hpp"

/// By which outputs the error of a run is judged, and how.
namespace flexura::study {

struct OutputEstimate {
  std::string name, unit;
  double max = 0.0, rms = 0.0, final = 0.0;  ///< of the error, in the output's unit
  double size_max = 0.0, size_rms = 0.0;     ///< of the corrected output
  bool counts = true;                        ///< false where the output is nothing beside others of its unit
  double relative_max() const;
  double relative_rms() const;
};

/// Relative rms, of the worst output that counts, of squared errors integrated over `span`; and which.
std::pair<double, int> worst_output(const Eigen::VectorXd& squares, double span,
                                    const std::vector<OutputEstimate>& outputs);

/// The quantities of `full` by which a run is judged, outputs that both mechanisms have, each with its name
/// and unit in `outputs`; modal coordinates of a body are no outputs of an engineer's.
std::vector<int> judged_outputs(const mbs::PreparedMechanism& run, const mbs::Mechanism& full,
                                std::vector<OutputEstimate>& outputs);

/// Of a run's rows one in so many is looked at, 400 to 800 in all.
long rows_between(const mbs::PreparedMechanism& run);

/// Sets `counts`: outputs that are nothing beside others of their unit do not; `asked`: the user named them.
void find_what_counts(std::vector<OutputEstimate>& outputs, bool asked);

}  // namespace flexura::study
