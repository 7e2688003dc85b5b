// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "mbs/solver/run.hpp"
#include "mbs/study/shadows.hpp"

/// What a run says about its own error, by source.
namespace flexura::app {

/// One line: the estimated error, its parts and the largest contributor.  `truncation` may be null (no mode
/// was dropped).
std::string estimated_error_line(const study::TruncationEstimate* truncation, const mbs::RunResult& result);

/// The same for the summary in the results file: {"error", "shadows", "wall_time", "integrator", "by_body",
/// "outputs": {name: {"max", "rms", "size_max", "size_rms", "final"}}}.
nlohmann::json estimated_error_json(const study::TruncationEstimate* truncation,
                                    const mbs::RunResult& result);

}  // namespace flexura::app
