// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/prepare.hpp"

#include <fmt/format.h>

#include <optional>

#include "mbs/solver/start/apply_state.hpp"
#include "mbs/solver/start/not_assembled.hpp"
#include "mbs/solver/statics/close_loops.hpp"
#include "mbs/solver/statics/equilibrium.hpp"

namespace flexura::mbs {
namespace {

std::optional<StateSet> chosen_set(const MechanismFile& file) {
  if (!file.solver.has("initial_state")) return std::nullopt;
  return find_state_set(file.states, file.solver.text("initial_state"), file.solver.where("initial_state"));
}

// The state set, then the state file, each at the time that it names: drives stand there as they do then.
GivenState start_state(PreparedMechanism& out, const std::optional<StateSet>& set,
                       const std::filesystem::path& state_file) {
  const Mechanism& m = *out.mechanism;
  GivenState given{m.given_positions(), m.given_velocities(), false};
  std::vector<std::string> notes;
  const auto apply = [&](double time) {
    out.state = m.initial_state(time);
    if (set) notes = apply_state(*set, out.file.deformable, m, out.state, given);
    if (time == out.options.start_time) out.given_start_time = out.state.t;
    if (state_file.empty()) return;
    const std::vector<std::string> more = apply_state(state_file, out.file.deformable, m, out.state, given);
    notes.insert(notes.end(), more.begin(), more.end());
  };
  apply(out.options.start_time);
  if (out.state.t != out.options.start_time) apply(out.state.t);
  out.options.start_time = out.state.t;
  out.notes.insert(out.notes.end(), notes.begin(), notes.end());
  return given;
}

}  // namespace

void start_in_equilibrium(StartedMechanism& out) {
  const Eigen::VectorXd v = out.state.v;
  out.state.v.setZero();
  const StaticsReport found = find_equilibrium(*out.mechanism, out.state);
  forget_ringing(out.notes);
  out.state.v = v;
  AssembleOptions keep;
  keep.keep_position.assign(v.size(), true);
  keep.keep_velocity.assign(v.size(), true);
  assemble(*out.mechanism, out.state, out.v_dot, keep);
  out.notes.push_back(
      fmt::format("starts from the static equilibrium, largest force left {:.2g} N", found.force_residual));
}

PreparedMechanism prepare(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                          const std::filesystem::path& state_file, std::shared_ptr<PreparationCache> cache) {
  return prepare(std::make_shared<FileSource>(file, overrides), {}, state_file, std::move(cache));
}

PreparedMechanism prepare(std::shared_ptr<const ModelSource> source, const ModelChoice& choice,
                          const std::filesystem::path& state_file, std::shared_ptr<PreparationCache> cache) {
  if (!cache) cache = std::make_shared<PreparationCache>();
  MechanismFile file = source->read(choice, *cache);
  PreparedMechanism out(std::move(file), std::move(cache));
  const std::string path = source->name();
  out.source = std::move(source);
  out.choice = choice;
  if (out.file.description.bodies.size() < 2 && out.file.description.controls.empty())
    throw input::InputError(fmt::format(
        "{}: has no body and no control: there is nothing that could move; give at least one [body.NAME]",
        path));
  out.options = read_solver_options(out.file.solver);
  out.notes = out.file.notes;
  out.mechanism = std::make_unique<Mechanism>(out.file.description);
  if (!out.file.solver.has("method") && !out.file.solver.has("max_order") && has_deformation(*out.mechanism))
    out.options.method = "radau";
  out.options.method_is_open = !out.file.solver.has("method") && !out.file.solver.has("max_order");
  // Its rows have no vibration, the first as the others.
  if (out.options.method == "kinematics" && has_deformation(*out.mechanism))
    out.options.quasi_static_start = true;
  const std::optional<StateSet> set = chosen_set(out.file);
  const GivenState given = start_state(out, set, state_file);
  try {
    assemble_start(out, given);
  } catch (const OpenLoops& e) {
    std::vector<Opening> openings = openings_of(*out.mechanism, e.g);
    out.state.p = e.p;
    const std::string what = fmt::format("{}: {}", path, e.what());
    throw NotAssembled(what, std::make_shared<const PreparedMechanism>(std::move(out)), std::move(openings));
  } catch (const AssemblyError& e) {
    throw input::InputError(fmt::format("{}: {}", path, e.what()));
  }
  if (out.options.method == "generalised_alpha" && out.options.rho_inf == 1.0 &&
      out.options.fixed_step == 0.0 && out.mechanism->sizes().n_lambda > 0)
    throw input::InputError(
        fmt::format("{}: solver.rho_inf = 1: leaves constraint forces undamped, and each change of the step "
                    "makes them swing; "
                    "give 0.99 or less, or a fixed_step",
                    path));
  if (set && set->equilibrium && state_file.empty()) start_in_equilibrium(out);
  if (!state_file.empty()) {
    // Now that the redundant rows are gone the multipliers have their places.
    State whole = out.state;
    StateChange change =
        read_state(state_file, *out.mechanism, whole, [](const std::string&) { return true; });
    out.continuation_fits = change.continuation_fits;
    out.continuation = std::move(change.continuation);
  }
  return out;
}

}  // namespace flexura::mbs
