// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/app/checkpoint.hpp"
#include "mbs/app/commands.hpp"
#include "mbs/app/estimated_error.hpp"
#include "mbs/app/left_out.hpp"
#include "mbs/app/mechanism_runs.hpp"
#include "mbs/app/recorder.hpp"
#include "mbs/app/run_summary.hpp"
#include "mbs/files/output.hpp"
#include "mbs/files/signals.hpp"
#include "mbs/results/csv_name.hpp"
#include "mbs/solver/continuation_file.hpp"
#include "mbs/solver/prepare.hpp"
#include "mbs/solver/run.hpp"
#include "mbs/study/choose.hpp"
#include "mbs/terminal/terminal.hpp"

namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using mbs::RunResult;

// The value of --continue without one.
constexpr const char* kNewest = "newest";

struct Arguments : MechanismArguments {
  std::string output, end_time, save_state, continue_from, accuracy, checkpoint;
  bool csv = false, schema = false, no_estimate = false, check_integrator = false, json = false,
       output_is_given = false;
};

// A run that ended, with what it says about itself beside the usual figures.
struct Outcome {
  RunResult result;
  nlohmann::json summary = nlohmann::json::object();
  std::vector<std::string> lines, warnings;
};

// The checkpoints that are written, and those that the run goes on from; both may be missing.
struct Memory {
  std::unique_ptr<Resumption> from;
  std::unique_ptr<Checkpoints> to;
};

// Made where the user wants it and the run comes from its beginning to its end.
std::unique_ptr<study::IntegratorCheck> wanted_check(const PreparedMechanism& prepared,
                                                     const Arguments& arguments) {
  return arguments.check_integrator ? study::IntegratorCheck::make(prepared) : nullptr;
}

void add_estimate(const PreparedMechanism& prepared, const study::TruncationEstimate* truncation,
                  study::IntegratorCheck* check, const mbs::RunCallbacks& callbacks, Outcome& outcome) {
  const LeftOut unneeded = left_out(prepared);
  outcome.summary["left_out"] = left_out_json(unneeded);
  if (std::string line = left_out_line(unneeded); !line.empty()) outcome.lines.push_back(std::move(line));
  std::optional<study::IntegratorEstimate> integrator;
  if (check && outcome.result.complete) integrator = check->estimate(callbacks);
  const study::IntegratorEstimate* const by_check = integrator ? &*integrator : nullptr;
  const ErrorEstimate estimate = estimate_error(prepared, truncation, by_check, outcome.result);
  outcome.summary["estimate"] = estimated_error_json(estimate, truncation, by_check, outcome.result);
  outcome.lines.push_back(estimated_error_line(estimate));
}

RunResult run_with_memory(const PreparedMechanism& prepared, bool goes_on, const Memory& memory,
                          const mbs::RunCallbacks& callbacks) {
  mbs::Remembering remembering;
  remembering.wanted = [&] { return memory.to->due(); };
  remembering.take = [&](const mbs::RunMemory& m) { memory.to->take(m); };
  if (goes_on)
    return mbs::run(*prepared.mechanism, memory.from->memory(*prepared.mechanism), prepared.options,
                    callbacks, remembering);
  return mbs::run(*prepared.mechanism, prepared.state, prepared.v_dot, prepared.options, callbacks,
                  remembering);
}

