// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/prepare.hpp"

#include <fmt/format.h>

#include "mbs/solver/start/not_assembled.hpp"
#include "mbs/solver/statics/close_loops.hpp"

namespace flexura::mbs {
namespace {

std::vector<bool> either(std::vector<bool> a, const std::vector<bool>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] = a[i] || b[i];
  return a;
}

}  // namespace

PreparedMechanism prepare(const std::filesystem::path& path, const std::vector<std::string>& overrides,
                          const std::filesystem::path& state_file, std::shared_ptr<PreparationCache> cache) {
  if (!cache) cache = std::make_shared<PreparationCache>();
  MechanismFile file = read_mechanism(path, solver_schema(), overrides, cache.get());
  PreparedMechanism out(std::move(file), std::move(cache));
  if (out.file.description.bodies.size() < 2 && out.file.description.controls.empty())
    throw input::InputError(fmt::format(
        "{}: has no body and no control: there is nothing that could move; give at least one [body.NAME]",
        path.string()));
  out.options = read_solver_options(out.file.solver);
  out.given_start_time = out.options.start_time;
  out.notes = out.file.notes;
  out.mechanism = std::make_unique<Mechanism>(out.file.description);
  if (!out.file.solver.has("method") && !out.file.solver.has("max_order") && has_deformation(*out.mechanism))
    out.options.method = "radau";
  out.options.method_is_open = !out.file.solver.has("method") && !out.file.solver.has("max_order");
  out.state = out.mechanism->initial_state(out.options.start_time);
  GivenState given{out.mechanism->given_positions(), out.mechanism->given_velocities(), !state_file.empty()};
  if (given.whole) {
    const StateChange change = read_state(state_file, *out.mechanism, out.state);
    given.positions = either(given.positions, change.position);
    given.velocities = either(given.velocities, change.velocity);
    if (!change.continuation) out.options.start_time = out.state.t;
  }
  try {
    assemble_start(out, given);
  } catch (const OpenLoops& e) {
    std::vector<Opening> openings = openings_of(*out.mechanism, e.g);
    out.state.p = e.p;
    const std::string what = fmt::format("{}: {}", path.string(), e.what());
    throw NotAssembled(what, std::make_shared<const PreparedMechanism>(std::move(out)), std::move(openings));
  } catch (const AssemblyError& e) {
    throw input::InputError(fmt::format("{}: {}", path.string(), e.what()));
  }
  if (!state_file.empty()) {
    // Now that the redundant rows are gone the multipliers have their places.
    State whole = out.state;
    StateChange change = read_state(state_file, *out.mechanism, whole);
    out.continuation_fits = change.continuation_fits;
    out.continuation = std::move(change.continuation);
  }
  return out;
}

}  // namespace flexura::mbs
