// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/estimated_error.hpp"
#include "mbs/app/mechanism_runs.hpp"
#include "mbs/app/recorder.hpp"
#include "mbs/input/units.hpp"
#include "mbs/results/results.hpp"
#include "mbs/solver/prepare.hpp"
#include "mbs/solver/run.hpp"
#include "mbs/study/choose.hpp"
#include "mbs/terminal/terminal.hpp"

namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using mbs::RunResult;
using terminal::Align;
using terminal::number;

struct Arguments : MechanismArguments {
  std::string output, end_time, save_state, continue_from, accuracy;
  bool csv = false, schema = false, no_estimate = false;
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

nlohmann::json summary_of(const PreparedMechanism& prepared, const RunResult& r) {
  const double simulated = r.state.t - prepared.options.start_time;
  return {{"method", prepared.options.method},
          {"tolerance", prepared.options.tolerance},
          {"end_time", r.state.t},
          {"wall_time", r.wall_time},
          {"real_time_factor", simulated > 0.0 ? r.wall_time / simulated : 0.0},
          {"steps", r.counts.steps},
          {"evaluations", r.counts.evaluations},
          {"jacobians", r.counts.jacobians},
          {"error_failures", r.counts.error_failures},
          {"newton_failures", r.counts.newton_failures},
          {"switches", r.events.size()},
          {"energy_error", r.energy.error()},
          {"largest_energy_error", r.largest_energy_error},
          {"relative_energy_error", r.energy.relative_error()},
          {"work_in", r.energy.work_in},
          {"dissipated", r.energy.dissipated},
          {"peak_position_drift", r.peak_position_drift},
          {"peak_velocity_drift", r.peak_velocity_drift},
          {"redundant_constraints", prepared.redundant.size()}};
}

void print_summary(
    const std::vector<std::pair<std::string, std::pair<const PreparedMechanism*, RunResult>>>& runs) {
  const bool colour = terminal::takes_colour(stdout);
  terminal::Table table({{"run", Align::left},
                         {"to t [s]"},
                         {"wall"},
                         {"x real time"},
                         {"steps"},
                         {"evaluations"},
                         {"energy error [J]"},
                         {"relative"},
                         {"drift"}});
  for (const auto& [name, run] : runs) {
    const auto& [prepared, r] = run;
    const double simulated = r.state.t - prepared->options.start_time;
    table.add_row({name, number(r.state.t, 6), terminal::duration(r.wall_time),
                   simulated > 0.0 ? number(r.wall_time / simulated, 3) : "-",
                   fmt::format("{}", r.counts.steps), fmt::format("{}", r.counts.evaluations),
                   number(r.energy.error(), 3), number(r.energy.relative_error(), 2),
                   number(r.peak_position_drift, 2)});
  }
  fmt::print("{}", table.text(terminal::width(stdout), colour));
}

// A run that ended, with what it says about itself beside the usual figures.
struct Outcome {
  RunResult result;
  nlohmann::json summary = nlohmann::json::object();
  std::vector<std::string> lines;
};

void add_estimate(const study::TruncationEstimate* truncation, Outcome& outcome) {
  outcome.summary["estimate"] = estimated_error_json(truncation, outcome.result);
  outcome.lines.push_back(estimated_error_line(truncation, outcome.result));
}

void add_range(const Recorder& recorder, Outcome& outcome) {
  const std::vector<std::string> sentences = recorder.range().sentences();
  outcome.summary["notes"] = sentences;
  for (const std::string& sentence : sentences) outcome.lines.push_back("warning: " + sentence);
}

Outcome run_as_told(const NamedRun& run, const Arguments& arguments, results::Writer& writer,
                    mbs::RunCallbacks callbacks) {
  const PreparedMechanism& prepared = run.prepared;
  Recorder recorder(prepared, writer);
  recorder.begin(run.name);
  const auto shadows =
      arguments.no_estimate ? nullptr : study::Shadows::make(prepared, arguments.file, run.overrides);
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy) {
    recorder.append(s, v_dot, energy);
    if (shadows) shadows->take(s, v_dot);
  };
  Outcome out;
  out.result =
      arguments.continue_from.empty()
          ? mbs::run(*prepared.mechanism, prepared.state, prepared.v_dot, prepared.options, callbacks)
          : mbs::run(*prepared.mechanism, *prepared.continuation, prepared.options, callbacks);
  add_range(recorder, out);
  if (arguments.no_estimate) return out;
  study::TruncationEstimate truncation;
  if (shadows) truncation = shadows->estimate();
  out.result.wall_time -= truncation.wall;
  add_estimate(shadows ? &truncation : nullptr, out);
  return out;
}