Outcome run_as_told(const NamedRun& run, const Arguments& arguments, results::Writer& writer,
                    mbs::RunCallbacks callbacks, const Memory& memory) {
  const PreparedMechanism& prepared = run.prepared;
  Recorder recorder(prepared, writer);
  recorder.begin(run.name);
  const auto shadows =
      arguments.no_estimate ? nullptr : study::Shadows::make(prepared, arguments.file, run.overrides);
  const auto check = wanted_check(prepared, arguments);
  const StoredRow observe = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy) {
    recorder.append(s, v_dot, energy);
    if (shadows) shadows->take(s, v_dot);
    if (check) check->take(s, v_dot);
  };
  const bool goes_on = memory.from && memory.from->run() == run.name;
  if (goes_on) memory.from->replay(run.name, *prepared.mechanism, observe);
  if (memory.to && !goes_on) memory.to->begin_run(run.name);
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& account) {
    const EnergyRow energy{account.work_in, account.dissipated, account.error()};
    observe(s, v_dot, energy);
    if (memory.to) memory.to->add(s, v_dot, energy);
    recorder.watch(s, account.now.kinetic);
  };
  // What the shadows cost is taken off the run's time, so they must not run beside it.
  callbacks.rows_beside = !shadows;
  Outcome out;
  out.result =
      memory.to ? run_with_memory(prepared, goes_on, memory, callbacks)
      : arguments.continue_from.empty()
          ? mbs::run(*prepared.mechanism, prepared.state, prepared.v_dot, prepared.options, callbacks)
          : mbs::run(*prepared.mechanism, *prepared.continuation, prepared.options, callbacks);
  out.warnings = recorder.range().sentences();
  if (arguments.no_estimate) return out;
  study::TruncationEstimate truncation;
  if (shadows) truncation = shadows->estimate();
  out.result.wall_time -= truncation.wall;
  add_estimate(prepared, shadows ? &truncation : nullptr, check.get(), callbacks, out);
  return out;
}

// What the summary of a command prints of a run, for one that had ended when the process was killed.
nlohmann::json figures_of(const RunResult& r) {
  const mbs::EnergyReport& e = r.energy.now;
  return {{"t", r.state.t},
          {"wall", r.wall_time},
          {"counts",
           {r.counts.steps, r.counts.evaluations, r.counts.jacobians, r.counts.error_failures,
            r.counts.newton_failures}},
          {"switches", r.events.size()},
          {"energy",
           {e.kinetic, e.strain, e.potential, r.energy.start, r.energy.work_in, r.energy.dissipated,
            r.energy.gross_work, r.energy.peak}},
          {"drift", {r.peak_position_drift, r.peak_velocity_drift}}};
}
RunResult result_from(const nlohmann::json& end) {
  RunResult r;
  r.complete = end.at("complete");
  r.stopped_as_told = end.at("as_told");
  r.stopped_because = end.at("stopped_because");
  const nlohmann::json& f = end.at("figures");
  r.state.t = f.at("t");
  r.wall_time = f.at("wall");
  const auto& c = f.at("counts");
  r.counts = {.steps = c.at(0),
              .evaluations = c.at(1),
              .jacobians = c.at(2),
              .error_failures = c.at(3),
              .newton_failures = c.at(4)};
  r.events.resize(f.at("switches").get<std::size_t>());
  const auto& e = f.at("energy");
  r.energy.now.kinetic = e.at(0);
  r.energy.now.strain = e.at(1);
  r.energy.now.potential = e.at(2);
  r.energy.start = e.at(3);
  r.energy.work_in = e.at(4);
  r.energy.dissipated = e.at(5);
  r.energy.gross_work = e.at(6);
  r.energy.peak = e.at(7);
  r.peak_position_drift = f.at("drift").at(0);
  r.peak_velocity_drift = f.at("drift").at(1);
  return r;
}

// A run that had ended: its rows and what it said of itself.
Outcome run_again_from(const nlohmann::json& end, const NamedRun& run, const Resumption& from,
                       results::Writer& writer) {
  Recorder recorder(run.prepared, writer);
  recorder.begin(run.name);
  from.replay(run.name, *run.prepared.mechanism,
              [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy) {
                recorder.append(s, v_dot, energy);
              });
  Outcome out;
  out.result = result_from(end);
  out.summary = end.at("summary");
  out.lines = end.at("lines");
  out.warnings = end.at("warnings");
  return out;
}

