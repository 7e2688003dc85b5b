// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/app/commands.hpp"
#include "mbs/app/estimated_error.hpp"
#include "mbs/app/left_out.hpp"
#include "mbs/app/mechanism_runs.hpp"
#include "mbs/app/recorder.hpp"
#include "mbs/app/run_summary.hpp"
#include "mbs/solver/prepare.hpp"
#include "mbs/solver/run.hpp"
#include "mbs/study/choose.hpp"
#include "mbs/terminal/terminal.hpp"

namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using mbs::RunResult;

struct Arguments : MechanismArguments {
  std::string output, end_time, save_state, continue_from, accuracy;
  bool csv = false, schema = false, no_estimate = false, check_integrator = false, json = false;
};

volatile std::sig_atomic_t interrupted = 0;

// Ctrl-C asks for a clean stop; a second one ends the program at once.
class InterruptGuard {
 public:
  InterruptGuard() {
    interrupted = 0;
    before_ = std::signal(SIGINT, [](int) {
      interrupted = 1;
      std::signal(SIGINT, SIG_DFL);
    });
  }
  ~InterruptGuard() { std::signal(SIGINT, before_); }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void (*before_)(int);
};

// A run that ended, with what it says about itself beside the usual figures.
struct Outcome {
  RunResult result;
  nlohmann::json summary = nlohmann::json::object();
  std::vector<std::string> lines, warnings;
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
  const std::vector<MeshShare> meshes = mesh_shares(prepared);
  std::optional<study::IntegratorEstimate> integrator;
  if (check && outcome.result.complete) integrator = check->estimate(callbacks);
  const study::IntegratorEstimate* const by_check = integrator ? &*integrator : nullptr;
  outcome.summary["estimate"] = estimated_error_json(meshes, truncation, by_check, outcome.result);
  outcome.lines.push_back(estimated_error_line(meshes, truncation, by_check, outcome.result));
}

Outcome run_as_told(const NamedRun& run, const Arguments& arguments, results::Writer& writer,
                    mbs::RunCallbacks callbacks) {
  const PreparedMechanism& prepared = run.prepared;
  Recorder recorder(prepared, writer);
  recorder.begin(run.name);
  const auto shadows =
      arguments.no_estimate ? nullptr : study::Shadows::make(prepared, arguments.file, run.overrides);
  const auto check = wanted_check(prepared, arguments);
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy) {
    recorder.append(s, v_dot, energy);
    if (shadows) shadows->take(s, v_dot);
    if (check) check->take(s, v_dot);
  };
  // What the shadows cost is taken off the run's time, so they must not run beside it.
  callbacks.rows_beside = !shadows;
  Outcome out;
  out.result =
      arguments.continue_from.empty()
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

void require_accuracy(const std::string& text) {
  const auto given = input::try_parse_measured(text);
  if (!given || given->dimension != input::dim::none || !(given->value > 0.0) || given->value > 1.0)
    throw std::invalid_argument(fmt::format(
        "--accuracy is \"{}\", it must be a part of the outputs above 0 and at most 1, like \"1 %\" or 0.01",
        text));
}

int simulate(Arguments arguments, const terminal::Talk& talk) {
  if (arguments.schema) {
    fmt::print("{}", input::reference_page(mbs::mechanism_schema(mbs::solver_schema())));
    return 0;
  }
  if (arguments.file.empty()) throw input::InputError("no mechanism file given; see flexura simulate --help");
  if (arguments.output.empty())
    arguments.output = std::filesystem::path(arguments.file).stem().string() + ".h5";
  terminal::require_folder_of(arguments.save_state);
  if (!arguments.end_time.empty()) arguments.set.push_back("solver.end_time=" + arguments.end_time);
  if (!arguments.accuracy.empty()) require_accuracy(arguments.accuracy);
  if (!arguments.accuracy.empty()) arguments.set.push_back("solver.accuracy=" + arguments.accuracy);
  if (!arguments.continue_from.empty()) {
    if (!arguments.from_state.empty())
      throw std::invalid_argument("--continue and --from-state exclude each other");
    if (arguments.check_integrator)
      throw std::invalid_argument("--check-integrator needs the whole run: it does not go with --continue");
    arguments.from_state = arguments.continue_from;
  }
  if (arguments.check_integrator && arguments.no_estimate)
    throw std::invalid_argument("--check-integrator and --no-estimate exclude each other");
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.save_state.empty()) only_run(runs, arguments, "--save-state");
  if (!arguments.continue_from.empty()) {
    PreparedMechanism& p = only_run(runs, arguments, "--continue").prepared;
    if (!p.continuation)
      throw std::invalid_argument(
          fmt::format("{}: holds states but no history to go on from; start from it with --from-state",
                      arguments.continue_from));
    if (!p.continuation_fits)
      throw std::invalid_argument(fmt::format(
          "{}: was saved by another mechanism: the numbers of its states and constraints differ; go on with "
          "the mechanism that saved it, or start from its states with --from-state",
          arguments.continue_from));
    p.options.start_time = p.given_start_time;
  }
  results::Writer writer(arguments.output, model_header(runs, arguments.file, arguments.output));
  InterruptGuard guard;
  terminal::Progress progress(stderr, talk.quiet, talk.verbose);
  std::vector<std::pair<std::string, std::pair<const PreparedMechanism*, RunResult>>> done;
  std::vector<std::string> remarks;
  nlohmann::json list = nlohmann::json::array();
  std::string stopped;
  for (NamedRun& run : runs) {
    mbs::RunCallbacks callbacks;
    callbacks.progress = [&](double, double fraction) { progress("run " + run.name, fraction); };
    callbacks.stop_wanted = [] { return interrupted != 0; };
    Outcome outcome;
    try {
      outcome = study::is_to_be_chosen(run.prepared) ? run_within_accuracy(run, arguments, writer, callbacks)
                                                     : run_as_told(run, arguments, writer, callbacks);
    } catch (const std::invalid_argument&) {
      throw;  // what the file asks for cannot be: there is nothing worth keeping
    } catch (const std::exception& failure) {
      // A formula, a table or a row that is not finite: the rows before it are worth keeping.
      bool kept = false;
      try {
        kept = writer.keep(failure.what());
      } catch (const std::exception&) {  // the disk is full: the first sentence says so
      }
      if (!kept) throw;
      throw std::runtime_error(fmt::format("run \"{}\" stopped: {}; what was computed until then is in {}",
                                           run.name, failure.what(), arguments.output));
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
    nlohmann::json summary = summary_of(prepared, r);
    summary.update(outcome.summary);
    for (const std::string& line : outcome.lines)
      remarks.push_back(run.name == "run" ? line : fmt::format("run {}: {}", run.name, line));
    summary["warnings"] = outcome.warnings;
    writer.end_run(r.complete, r.stopped_because, summary.dump());
    if (arguments.json) {
      list.push_back(run_json(run));
      list.back()["warnings"] = outcome.warnings;
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
        fmt::format("{}; what was computed until then is in {}", stopped, arguments.output));
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
            .option("--continue", a->continue_from, "FILE",
                    "go on from such a file as if the run had not been cut; rows before are not repeated")
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
            .example("flexura simulate engine.toml --run rigid --set solver.tolerance=1e-8 --csv",
                     "one run, more accurate, with a table");
        return [a, &talk] { return simulate(*a, talk); };
      }};
}

}  // namespace flexura::app