// Fidelities, modes and tolerance are chosen; the rows are stored once the choice has held.
Outcome run_within_accuracy(NamedRun& run, const Arguments& arguments, results::Writer& writer,
                            const mbs::RunCallbacks& callbacks) {
  if (!arguments.from_state.empty() || !arguments.continue_from.empty())
    throw std::invalid_argument(
        "--accuracy starts from the file's own state; take --from-state or --continue away");
  const double accuracy = input::parse_quantity(arguments.accuracy, input::dim::none);
  study::ChosenRun chosen = study::run_within(accuracy, arguments.file, run.overrides, callbacks);
  run.prepared = std::move(chosen.prepared);
  run.overrides = std::move(chosen.overrides);
  Recorder recorder(run.prepared, writer);
  recorder.begin(run.name);
  for (const study::RowOfRun& row : chosen.rows) recorder.append(row.state, row.v_dot, row.energy);
  Outcome out;
  out.result = std::move(chosen.result);
  out.summary["chosen"] = chosen.reasons;
  out.summary["screening_wall_time"] = chosen.screening_wall;
  out.lines = std::move(chosen.reasons);
  add_range(recorder, out);
  add_estimate(chosen.has_estimate ? &chosen.estimate : nullptr, out);
  return out;
}

int simulate(Arguments arguments, const terminal::Talk& talk) {
  if (arguments.schema) {
    fmt::print("{}", input::reference_page(mbs::mechanism_schema(mbs::solver_schema())));
    return 0;
  }
  if (arguments.file.empty()) throw input::InputError("no mechanism file given; see flexura simulate --help");
  if (arguments.output.empty())
    arguments.output = std::filesystem::path(arguments.file).stem().string() + ".h5";
  if (!arguments.end_time.empty()) arguments.set.push_back("solver.end_time=" + arguments.end_time);
  if (!arguments.continue_from.empty()) {
    if (!arguments.from_state.empty())
      throw std::invalid_argument("--continue and --from-state exclude each other");
    arguments.from_state = arguments.continue_from;
  }
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.save_state.empty()) only_run(runs, arguments, "--save-state");
  if (!arguments.continue_from.empty()) {
    PreparedMechanism& p = only_run(runs, arguments, "--continue").prepared;
    if (!p.continuation)
      throw std::invalid_argument(
          fmt::format("{}: holds states but no history to go on from; start from it with --from-state",
                      arguments.continue_from));
    p.options.start_time = p.given_start_time;
  }
  results::Writer writer(arguments.output, model_header(runs, arguments.file, arguments.output));
  InterruptGuard guard;
  terminal::Progress progress(stderr, talk.quiet);
  std::vector<std::pair<std::string, std::pair<const PreparedMechanism*, RunResult>>> done;
  std::vector<std::string> remarks;
  std::string stopped;
  for (NamedRun& run : runs) {
    mbs::RunCallbacks callbacks;
    callbacks.progress = [&](double, double fraction) { progress("run " + run.name, fraction); };
    callbacks.stop_wanted = [] { return interrupted != 0; };
    Outcome outcome;
    try {
      outcome = arguments.accuracy.empty() ? run_as_told(run, arguments, writer, callbacks)
                                           : run_within_accuracy(run, arguments, writer, callbacks);
    } catch (const std::exception& failure) {
      // A formula, a table or a row that is not finite: the rows before it are worth keeping.
      if (!writer.keep(failure.what())) throw;
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
      remarks.push_back(fmt::format("run {}: {}", run.name, line));
    writer.end_run(r.complete, r.stopped_because, summary.dump());
    const bool complete = r.complete;
    const std::string why = r.stopped_because;
    done.emplace_back(run.name, std::make_pair(&prepared, std::move(r)));
    if (!complete) {
      stopped = fmt::format("run \"{}\" stopped: {}", run.name, why);
      break;
    }
  }
  progress.finish();
  writer.close();
  if (arguments.csv)
    for (const auto& path : results::write_csv(results::read(arguments.output), arguments.output))
      if (!talk.quiet) fmt::print("table   {}\n", path.string());
  if (!talk.quiet) {
    print_summary(done);
    for (const std::string& line : remarks) fmt::print("{}\n", line);
    fmt::print("results {}\n", arguments.output);
  }
  if (!stopped.empty())
    throw std::runtime_error(
        fmt::format("{}; what was computed until then is in {}", stopped, arguments.output));
  return 0;
}