// Fidelities, modes and tolerance are chosen; the rows are stored once the choice has held.
Outcome run_within_accuracy(NamedRun& run, const Arguments& arguments, results::Writer& writer,
                            const mbs::RunCallbacks& callbacks) {
  if (!arguments.from_state.empty() || !arguments.continue_from.empty())
    throw std::invalid_argument(
        "a run whose fidelity is chosen starts from the file's own state; take --from-state or --continue "
        "away, or give fidelities in place of \"auto\" and solver.accuracy");
  study::ChosenRun chosen = study::run_within(run.prepared, arguments.file, run.overrides, callbacks);
  run.prepared = std::move(chosen.prepared);
  run.overrides = std::move(chosen.overrides);
  Recorder recorder(run.prepared, writer);
  recorder.begin(run.name);
  const auto check = wanted_check(run.prepared, arguments);
  for (const study::RowOfRun& row : chosen.rows) {
    recorder.append(row.state, row.v_dot, row.energy);
    if (check) check->take(row.state, row.v_dot);
  }
  Outcome out;
  out.warnings = recorder.range().sentences();
  out.result = std::move(chosen.result);
  out.summary["chosen"] = chosen.reasons;
  out.summary["restarts"] = chosen.restarts;
  out.summary["screening_wall_time"] = chosen.screening_wall;
  out.lines = std::move(chosen.reasons);
  if (!arguments.no_estimate)
    add_estimate(run.prepared, chosen.has_estimate ? &chosen.estimate : nullptr, check.get(), callbacks, out);
  return out;
}

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
bool goes_on_from_checkpoint(Arguments& arguments) {
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
    const double columns = 1.0 +
                           mbs::select_quantities(*run.prepared.mechanism, run.prepared.file.outputs).size() +
                           (o.store_states ? n.n_p + n.n_v + n.n_dyn + n.n_alg + n.n_lambda + n.n_root : 0);
    if (std::isfinite(rows) && o.stop_time <= o.start_time) numbers += std::max(rows, 0.0) * columns;
  }
  return 0.1 * sizeof(double) * numbers;
}

int simulate(Arguments arguments, const terminal::Talk& talk) {
  if (arguments.schema) {
    fmt::print("{}", input::reference_page(mbs::mechanism_schema(mbs::solver_schema())));
    return 0;
  }
  // "simulate --continue engine.toml": the file stands where the value may.
  if (arguments.file.empty() && arguments.continue_from.ends_with(".toml")) {
    arguments.file = arguments.continue_from;
    arguments.continue_from = kNewest;
  }
  if (arguments.file.empty()) throw input::InputError("no mechanism file given; see flexura simulate --help");
  arguments.output_is_given = !arguments.output.empty();
  if (arguments.output.empty())
    arguments.output = std::filesystem::path(arguments.file).stem().string() + ".h5";
  const bool resumes = goes_on_from_checkpoint(arguments);
  const double interval = arguments.checkpoint.empty() ? 0.0 : seconds_of(arguments.checkpoint);
  files::Claims claims;
  claims.add(arguments.output).add(arguments.save_state);
  const CheckpointFiles checkpoint_files(arguments.output);
  if (resumes || interval > 0.0)
    for (const auto& file : {checkpoint_files.newest, checkpoint_files.before, checkpoint_files.rows})
      claims.add(file);
  if (!arguments.end_time.empty()) arguments.set.push_back("solver.end_time=" + arguments.end_time);
  if (!arguments.accuracy.empty()) require_accuracy(arguments.accuracy);
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
  Memory memory;
  const nlohmann::json identity =
      resumes || interval > 0.0
          ? identity_of_runs(arguments, {{"--no-estimate", arguments.no_estimate},
                                         {"--check-integrator", arguments.check_integrator}})
          : nlohmann::json();
  if (resumes) memory.from = std::make_unique<Resumption>(arguments.output, identity);
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (resumes || interval > 0.0) {
    if (std::ranges::any_of(runs, [](const NamedRun& run) { return study::is_to_be_chosen(run.prepared); }))
      throw std::invalid_argument(
          "a run whose fidelity is chosen keeps no checkpoints; give fidelities in place of \"auto\" and "
          "solver.accuracy, or leave --checkpoint out");
    memory.to = std::make_unique<Checkpoints>(
        arguments.output, interval > 0.0 ? interval : memory.from->interval(), identity, memory.from.get());
    if (memory.from && !memory.from->note().empty() && !talk.quiet)
      fmt::print(stderr, "note: {}\n", memory.from->note());
    if (!memory.from && std::filesystem::exists(checkpoint_files.newest) && !talk.quiet)
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
      throw std::invalid_argument(fmt::format(
          "{}: was saved by another mechanism: its states, or its masses, forces and constraints in this state, differ; "
          "go on with the mechanism that saved it, or start from its states with --from-state",
          arguments.continue_from));
    p.options.start_time = p.given_start_time;
  }
  if (arguments.csv)
    for (const NamedRun& run : runs) claims.add(results::csv_name(arguments.output, run.name));
  files::expect_size(arguments.output, least_size(runs));
  results::Writer writer(arguments.output, model_header(runs, arguments.file, arguments.output));
  const files::StopRequests signals;
  terminal::Progress progress(stderr, talk.quiet, talk.verbose);
  std::vector<std::pair<std::string, std::pair<const PreparedMechanism*, RunResult>>> done;
  std::vector<std::string> remarks;
  nlohmann::json list = nlohmann::json::array();
  std::string stopped;
  for (NamedRun& run : runs) {
    mbs::RunCallbacks callbacks;
    callbacks.progress = [&](double, double fraction) { progress("run " + run.name, fraction); };
    callbacks.stop_wanted = &files::StopRequests::wanted;
    Outcome outcome;
    const nlohmann::json* const ended = memory.from ? memory.from->end_of(run.name) : nullptr;
    try {
      outcome = ended ? run_again_from(*ended, run, *memory.from, writer)
                : study::is_to_be_chosen(run.prepared)
                    ? run_within_accuracy(run, arguments, writer, callbacks)
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
    if (!talk.quiet) {
      progress.clear();
      for (const std::string& note : prepared.notes) fmt::print(stderr, "note: {}: {}\n", run.name, note);
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
      fmt::print(stderr, "warning: {}: {}\n", run.name, sentence);
    }
    const bool complete = r.complete, as_told = r.stopped_as_told;
    const std::string why = r.stopped_because;
    done.emplace_back(run.name, std::make_pair(&prepared, std::move(r)));
    if (as_told) {
      if (!talk.quiet) {
        progress.clear();
        fmt::print(stderr, "note: run \"{}\": {}\n", run.name, why);
      }
    } else if (!complete) {
      stopped = fmt::format("run \"{}\" stopped: {}", run.name, why);
      break;
    }
  }
  progress.finish();
  writer.close();
  if (memory.to && stopped.empty()) memory.to->remove();
  if (memory.to && !stopped.empty() && memory.to->any() && !talk.quiet)
    fmt::print(stderr, "note: flexura simulate ... --continue goes on from {}\n",
               checkpoint_files.newest.string());
  if (arguments.csv)
    for (const auto& path : results::write_csv(results::read(arguments.output), arguments.output))
      if (!talk.quiet && !arguments.json) fmt::print("table   {}\n", path.string());
  if (arguments.json) {
    print_json("results", runs, list);
  } else if (!talk.quiet) {
    print_summary(done, talk.verbose);
    for (const std::string& line : remarks) fmt::print("{}\n", line);
    fmt::print("results {}\n", arguments.output);
  }
  if (!stopped.empty())
    throw std::runtime_error(
        fmt::format("{}; what was computed until then is in {}{}", stopped, arguments.output,
                    arguments.save_state.empty() ? "" : ", its last states are in " + arguments.save_state));
  return 0;
}

}  // namespace

