// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/mechanism_runs.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/app/run/open_page.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/mechanism/range/linear_range.hpp"
#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "mbs/study/ledger/estimated_error.hpp"

namespace flexura::app {

void declare_mechanism(terminal::Options& options, MechanismArguments& arguments, bool needs_file) {
  if (needs_file) {
    options.argument("FILE", arguments.file, "mechanism file (.toml)");
  } else {
    options.optional_argument("FILE", arguments.file, "mechanism file (.toml)");
  }
  declare_choices(options, arguments);
}

void declare_choices(terminal::Options& options, MechanismArguments& arguments) {
  options
      .option("--set", arguments.set, "KEY=VALUE",
              "override a key of the file, as in body.rod.fidelity=rigid")
      .option("--state", arguments.state, "NAME", "start from this [state.NAME] of the file, or from zero")
      .option("--from-state", arguments.from_state, "FILE",
              "start from the states in this file (see --save-state), or from those that it names")
      .option("--run", arguments.runs, "NAME", "only these of the file's runs")
      .option(
          "--cache", arguments.cache, "FOLDER",
          "keep the modes of flexible bodies there and take them from there, each by the content of what it "
          "follows from");
}

std::vector<NamedRun> prepare_runs(const MechanismArguments& arguments) {
  std::error_code failure;  // a link that leads back to itself
  const std::filesystem::file_status cached = std::filesystem::status(arguments.cache, failure);
  if (!std::filesystem::is_directory(cached) && cached.type() != std::filesystem::file_type::not_found)
    throw std::invalid_argument(fmt::format("--cache {}: is no folder{}; name one", arguments.cache,
                                            failure ? " (" + failure.message() + ")" : ""));
  const auto cache = std::make_shared<mbs::PreparationCache>(arguments.cache);
  const mbs::MechanismFile file =
      mbs::read_mechanism(arguments.file, mbs::solver_schema(), arguments.set, cache.get());
  std::vector<std::string> known;
  for (const mbs::RunDescription& run : file.runs) known.push_back(run.name);
  for (const std::string& wanted : arguments.runs)
    if (std::ranges::find(known, wanted) == known.end())
      throw std::invalid_argument(fmt::format("{}: there is no run \"{}\"{}", arguments.file, wanted,
                                              input::suggestion(wanted, known)));
  std::vector<NamedRun> runs;
  for (const mbs::RunDescription& run : file.runs) {
    if (!arguments.runs.empty() && std::ranges::find(arguments.runs, run.name) == arguments.runs.end())
      continue;
    // What stands on the command line has the last word.
    std::vector<std::string> overrides = run.overrides;
    overrides.insert(overrides.end(), arguments.set.begin(), arguments.set.end());
    if (!arguments.state.empty()) overrides.push_back("solver.initial_state=" + arguments.state);
    try {
      runs.push_back({run.name, mbs::prepare(arguments.file, overrides, arguments.from_state, cache)});
    } catch (const mbs::NotAssembled& open) {
      const std::string page = std::filesystem::path(arguments.file).stem().string() + ".open.html";
      try {
        write_open_page(page, open, arguments.file);
      } catch (const std::exception&) {  // a folder that cannot be written to: the sentence is what counts
        throw input::InputError(open.what());
      }
      throw input::InputError(
          fmt::format("{}; {} shows it as it stands, open joints in red", open.what(), page));
    }
    give_warnings(runs.back());
  }
  return runs;
}

NamedRun& only_run(std::vector<NamedRun>& runs, const MechanismArguments& arguments,
                   const std::string& option) {
  if (runs.size() != 1)
    throw std::invalid_argument(fmt::format("{} needs one run, and {} has {}; choose one with --run", option,
                                            arguments.file, runs.size()));
  return runs.front();
}

void give_warnings(NamedRun& run) {
  std::vector<std::string>& notes = run.prepared.notes;
  const auto is_warning = [](const std::string& note) { return note.starts_with(mbs::warning_mark); };
  for (const std::string& note : notes)
    if (is_warning(note)) {
      run.warnings.push_back(note.substr(mbs::warning_mark.size()));
      terminal::say(stderr, fmt::format("warning: {}: {}", run.name, run.warnings.back()));
    }
  std::erase_if(notes, is_warning);
}

void note_discretisation(mbs::PreparedMechanism& p) {
  for (const auto& [body, is_open] : p.file.leaves_fidelity_open)
    if (is_open)
      p.notes.push_back(fmt::format(
          "body \"{}\": fidelity = \"auto\" is chosen by flexura simulate alone, and taken as \"modal\" here",
          body));
  if (std::string line = study::discretisation_line(p); !line.empty()) p.notes.push_back(std::move(line));
}

// The search ends where its steps do: where rows nearly contradict each other that is no equilibrium.  True where it warns.
bool warn_of_force_left(mbs::PreparedMechanism& p, double left) {
  constexpr double kNoise = 1e-6;  // of what joints carry, and [N] of round-off in stiff parts
  const mbs::Mechanism& m = *p.mechanism;
  if (m.sizes().n_lambda == 0) return false;
  const auto scratch = m.make_scratch();
  Eigen::VectorXd carried(m.sizes().n_v);
  m.apply_GT(p.state, p.state.p, p.state.lambda, *scratch, carried);
  const double most = carried.lpNorm<Eigen::Infinity>();
  if (left <= kNoise || left <= kNoise * most) return false;
  p.notes.push_back(
      mbs::warning_mark +
      fmt::format(
          "no equilibrium: a force of {} N is left beside {} N that closed loops carry; rows may nearly "
          "contradict each other, as of two bodies without the modes that let them meet: "
          "give attachments = \"used\"",
          terminal::number(left, 2), terminal::number(most, 2)));
  return true;
}

// Drives of speeds by time: any position would do, and none lasts.  True where it warns.
bool warn_of_speeds(mbs::PreparedMechanism& p) {
  constexpr double kNoise = 1e-9;  // [m/s, rad/s]
  const mbs::Mechanism& m = *p.mechanism;
  const mbs::Sizes n = m.sizes();
  const auto scratch = m.make_scratch();
  Eigen::VectorXd asked(n.n_lambda);
  m.velocity_constraints(p.state, p.state.p, Eigen::VectorXd::Zero(n.n_v), *scratch, asked);
  bool leads = false;
  for (int k = 0; k < n.n_lambda; ++k) {
    if (m.is_holonomic(k) || !(std::abs(asked(k)) > kNoise)) continue;
    leads = true;
    p.notes.push_back(mbs::warning_mark + fmt::format("no equilibrium: \"{}\" leads at {} m/s (or rad/s) "
                                                      "and is held at rest here; make it 0 there, or "
                                                      "drive the position",
                                                      m.name_of_constraint(k),
                                                      terminal::number(std::abs(asked(k)), 3)));
  }
  return leads;
}

mbs::Stability move_to_equilibrium(mbs::PreparedMechanism& p) {
  const mbs::StaticsReport report = mbs::find_equilibrium(*p.mechanism, p.state);
  mbs::forget_ringing(p.notes);
  const bool has_force_left = warn_of_force_left(p, report.force_residual), leads = warn_of_speeds(p),
             is_none = has_force_left || leads;
  mbs::AccelerationSolver(*p.mechanism).solve(p.state, p.v_dot);
  if (!is_none)
    p.notes.push_back(fmt::format("equilibrium in {} {}, largest force left {} N", report.iterations,
                                  report.iterations == 1 ? "step" : "steps",
                                  terminal::number(report.force_residual, 2)));
  if (!report.stable && !is_none)
    p.notes.push_back(
        "the equilibrium is where the loads led as they grew; a stable one was not found near by");
  if (!report.following_the_way.empty() && !is_none)
    p.notes.push_back(fmt::format(
        "one of a range of equilibria: \"{}\" holds it, as friction does, and it depends on the start",
        fmt::join(report.following_the_way, "\", \"")));
  mbs::LinearRange range(*p.mechanism);
  range.observe(p.state);
  if (const std::string why = range.runaway(); !why.empty()) throw std::runtime_error(why);
  for (const std::string& sentence : range.sentences()) p.notes.push_back(mbs::warning_mark + sentence);
  // What is no equilibrium is no stable one, either.
  if (is_none) return {};
  mbs::Stability stability = mbs::stability_at_rest(*p.mechanism, p.state);
  if (std::string said = mbs::sentence(*p.mechanism, stability, "the equilibrium"); !said.empty())
    p.notes.push_back(std::move(said));
  return stability;
}

const char* const kFrozenHelp =
    "linearise at the instant even where the state does not last: about a point of a trajectory";

namespace {

mbs::SteadyLinearisation linearised(const mbs::PreparedMechanism& p, const mbs::LineariseOptions& options) {
  const double span = p.options.end_time - p.state.t;
  return mbs::linearise_steady(*p.mechanism, p.state, span > 0.0 ? span : 1.0, options);
}

// Norm of the accelerations in the masses [m/s^2 or rad/s^2 of all that moves].
double unbalanced_acceleration(const mbs::PreparedMechanism& p) {
  const auto n_v = p.mechanism->sizes().n_v;
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n_v, n_v);
  p.mechanism->mass_matrix(p.state.p, *p.mechanism->make_scratch(), M);
  return n_v == 0 ? 0.0 : std::sqrt(p.v_dot.dot(M * p.v_dot) / M.diagonal().maxCoeff());
}

// A state that counts as an equilibrium stands beside it, if only by a micrometre.  What its loads leave unbalanced there would
// be a stiffness, of a wrong sign where a heavy mass sits on a light part.  False where the state stays.
bool settle(mbs::PreparedMechanism& p) {
  constexpr double kRoundOff = 1e-12, kBeside = 1e-4;  // [m/s^2, rad/s^2], typical sizes
  if (unbalanced_acceleration(p) <= kRoundOff) return false;
  mbs::State settled = p.state;
  try {
    mbs::StaticsOptions nearest;
    nearest.stable = false;
    nearest.max_iterations = 20;
    mbs::solve_statics(*p.mechanism, settled, nearest);
  } catch (const std::runtime_error&) {  // what is free to move has none
    return false;
  }
  for (int i = 0; i < p.mechanism->sizes().n_p; ++i)
    if (!(std::abs(settled.p(i) - p.state.p(i)) <= kBeside * p.mechanism->position_scale(i))) return false;
  p.state = std::move(settled);
  mbs::AccelerationSolver(*p.mechanism).solve(p.state, p.v_dot);
  return true;
}

}  // namespace