// ---- assemble
// ----------------------------------------------------------------------------------------------

int print_assembled(const Arguments& arguments, const terminal::Talk& talk) {
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.save_state.empty()) {
    const PreparedMechanism& p = only_run(runs, arguments, "--save-state").prepared;
    mbs::write_state(arguments.save_state, *p.mechanism, p.file.name, p.state);
  }
  for (const NamedRun& run : runs) {
    const PreparedMechanism& p = run.prepared;
    const mbs::Mechanism& m = *p.mechanism;
    const mbs::Sizes n = m.sizes();
    const bool colour = terminal::takes_colour(stdout);
    fmt::print("{}\n\n",
               terminal::bold(
                   fmt::format("{}, run {}, t = {} s", p.file.name, run.name, number(p.state.t, 6)), colour));
    terminal::Table positions({{"position", Align::left}, {"value"}});
    for (int i = 0; i < n.n_p; ++i) positions.add_row({m.name_of_position(i), number(p.state.p(i), 9)});
    terminal::Table velocities({{"velocity", Align::left}, {"value"}, {"acceleration"}});
    for (int i = 0; i < n.n_v; ++i)
      velocities.add_row({m.name_of_velocity(i), number(p.state.v(i), 9), number(p.v_dot(i), 9)});
    fmt::print("{}\n{}\n", positions.text(terminal::width(stdout), colour),
               velocities.text(terminal::width(stdout), colour));
    if (n.n_lambda > 0) {
      terminal::Table multipliers({{"constraint", Align::left}, {"multiplier"}});
      for (int i = 0; i < n.n_lambda; ++i)
        multipliers.add_row({m.name_of_constraint(i), number(p.state.lambda(i), 9)});
      fmt::print("{}\n", multipliers.text(terminal::width(stdout), colour));
    }
    fmt::print("assembled in {} steps; residuals {} (position), {} (velocity)\n", p.assembly.iterations,
               number(p.assembly.position_residual, 2), number(p.assembly.velocity_residual, 2));
    if (!talk.quiet)
      for (const std::string& note : p.notes) fmt::print("note: {}\n", note);
  }
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
            .option(
                "--accuracy", a->accuracy, "ACCURACY",
                "choose each superelement's fidelity and modes, and the tolerance, for this accuracy of all "
                "stored outputs: \"1 %\"")
            .flag("--csv", a->csv, "write a table of each run beside the results")
            .flag("--no-estimate", a->no_estimate, "do not estimate what dropped modes cost in accuracy")
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

terminal::Command assemble_command() {
  return {"assemble", "close a mechanism's loops and print where it stands",
          [](terminal::Options& options, const terminal::Talk& talk) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            declare_mechanism(options, *a);
            options.option("--save-state", a->save_state, "FILE", "write the assembled states there")
                .example("flexura assemble engine.toml", "positions, velocities, accelerations, multipliers");
            return [a, &talk] { return print_assembled(*a, talk); };
          }};
}

}  // namespace flexura::app
