// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/library/run.hpp"

#include <utility>

#include "mbs/mechanism/describe.hpp"
#include "mbs/study/estimate/global_error.hpp"

namespace flexura::study {
namespace {

// With the models that it has.
ChosenRun run_as_it_is(const mbs::PreparedMechanism& given, const mbs::RunCallbacks& callbacks) {
  ChosenRun out{mbs::prepare(given.source, given.choice, {}, given.cache),
                {},
                {},
                {},
                false,
                {},
                {},
                {},
                {},
                0,
                0.0,
                0.0};
  const auto shadows = Shadows::make(out.prepared);
  const auto steps = GlobalError::make(out.prepared);
  mbs::RunCallbacks mine = callbacks;
  mine.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount& energy) {
    out.rows.push_back({s, v_dot, energy});
    if (shadows) shadows->take(s, v_dot);
    if (callbacks.row) callbacks.row(s, v_dot, energy);
  };
  if (shadows)
    shadows->ask_for_looks(mine, [&](const mbs::State& s, const Eigen::VectorXd& a) { shadows->look(s, a); });
  if (steps) steps->watch(mine);
  out.result =
      mbs::run(*out.prepared.mechanism, out.prepared.state, out.prepared.v_dot, out.prepared.options, mine);
  out.has_estimate = shadows != nullptr;
  if (shadows) out.estimate = shadows->estimate();
  if (steps && out.result.complete) out.integrator = steps->estimate();
  return out;
}

}  // namespace

std::vector<double> Answer::times() const {
  std::vector<double> out;
  for (const RowOfRun& row : rows) out.push_back(row.state.t);
  return out;
}

Eigen::VectorXd Answer::values(const std::string& quantity) const {
  const auto which = mbs::select_quantities(*prepared.mechanism, {quantity});
  const auto scratch = prepared.mechanism->make_scratch();
  Eigen::VectorXd out(static_cast<Eigen::Index>(rows.size())), y(static_cast<Eigen::Index>(which.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    prepared.mechanism->evaluate(which, rows[i].state, rows[i].v_dot, *scratch, y);
    out(static_cast<Eigen::Index>(i)) = y(0);
  }
  return out;
}

Answer run(const mbs::PreparedMechanism& prepared, const mbs::RunCallbacks& callbacks) {
  ChosenRun chosen =
      is_to_be_chosen(prepared) ? run_within(prepared, callbacks) : run_as_it_is(prepared, callbacks);
  const Judges judges{chosen.has_estimate ? &chosen.estimate : nullptr,
                      chosen.integrator ? &*chosen.integrator : nullptr,
                      chosen.elements ? &*chosen.elements : nullptr};
  ErrorEstimate ledger = estimate_error(chosen.prepared, judges, chosen.result);
  const double accuracy = chosen.prepared.file.solver.quantity("accuracy");
  Answer out{.choice = chosen.prepared.choice,
             .reasons = std::move(chosen.reasons),
             .ledger = std::move(ledger),
             .missed = {},
             .notes = chosen.prepared.notes,
             .result = std::move(chosen.result),
             .rows = std::move(chosen.rows),
             .prepared = std::move(chosen.prepared)};
  if (accuracy > 0.0) out.missed = missed_accuracy(out.ledger, accuracy);
  return out;
}

Answer run(const mbs::MechanismBuilder& mechanism, const mbs::RunSettings& settings,
           const mbs::RunCallbacks& callbacks) {
  return run(mbs::prepare(std::make_shared<const mbs::PartSource>(mechanism, settings)), callbacks);
}

}  // namespace flexura::study
