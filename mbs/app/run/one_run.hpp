// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mbs/app/run/checkpoint.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/results/results.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/study/parts_on_demand.hpp"

/// One run of `flexura simulate`, from its prepared mechanism to its rows and what it says of itself.
namespace flexura::app {

struct SimulateArguments : MechanismArguments {
  std::string output, html, end_time, save_state, continue_from, accuracy, checkpoint, interferences;
  bool csv = false, schema = false, reduce = false, no_estimate = false, check_integrator = false,
       check_elements = false, json = false, output_is_given = false, run_scripts = false;
};

/// A run that ended, with what it says about itself beside the usual figures.
struct RunOutcome {
  mbs::RunResult result;
  nlohmann::json summary = nlohmann::json::object();
  std::vector<std::string> lines, warnings;
};

/// No error: the meshes of a run took more than their share of the accuracy, and are finer with these overrides, with which all
/// runs are to be made anew: a results file knows one superelement of a body.
struct FinerParts {
  std::vector<std::string> overrides;
};

/// The checkpoints that are written, and those that the run goes on from; both may be missing.
struct CheckpointMemory {
  std::unique_ptr<Resumption> from;
  std::unique_ptr<Checkpoints> to;
};

/// Runs with the fidelities of the file.  Throws what mbs::run() throws.
RunOutcome run_as_told(const NamedRun& run, const SimulateArguments& arguments, results::Writer& writer,
                       mbs::RunCallbacks callbacks, const CheckpointMemory& memory);

/// Chooses fidelities, modes and tolerance, which then stand in `run`; the rows are stored once the choice has held.
/// `parts` (may be null) looks at the meshes of what deforms.  Throws std::invalid_argument for a start that is not the file's own, and FinerParts
/// before any row is stored.
RunOutcome run_within_accuracy(NamedRun& run, const SimulateArguments& arguments, results::Writer& writer,
                               const mbs::RunCallbacks& callbacks, study::PartsOnDemand* parts = nullptr);

/// Of a run that had ended when the process was killed: its rows, and what it said of itself (`end`, of
/// Checkpoints::end_run()).
RunOutcome run_again_from(const nlohmann::json& end, const NamedRun& run, const Resumption& from,
                          results::Writer& writer);

/// What the summary of a command prints of a run, to be kept in `end` of run_again_from().
nlohmann::json figures_of(const mbs::RunResult& result);

}  // namespace flexura::app
