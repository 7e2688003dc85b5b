// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/checkpoint.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/app/run/one_run.hpp"
#include "mbs/app/run/provided_parts.hpp"
#include "mbs/app/run/results_page.hpp"
#include "mbs/app/run/run_summary.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/files/signals.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/describe.hpp"
#include "mbs/results/csv_name.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/continuation_file.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/choice/choose.hpp"

namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using mbs::RunResult;

// The value of --interferences without one.
constexpr const char* kOverlap = "0.2 mm";
// The value of --continue without one.
constexpr const char* kNewest = "newest";

double seconds_of(const std::string& text) {
  const auto given = input::try_parse_measured(text);
  if (!given || given->dimension != input::dim::time || !(given->value > 0.0) || !std::isfinite(given->value))
    throw std::invalid_argument(fmt::format(
        "--checkpoint is \"{}\", it must be a time above 0 between two checkpoints, like \"60 s\" or 10min",
        text));
  return given->value;
}

// Whether --continue names checkpoints (bare, by the output that they are of, or by themselves) and not a
// state file; then the output is theirs.
bool goes_on_from_checkpoint(SimulateArguments& arguments) {
  const std::string& from = arguments.continue_from;
  constexpr std::string_view kEnding = ".checkpoint", kBefore = ".checkpoint.before";
  std::string output;
  if (from == kNewest)
    output = arguments.output;
  else if (from.ends_with(kEnding))
    output = from.substr(0, from.size() - kEnding.size());
  else if (from.ends_with(kBefore))
    output = from.substr(0, from.size() - kBefore.size());
  else if (const CheckpointFiles of(from);
           std::filesystem::exists(of.newest) || std::filesystem::exists(of.before))
    output = from;
  else
    return false;
  if (!arguments.output_is_given)
    arguments.output = output;
  else if (std::filesystem::weakly_canonical(arguments.output) != std::filesystem::weakly_canonical(output))
    throw std::invalid_argument(
        fmt::format("{}: its checkpoints are gone on with in the same output; leave -o {} out", output,
                    arguments.output));
  return true;
}

void require_depth(const std::string& text) {
  const auto given = input::try_parse_measured(text);
  if (!given || given->dimension != input::dim::length || !(given->value > 0.0) ||
      !std::isfinite(given->value))
    throw std::invalid_argument(
        fmt::format("--interferences is \"{}\", it must be a length above 0 beyond which an overlap is told, "
                    "like \"0.2 mm\"",
                    text));
}

void require_accuracy(const std::string& text) {
  const auto given = input::try_parse_measured(text);
  if (!given || given->dimension != input::dim::none || !(given->value > 0.0) || given->value > 1.0)
    throw std::invalid_argument(fmt::format(
        "--accuracy is \"{}\", it must be a part of the outputs above 0 and at most 1, like \"1 %\" or 0.01",
        text));
}

// What the rows take at the least [bytes]: those of the runs that tell how many there are, shrunk to a tenth
// by the compression of results that hardly change.
double least_size(const std::vector<NamedRun>& runs) {
  double numbers = 0.0;
  for (const NamedRun& run : runs) {
    const mbs::SolverOptions& o = run.prepared.options;
    const double rows = (o.end_time - o.start_time) / o.output_step;
    const mbs::Sizes n = run.prepared.mechanism->sizes();
    // What a body has beside its motion is known once its fidelity is chosen.
    const auto outputs =
        study::is_to_be_chosen(run.prepared)
            ? 0
            : mbs::select_quantities(*run.prepared.mechanism, run.prepared.file.outputs).size();
    const double columns = 1.0 + static_cast<double>(outputs) +
                           (o.store_states ? n.n_p + n.n_v + n.n_dyn + n.n_alg + n.n_lambda + n.n_root : 0);
    const bool has_stop = o.stop_time != 0.0 && o.stop_time > o.start_time;
    if (std::isfinite(rows) && !has_stop) numbers += std::max(rows, 0.0) * columns;
  }
  return 0.1 * sizeof(double) * numbers;
}

