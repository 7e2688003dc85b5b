// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/buckling.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/app/mode_pictures.hpp"
#include "mbs/solver/linear/buckling.hpp"
#include "mbs/solver/linear/static_stiffness.hpp"
#include "mbs/solver/statics/equilibrium.hpp"
#include "mbs/solver/statics/late_loads.hpp"

namespace flexura::app {
namespace {

using mbs::PreparedMechanism;
using terminal::Align;
using terminal::number;

nlohmann::json to_json(const NamedRun& run, const std::vector<mbs::BucklingMode>& modes, int count) {
  nlohmann::json out = run_json(run);
  nlohmann::json& list = out["modes"] = nlohmann::json::array();
  for (const mbs::BucklingMode& mode : modes) {
    if (static_cast<int>(list.size()) == count) break;
    list.push_back({{"number", list.size() + 1},
                    {"load_factor", mode.factor},
                    {"relative_error", mode.error},
                    {"moves_most", moves_most(*run.prepared.mechanism, mode.shape.cwiseAbs())}});
  }
  return out;
}

/// The stiffness of the mechanism without what loads it, from where it starts.  What follows a command (an actuator, a filter)
/// loads it by what it gives in the equilibrium, where `p` stands: at the start it may be nothing.
mbs::StaticStiffness unloaded_stiffness(const PreparedMechanism& p, const mbs::State& start) {
  mbs::State loaded = start;
  loaded.c = p.state.c;
  loaded.a = p.state.a;
  mbs::Unloaded without = p.mechanism->without_loads(loaded, *p.mechanism->make_scratch());
  if (!without.unknown.empty())
    throw std::invalid_argument(
        fmt::format("--buckling scales loads, and force \"{}\" does not say what of it is one: it acts where "
                    "the mechanism "
                    "starts, and changes with the state; let nature() and without_load() of its class say it "
                    "(mbs/forces/force.hpp)",
                    without.unknown.front()));
  if (without.loads.empty()) {
    const std::string late = mbs::late_loads(*p.mechanism, loaded, p.options.end_time);
    throw std::invalid_argument(
        fmt::format("--buckling scales weight, given forces and preloads, and the mechanism has none{}",
                    late.empty() ? "; give gravity or a force, or leave --buckling out" : ": " + late));
  }
  mbs::Mechanism unloaded(std::move(without.description));
  mbs::State s = unloaded.initial_state();
  s.t = start.t;
  s.p = start.p;
  s.v.setZero();
  unloaded.drop_redundant(s, s.p);
  s.lambda = Eigen::VectorXd::Zero(unloaded.sizes().n_lambda);
  try {
    mbs::solve_statics(unloaded, s);
  } catch (const std::runtime_error& failure) {
    throw std::runtime_error(
        fmt::format("--buckling compares the equilibrium with that of the mechanism without weight and given "
                    "forces, which has none: {}; where only some runs have springs, choose one with --run",
                    failure.what()));
  }
  return mbs::static_stiffness(unloaded, s);
}

// What the table of buckling factors does not say.
void add_buckling_notes(const mbs::Buckling& buckling, bool can_move, const std::string& late,
                        std::vector<std::string>& notes) {
  if (!late.empty()) notes.push_back(late);
  if (!can_move)
    notes.push_back(
        "nothing of the mechanism moves or deforms: at no factor of the loads does it buckle; a body that is "
        "to "
        "buckle by itself needs fidelity = \"modal-stiffened\"");
  else if (buckling.modes.empty())
    notes.push_back(
        buckling.has_complex_factors
            ? "no factor of the loads takes the stiffness away: it does not buckle by divergence"
            : "the loads, as they are at this instant, change no stiffness: at no factor of them does the "
              "equilibrium lose it");
  if (buckling.has_complex_factors)
    notes.push_back(
        "some loads follow the motion: they may make it flutter at factors that are not seen here; "
        "flexura eigen --equilibrium with the loads themselves shows it");
  // Beside a factor that is seen, one a hundred times larger is of no interest.
  const double first = buckling.modes.empty() ? 1.0 : std::abs(buckling.modes.front().factor);
  if (buckling.seen_to < 1e2 * first)
    notes.push_back(
        fmt::format("factors beyond {} are not told from none: the loads change the stiffness too little "
                    "beside its round-off; "
                    "take larger loads",
                    number(buckling.seen_to, 2)));
  for (const mbs::BucklingMode& mode : buckling.modes)
    if (mode.error > 1e-3) {
      notes.push_back(
          fmt::format("load factor {} is right to {} of itself only: stiffnesses of very different size "
                      "leave no more digits",
                      number(mode.factor, 6), number(mode.error, 2)));
      break;
    }
}

}  // namespace

int print_buckling(const MechanismArguments& arguments, int count, bool as_json,
                   const terminal::Verbosity& verbosity) {
  std::vector<NamedRun> runs = prepare_runs(arguments);
  nlohmann::json list = nlohmann::json::array();
  for (NamedRun& run : runs) {
    PreparedMechanism& p = run.prepared;
    const mbs::State start = p.state;
    move_to_equilibrium(p);
    const mbs::StaticStiffness unloaded = unloaded_stiffness(p, start);
    give_warnings(run);
    const mbs::Buckling buckling =
        mbs::buckling_modes(unloaded, mbs::static_stiffness(*p.mechanism, p.state, &unloaded.independent));
    add_buckling_notes(buckling, !unloaded.independent.empty(),
                       mbs::late_loads(*p.mechanism, p.state, p.options.end_time), p.notes);
    for (const auto& body : p.mechanism->description().bodies)
      if (body.flexible && body.flexible->acts_back() && !body.flexible->has_geometric_stiffness())
        p.notes.push_back(
            fmt::format("body \"{}\" has no geometric stiffening; with fidelity = \"modal-stiffened\" "
                        "its own buckling is seen",
                        body.name));
    note_discretisation(p);
    if (as_json) {
      list.push_back(to_json(run, buckling.modes, count));
      continue;
    }
    if (verbosity.quiet) continue;
    fmt::print("{}\n\n", heading(run));
    terminal::Table table({{"no"}, {"load factor"}, {"moves most", Align::left}});
    int index = 0;
    for (const mbs::BucklingMode& mode : buckling.modes) {
      if (++index > count) break;
      table.add_row({fmt::format("{}", index), number(mode.factor, 6),
                     moves_most(*p.mechanism, mode.shape.cwiseAbs())});
    }
    if (index > 0) fmt::print("{}\n", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
    for (const std::string& note : p.notes) terminal::say(stdout, "note: " + note);
  }
  if (as_json) print_json("buckling", runs, list);
  return 0;
}

}  // namespace flexura::app
