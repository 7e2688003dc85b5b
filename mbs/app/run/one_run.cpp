// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/one_run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <optional>
#include <string_view>

#include "mbs/app/run/left_out.hpp"
#include "mbs/app/run/provided_parts.hpp"
#include "mbs/app/run/recorder.hpp"
#include "mbs/app/run/watch/interference_watch.hpp"
#include "mbs/study/choice/choose.hpp"
#include "mbs/study/estimate/global_error.hpp"
#include "mbs/study/ledger/estimated_error.hpp"

namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using mbs::RunResult;

// Made where the user wants it and the run comes from its beginning to its end.
std::unique_ptr<study::IntegratorCheck> wanted_check(const PreparedMechanism& prepared,
                                                     const SimulateArguments& arguments) {
  return arguments.check_integrator ? study::IntegratorCheck::make(prepared) : nullptr;
}

// Where it is asked for; it sees every row that the recorder gets.
std::unique_ptr<InterferenceWatch> wanted_watch(const PreparedMechanism& prepared,
                                                const SimulateArguments& arguments, Recorder& recorder) {
  if (arguments.interferences.empty()) return nullptr;
  auto watch = std::make_unique<InterferenceWatch>(
      prepared, input::parse_quantity(arguments.interferences, input::dim::length));
  recorder.look_at_rows(
      [w = watch.get()](double t, const auto& poses, const auto& modal) { w->take(t, poses, modal); });
  return watch;
}

void add_interferences(const InterferenceWatch* watch, RunOutcome& out) {
  if (!watch) return;
  out.summary["interferences"] = watch->json();
  const std::vector<std::string> sentences = watch->sentences();
  out.warnings.insert(out.warnings.end(), sentences.begin(), sentences.end());
  out.summary["interferences_wall_time"] = watch->wall();
  if (sentences.empty())
    out.lines.push_back(
        fmt::format("no bodies overlap in the stored rows; from one to the next they move past each other by "
                    "up to {} mm: "
                    "what is thinner is seen with a smaller output_step",
                    terminal::number(1e3 * watch->blind_way(), 3)));
}

// Made where the user wants it, or an accuracy, and the run comes from the file's own start.
std::unique_ptr<study::ElementsCheck> wanted_elements_check(const NamedRun& run,
                                                            const SimulateArguments& arguments) {
  const bool is_wanted = arguments.check_elements ||
                         (run.prepared.file.solver.quantity("accuracy") > 0.0 && !arguments.no_estimate);
  if (!is_wanted || !arguments.from_state.empty() || !arguments.continue_from.empty()) return nullptr;
  return study::ElementsCheck::make(run.prepared);
}

// The runs that tell, each null where it is not wanted.
struct Checks {
  std::unique_ptr<study::IntegratorCheck> integrator;
  std::unique_ptr<study::ElementsCheck> elements;
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot) const {
    if (integrator) integrator->take(s, v_dot);
    if (elements) elements->take(s, v_dot);
  }
};

void add_estimate(const PreparedMechanism& prepared, const study::TruncationEstimate* truncation,
                  const Checks& checks, std::optional<study::IntegratorEstimate> integrator,
                  const mbs::RunCallbacks& callbacks, RunOutcome& outcome,
                  std::optional<study::ElementsEstimate> elements = {}) {
  const LeftOut unneeded = left_out(prepared);
  outcome.summary["left_out"] = left_out_json(unneeded);
  if (std::string line = left_out_line(unneeded); !line.empty()) outcome.lines.push_back(std::move(line));
  if (checks.integrator && outcome.result.complete) integrator = checks.integrator->estimate(callbacks);
  if (!elements && checks.elements && outcome.result.complete)
    elements = checks.elements->estimate(callbacks, outcome.result.wall_time,
                                         integrator && integrator->is_whole ? integrator->error : 0.0);
  const study::Judges judges{truncation, integrator ? &*integrator : nullptr,
                             elements ? &*elements : nullptr};
  const study::ErrorEstimate estimate = study::estimate_error(prepared, judges, outcome.result);
  outcome.summary["estimate"] = estimated_error_json(estimate, judges, outcome.result);
  outcome.lines.push_back(estimated_error_text(estimate));
  if (const double accuracy = prepared.file.solver.quantity("accuracy"); accuracy > 0.0)
    if (std::string sentence = study::missed_accuracy(estimate, accuracy); !sentence.empty())
      outcome.warnings.push_back(std::move(sentence));
}

// As a shell takes it for one word.
std::string shell_word(const std::string& word) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./:=,+%@-";
  if (word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

RunResult run_with_memory(const PreparedMechanism& prepared, bool goes_on, const CheckpointMemory& memory,
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
  r.energy.round_off = e.at(8);
  r.peak_position_drift = f.at("drift").at(0);
  r.peak_velocity_drift = f.at("drift").at(1);
  return r;
}

}  // namespace

