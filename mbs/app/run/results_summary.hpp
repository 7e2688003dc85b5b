// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "mbs/results/results.hpp"

/// What a results file says in a few lines: how each run ended and between what its quantities stay.
namespace flexura::app {

/// Runs side by side, a row for each entry of their summaries and for the range of each quantity; warnings
/// below.
std::string summary_text(const results::Results& results, int width, bool colour);

/// {"kind", "name", "runs"}, of each run {"run", "time_s" (of its last row, null without rows), "rows",
/// "complete", "stopped_because", "summary" (as stored), "quantities": [{"name", "unit", "smallest",
/// "largest"}]}; SI units.
nlohmann::json summary_json(const std::string& kind, const results::Results& results);

}  // namespace flexura::app
