// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <utility>
#include <vector>

#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"

/// What a run says about itself.
namespace flexura::app {

/// For the results file.
nlohmann::json summary_of(const mbs::PreparedMechanism& prepared, const mbs::RunResult& result);

/// The table at the end of flexura simulate: each run by its name; with `verbose` also what the integrator
/// counted.
void print_summary(
    const std::vector<std::pair<std::string, std::pair<const mbs::PreparedMechanism*, mbs::RunResult>>>& runs,
    bool verbose);

}  // namespace flexura::app