bool lasts(const mbs::PreparedMechanism& p) {
  return linearised(p, {}).verdict != mbs::SteadyLinearisation::Verdict::unsteady;
}

mbs::SteadyLinearisation linearise_about(mbs::PreparedMechanism& p, const mbs::LineariseOptions& options,
                                         bool frozen) {
  using Verdict = mbs::SteadyLinearisation::Verdict;
  mbs::SteadyLinearisation out = linearised(p, options);
  if (out.verdict == Verdict::equilibrium && !frozen && settle(p)) out = linearised(p, options);
  if (out.verdict == Verdict::unsteady && !frozen)
    throw std::invalid_argument(fmt::format(
        "the state at t = {} s is neither an equilibrium nor a steady motion: {}; a linear system has no "
        "lasting "
        "meaning there. Take --equilibrium, --from-state or initial_deformation = \"quasi_static\", or "
        "--frozen for this instant",
        terminal::number(p.state.t, 6), out.why));
  if (out.verdict == Verdict::unsteady)
    p.notes.push_back(
        fmt::format("frozen at t = {} s: {}; what follows holds for times that are short against this change",
                    terminal::number(p.state.t, 6), out.why));
  if (!out.axes.empty())
    p.notes.push_back("in " + out.axes +
                      ": there the coefficients are constant, in the coordinates' own axes they are not");
  p.notes.insert(p.notes.end(), out.notes.begin(), out.notes.end());
  return out;
}