// `parts`: made by the first call where the arguments want it.  Throws FinerParts.
int simulate_all(SimulateArguments& arguments, const terminal::Verbosity& verbosity,
                 terminal::Progress& progress, std::unique_ptr<study::PartsOnDemand>& parts) {
  // "simulate --continue engine.toml": the file stands where the value may.
  if (arguments.file.empty() && arguments.continue_from.ends_with(".toml")) {
    arguments.file = arguments.continue_from;
    arguments.continue_from = kNewest;
  }
  if (arguments.file.empty()) throw input::InputError("no mechanism file given; see flexura simulate --help");
  arguments.output_is_given = arguments.output_is_given || !arguments.output.empty();
  if (arguments.output.empty())
    arguments.output = std::filesystem::path(arguments.file).stem().string() + ".h5";
  const bool resumes = goes_on_from_checkpoint(arguments);
  const double interval = arguments.checkpoint.empty() ? 0.0 : seconds_of(arguments.checkpoint);
  files::Claims claims;
  claims.add(arguments.output).add(arguments.save_state).add(arguments.html);
  const CheckpointFiles checkpoint_files(arguments.output);
  if (resumes || interval > 0.0)
    for (const auto& file : {checkpoint_files.newest, checkpoint_files.before, checkpoint_files.rows})
      claims.add(file);
  if (!arguments.end_time.empty()) arguments.set.push_back("solver.end_time=" + arguments.end_time);
  if (!arguments.accuracy.empty()) require_accuracy(arguments.accuracy);
  if (!arguments.interferences.empty()) require_depth(arguments.interferences);
  if (!arguments.accuracy.empty()) arguments.set.push_back("solver.accuracy=" + arguments.accuracy);
  if (!arguments.continue_from.empty() && !resumes) {
    if (!arguments.from_state.empty())
      throw std::invalid_argument("--continue and --from-state exclude each other");
    if (arguments.check_integrator)
      throw std::invalid_argument("--check-integrator needs the whole run: it does not go with --continue");
    arguments.from_state = arguments.continue_from;
  }
  if (arguments.check_integrator && arguments.no_estimate)
    throw std::invalid_argument("--check-integrator and --no-estimate exclude each other");
  if (arguments.check_elements && (arguments.no_estimate || !arguments.from_state.empty()))
    throw std::invalid_argument(
        fmt::format("--check-elements runs twice more from the file's own start: it does not go with {}",
                    arguments.no_estimate ? "--no-estimate" : "a state to start from"));
  if (arguments.reduce && !parts) parts = provide_parts(arguments, program_folder(), progress, verbosity);
  CheckpointMemory memory;
  const nlohmann::json identity =
      resumes || interval > 0.0
          ? identity_of_runs(arguments, {{"--no-estimate", arguments.no_estimate},
                                         {"--check-integrator", arguments.check_integrator},
                                         {"--check-elements", arguments.check_elements},
                                         {"--interferences", !arguments.interferences.empty()}})
          : nlohmann::json();
  if (resumes) memory.from = std::make_unique<Resumption>(arguments.output, identity);
  std::vector<NamedRun> runs = prepare_runs(arguments);
  for (const NamedRun& run : runs)
    if (const mbs::SolverOptions& o = run.prepared.options;
        arguments.continue_from.empty() && run.prepared.state.t > o.end_time)
      throw std::invalid_argument(fmt::format(
          "{}: run \"{}\" starts from a state of t = {:.6g} s, behind solver.end_time = {:.6g} s; give a "
          "later end_time, or another time of the state",
          arguments.file, run.name, run.prepared.state.t, o.end_time));
  if (resumes || interval > 0.0) {
    if (std::ranges::any_of(runs, [](const NamedRun& run) { return study::is_to_be_chosen(run.prepared); }))
      throw std::invalid_argument(
          "a run whose fidelity is chosen keeps no checkpoints; give fidelities in place of \"auto\" and "
          "solver.accuracy, or leave --checkpoint out");
    memory.to = std::make_unique<Checkpoints>(
        arguments.output, interval > 0.0 ? interval : memory.from->interval(), identity, memory.from.get());
    if (memory.from && !memory.from->note().empty() && !verbosity.quiet)
      terminal::say(stderr, "note: " + memory.from->note());
    if (!memory.from && std::filesystem::exists(checkpoint_files.newest) && !verbosity.quiet)
      fmt::print(
          stderr,
          "note: {} is of an earlier run, which --continue goes on with; the first checkpoint of this run "
          "takes its place\n",
          checkpoint_files.newest.string());
  }
  if (!arguments.save_state.empty()) only_run(runs, arguments, "--save-state");
  if (!arguments.continue_from.empty() && !resumes) {
    mbs::require_whole_continuation(arguments.continue_from);
    PreparedMechanism& p = only_run(runs, arguments, "--continue").prepared;
    if (!p.continuation)
      throw std::invalid_argument(
          fmt::format("{}: holds states but no history to go on from; start from it with --from-state",
                      arguments.continue_from));
    if (!p.continuation_fits)
      throw std::invalid_argument(
          fmt::format("{}: was saved by another mechanism: its states, or its masses, forces and constraints "
                      "in this state, differ; "
                      "go on with the mechanism that saved it, or start from its states with --from-state",
                      arguments.continue_from));
    p.options.start_time = p.given_start_time;
  }
  if (arguments.csv)
    for (const NamedRun& run : runs) claims.add(results::csv_name(arguments.output, run.name));
  files::expect_size(arguments.output, least_size(runs));
  results::Writer writer(arguments.output, model_header(runs, arguments.file, arguments.output));
  const files::StopRequests signals;
  std::vector<std::pair<std::string, std::pair<const PreparedMechanism*, RunResult>>> done;
  std::vector<std::string> remarks;
  nlohmann::json list = nlohmann::json::array();
  std::string stopped;
  for (NamedRun& run : runs) {
    mbs::RunCallbacks callbacks;
    callbacks.progress = [&](double, double fraction) { progress("run " + run.name, fraction); };
    callbacks.stop_wanted = &files::StopRequests::wanted;
    RunOutcome outcome;
    const nlohmann::json* const ended = memory.from ? memory.from->end_of(run.name) : nullptr;
    try {
      outcome = ended ? run_again_from(*ended, run, *memory.from, writer)
                : study::is_to_be_chosen(run.prepared)
                    ? run_within_accuracy(run, arguments, writer, callbacks, parts.get())
                    : run_as_told(run, arguments, writer, callbacks, memory);
    } catch (const std::invalid_argument&) {
      throw;  // what the file asks for cannot be: there is nothing worth keeping
    } catch (const std::exception& failure) {
      // A formula, a table or a row that is not finite: the rows before it are worth keeping.
      const bool no_memory = dynamic_cast<const std::bad_alloc*>(&failure) != nullptr;
      const std::string why = no_memory ? "out of memory" : failure.what();
      bool kept = false;
      try {
        kept = writer.keep(why);
      } catch (const std::exception&) {  // the disk is full: the first sentence says so
      }
      if (!kept) throw;
      throw std::runtime_error(fmt::format("run \"{}\" stopped: {}; what was computed until then is in {}",
                                           run.name, why, arguments.output));
    }
    RunResult& r = outcome.result;
    const PreparedMechanism& prepared = run.prepared;
    if (!verbosity.quiet) {
      progress.clear();
      for (const std::string& note : prepared.notes)
        terminal::say(stderr, fmt::format("note: {}: {}", run.name, note));
    }
    if (!arguments.save_state.empty())
      mbs::write_state(arguments.save_state, *prepared.mechanism, prepared.file.name, r.state,
                       &r.continuation);
    nlohmann::json summary = ended ? nlohmann::json::object() : summary_of(prepared, r);
    summary.update(outcome.summary);
    for (const std::string& change : r.method_changes) outcome.lines.push_back("method changed " + change);
    if (!r.method_hint.empty()) outcome.lines.push_back("hint: " + r.method_hint);
    for (const std::string& line : outcome.lines)
      remarks.push_back(run.name == "run" ? line : fmt::format("run {}: {}", run.name, line));
    if (!ended && !r.near_rank_loss.empty()) outcome.warnings.push_back(r.near_rank_loss);
    std::vector<std::string> warnings = run.warnings;
    if (!ended) warnings.insert(warnings.end(), outcome.warnings.begin(), outcome.warnings.end());
    if (ended) warnings = outcome.warnings;
    summary["warnings"] = warnings;
    if (memory.to && !ended)
      memory.to->end_run({{"complete", r.complete},
                          {"as_told", r.stopped_as_told},
                          {"stopped_because", r.stopped_because},
                          {"summary", summary},
                          {"lines", outcome.lines},
                          {"warnings", outcome.warnings},
                          {"figures", figures_of(r)}});
    writer.end_run(r.complete, r.stopped_because, summary.dump());
    if (arguments.json) {
      list.push_back(run_json(run));
      list.back()["warnings"] = warnings;
      list.back()["complete"] = r.complete;
      list.back()["stopped_because"] = r.stopped_because;
      list.back()["summary"] = std::move(summary);
    }
    for (const std::string& sentence : outcome.warnings) {
      progress.clear();
      terminal::say(stderr, fmt::format("warning: {}: {}", run.name, sentence));
    }
    const bool complete = r.complete, as_told = r.stopped_as_told;
    const std::string why = r.stopped_because;
    done.emplace_back(run.name, std::make_pair(&prepared, std::move(r)));
    if (as_told) {
      if (!verbosity.quiet) {
        progress.clear();
        terminal::say(stderr, fmt::format("note: run \"{}\": {}", run.name, why));
      }
    } else if (!complete) {
      stopped = fmt::format("run \"{}\" stopped: {}", run.name, why);
      break;
    }
  }
  progress.finish();
  writer.close();
  if (memory.to && stopped.empty()) memory.to->remove();
  if (memory.to && !stopped.empty() && memory.to->any() && !verbosity.quiet)
    fmt::print(stderr, "note: flexura simulate ... --continue goes on from {}\n",
               checkpoint_files.newest.string());
  if (arguments.csv)
    for (const auto& path : results::write_csv(results::read(arguments.output), arguments.output))
      if (!verbosity.quiet && !arguments.json) fmt::print("table   {}\n", path.string());
  if (arguments.json) {
    print_json("results", runs, list);
  } else if (!verbosity.quiet) {
    print_summary(done, verbosity.verbose);
    for (const std::string& line : remarks) terminal::say(stdout, line);
    fmt::print("results {}\n", arguments.output);
  }
  if (!arguments.html.empty()) {
    const std::string page =
        write_results_page(arguments.html, results::read(arguments.output), arguments.output);
    if (!verbosity.quiet && !arguments.json) fmt::print("page    {}\n", page);
  }
  if (!stopped.empty())
    throw std::runtime_error(
        fmt::format("{}; what was computed until then is in {}{}", stopped, arguments.output,
                    arguments.save_state.empty() ? "" : ", its last states are in " + arguments.save_state));
  return 0;
}