terminal::Command simulate_command() {
  return {
      "simulate", "simulate a mechanism",
      [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
        auto a = std::make_shared<Arguments>();
        declare_mechanism(options, *a, false);
        options
            .option("-o,--output", a->output, "FILE",
                    "results file (default: the mechanism file's name with .h5)")
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
            .flag("--csv", a->csv, "write a table of each run beside the results")
            .flag("--json", a->json, "print how each run ended as JSON (SI units)")
            .flag("--no-estimate", a->no_estimate, "do not estimate what dropped modes cost in accuracy")
            .flag("--check-integrator", a->check_integrator,
                  "run once more at ten times the tolerance to tell the integrator's error")
            .flag("--schema", a->schema, "print the mechanism file's reference page, then stop")
            .example("flexura simulate engine.toml -o engine.h5", "all runs of the file")
            .example(
                "flexura simulate engine.toml --run rigid --set solver.stop_time=1 --save-state half.json",
                "the first half, to go on with --continue half.json")
            .example("flexura simulate engine.toml --checkpoint 60s",
                     "go on with: flexura simulate engine.toml --continue")
            .example("flexura simulate engine.toml --run rigid --set solver.tolerance=1e-8 --csv",
                     "one run, more accurate, with a table");
        return [a, &talk] { return simulate(*a, talk); };
      }};
}

}  // namespace flexura::app