std::string about_what(const mbs::PreparedMechanism& p, mbs::SteadyLinearisation::Verdict verdict) {
  using Verdict = mbs::SteadyLinearisation::Verdict;
  // Above what round-off leaves of stiff parts.
  constexpr double kAtRest = 1e-6;
  if (const double a = unbalanced_acceleration(p); verdict == Verdict::equilibrium && a > kAtRest)
    return fmt::format("the given state, which accelerates by {} m/s^2 or rad/s^2", terminal::number(a, 3));
  return verdict == Verdict::equilibrium     ? "equilibrium"
         : verdict == Verdict::steady_motion ? "steady motion"
                                             : "frozen";
}

std::string heading(const NamedRun& run) {
  const mbs::MechanismFile& file = run.prepared.file;
  // The only run of a file that names none is called "run".
  const std::string which = run.name == "run" ? "" : fmt::format(", run {}", run.name);
  return terminal::bold(
      fmt::format("{}{}, t = {} s", file.name, which, terminal::number(run.prepared.state.t, 6)),
      terminal::takes_colour(stdout));
}

nlohmann::json run_json(const NamedRun& run) {
  return {{"run", run.name},
          {"time_s", run.prepared.state.t},
          {"notes", run.prepared.notes},
          {"warnings", run.warnings}};
}

void print_json(const std::string& kind, const std::vector<NamedRun>& runs, const nlohmann::json& list) {
  fmt::print(
      "{}\n",
      nlohmann::json{{"kind", kind}, {"name", runs.front().prepared.file.name}, {"runs", list}}.dump(1));
}

}  // namespace flexura::app