RunOutcome run_as_told(const NamedRun& run, const SimulateArguments& arguments, results::Writer& writer,
                       mbs::RunCallbacks callbacks, const CheckpointMemory& memory) {
  const PreparedMechanism& prepared = run.prepared;
  Recorder recorder(prepared, writer);
  recorder.begin(run.name);
  const auto watch = wanted_watch(prepared, arguments, recorder);
  const auto shadows = arguments.no_estimate ? nullptr : study::Shadows::make(prepared);
  const Checks checks{wanted_check(prepared, arguments), wanted_elements_check(run, arguments)};
  const StoredRow observe = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy) {
    recorder.append(s, v_dot, energy);
    if (shadows) shadows->take(s, v_dot);
    checks.take(s, v_dot);
  };
  const bool goes_on = memory.from && memory.from->run() == run.name;
  // Of the steps before a checkpoint nothing is known, nor where a second run tells.
  const auto steps = arguments.no_estimate || checks.integrator || memory.from || memory.to ||
                             !arguments.continue_from.empty()
                         ? nullptr
                         : study::GlobalError::make(prepared);
  if (goes_on) memory.from->replay(run.name, *prepared.mechanism, observe);
  if (memory.to && !goes_on) memory.to->begin_run(run.name);
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& account) {
    const EnergyRow energy{account.work_in, account.dissipated, account.error()};
    observe(s, v_dot, energy);
    if (memory.to) memory.to->add(s, v_dot, energy);
    recorder.watch(s, account.now.kinetic);
  };
  if (steps) steps->watch(callbacks);
  // A checkpoint keeps rows: a run that goes on from one is to say what the unbroken one says.
  if (shadows && (memory.from || memory.to))
    shadows->take_rows_alone(prepared);
  else if (shadows)
    shadows->ask_for_looks(
        callbacks, [&](const mbs::State& s, const Eigen::VectorXd& v_dot) { shadows->look(s, v_dot); });
  // What the shadows cost is taken off the run's time, so they must not run beside it.
  callbacks.rows_beside = !shadows && !watch;
  RunOutcome out;
  out.result =
      memory.to ? run_with_memory(prepared, goes_on, memory, callbacks)
      : arguments.continue_from.empty()
          ? mbs::run(*prepared.mechanism, prepared.state, prepared.v_dot, prepared.options, callbacks)
          : mbs::run(*prepared.mechanism, *prepared.continuation, prepared.options, callbacks);
  out.warnings = recorder.range().sentences();
  out.lines = recorder.notes();
  add_interferences(watch.get(), out);
  if (watch) out.result.wall_time -= watch->wall();
  if (arguments.no_estimate) return out;
  study::TruncationEstimate truncation;
  if (shadows) truncation = shadows->estimate();
  out.result.wall_time -= truncation.wall;
  std::optional<study::IntegratorEstimate> integrator;
  if (steps && out.result.complete) {
    integrator = steps->estimate();
    if (!callbacks.rows_beside) out.result.wall_time -= integrator->wall;
  }
  add_estimate(prepared, shadows ? &truncation : nullptr, checks, std::move(integrator), callbacks, out);
  return out;
}

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
            r.energy.gross_work, r.energy.peak, r.energy.round_off}},
          {"drift", {r.peak_position_drift, r.peak_velocity_drift}}};
}

RunOutcome run_again_from(const nlohmann::json& end, const NamedRun& run, const Resumption& from,
                          results::Writer& writer) {
  Recorder recorder(run.prepared, writer);
  recorder.begin(run.name);
  from.replay(run.name, *run.prepared.mechanism,
              [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const EnergyRow& energy) {
                recorder.append(s, v_dot, energy);
              });
  RunOutcome out;
  out.result = result_from(end);
  out.summary = end.at("summary");
  out.lines = end.at("lines");
  out.warnings = end.at("warnings");
  return out;
}

RunOutcome run_within_accuracy(NamedRun& run, const SimulateArguments& arguments, results::Writer& writer,
                               const mbs::RunCallbacks& callbacks, study::PartsOnDemand* parts) {
  if (!arguments.from_state.empty() || !arguments.continue_from.empty())
    throw std::invalid_argument(
        "a run whose fidelity is chosen starts from the file's own state; take --from-state or --continue "
        "away, or give fidelities in place of \"auto\" and solver.accuracy");
  study::ChosenRun chosen =
      study::run_within(run.prepared, callbacks, !arguments.no_estimate && !arguments.check_integrator);
  if (parts && chosen.result.complete)
    if (std::vector<std::string> finer = finer_parts(*parts, chosen.prepared); !finer.empty())
      throw FinerParts{std::move(finer)};
  run.prepared = std::move(chosen.prepared);
  Recorder recorder(run.prepared, writer);
  recorder.begin(run.name);
  const Checks checks{wanted_check(run.prepared, arguments), wanted_elements_check(run, arguments)};
  const auto watch = wanted_watch(run.prepared, arguments, recorder);
  for (const study::RowOfRun& row : chosen.rows) {
    recorder.append(row.state, row.v_dot, row.energy);
    checks.take(row.state, row.v_dot);
  }
  RunOutcome out;
  out.warnings = recorder.range().sentences();
  out.result = std::move(chosen.result);
  out.summary["chosen"] = chosen.reasons;
  out.summary["chosen_set"] = chosen.set;
  out.summary["restarts"] = chosen.restarts;
  out.summary["screening_wall_time"] = chosen.screening_wall;
  out.summary["screening_cpu_time"] = chosen.screening_cpu;
  out.lines = std::move(chosen.reasons);
  for (std::string& note : recorder.notes()) out.lines.push_back(std::move(note));
  add_interferences(watch.get(), out);
  out.lines.push_back("without the choice:");
  for (const std::string& word : chosen.set) out.lines.back() += " --set " + shell_word(word);
  if (!arguments.no_estimate)
    add_estimate(run.prepared, chosen.has_estimate ? &chosen.estimate : nullptr, checks,
                 std::move(chosen.integrator), callbacks, out, std::move(chosen.elements));
  return out;
}

}  // namespace flexura::app