int simulate(SimulateArguments arguments, const terminal::Verbosity& verbosity) {
  if (arguments.schema) {
    fmt::print("{}", input::reference_page(mbs::mechanism_schema(mbs::solver_schema())));
    return 0;
  }
  terminal::Progress progress(stderr, verbosity.quiet, verbosity.verbose);
  std::unique_ptr<study::PartsOnDemand> parts;
  for (;;) try {
      return simulate_all(arguments, verbosity, progress, parts);
    } catch (const FinerParts& finer) {
      arguments.set.insert(arguments.set.end(), finer.overrides.begin(), finer.overrides.end());
    }
}

}  // namespace

terminal::Command simulate_command() {
  return {
      "simulate", "simulate a mechanism",
      [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
        auto a = std::make_shared<SimulateArguments>();
        declare_mechanism(options, *a, false);
        options
            .option("-o,--output", a->output, "FILE",
                    "results file (default: the mechanism file's name with .h5)")
            .option("--html", a->html, "PAGE", "also write the page of the results (flexura view)")
            .option("--save-state", a->save_state, "FILE",
                    "write the states at the end and the integrator's history there")
            .option("--checkpoint", a->checkpoint, "TIME",
                    "write what a killed run needs to go on beside the output, every so often: \"60 s\"")
            .optional_value(
                "--continue", a->continue_from, kNewest, "FILE",
                "go on from the last checkpoint beside the output, giving the results of a run that "
                "was never cut; or from a file of --save-state, with rows from there on")
            .option("--end-time", a->end_time, "TIME", "short for --set solver.end_time=TIME")
            .option("--accuracy", a->accuracy, "ACCURACY",
                    "short for --set solver.accuracy=ACCURACY: choose fidelity and modes of the "
                    "superelements, and the tolerance, for this accuracy of all stored outputs, as \"1 %\"")
            .flag("--reduce", a->reduce,
                  "reduce the parts that the runs want to deform and that are rigid or not there yet, and "
                  "with an "
                  "accuracy those whose mesh is too coarse for it, anew")
            .flag("--run-scripts", a->run_scripts, "with --reduce: as of flexura reduce")
            .optional_value(
                "--interferences", a->interferences, kOverlap, "DEPTH",
                "look for bodies whose surfaces overlap by more than this in the stored rows, beside "
                "what their facets may be off (default: 0.2 mm)")
            .flag("--csv", a->csv, "write a table of each run beside the results")
            .flag("--json", a->json, "print how each run ended as JSON (SI units)")
            .flag("--no-estimate", a->no_estimate, "do not estimate what dropped modes cost in accuracy")
            .flag("--check-integrator", a->check_integrator,
                  "run once more at ten times the tolerance to tell the integrator's error")
            .flag("--check-elements", a->check_elements,
                  "run twice more with other numbers of elements to tell what those of beams cost in "
                  "accuracy (with an "
                  "accuracy this is done anyway)")
            .flag("--schema", a->schema, "print the mechanism file's reference page, then stop")
            .example("flexura simulate engine.toml -o engine.h5", "all runs of the file")
            .example("flexura simulate engine/mechanism.toml --reduce --set body.rod.fidelity=auto",
                     "a body of an imported assembly, made flexible without another hand")
            .example(
                "flexura simulate engine.toml --run rigid --set solver.stop_time=1 --save-state half.json",
                "the first half, to go on with --continue half.json")
            .example("flexura simulate engine.toml --checkpoint 60s",
                     "go on with: flexura simulate engine.toml --continue")
            .example("flexura simulate engine.toml --run rigid --set solver.tolerance=1e-8 --csv",
                     "one run, more accurate, with a table");
        return [a, &verbosity] { return simulate(*a, verbosity); };
      }};
}

}  // namespace flexura::app
