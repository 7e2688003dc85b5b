// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/step_rows.hpp"

#include <algorithm>
#include <array>

namespace flexura::mbs {

StepRows::StepRows(const Equations& eq, const SolverOptions& options, const RunCallbacks& callbacks,
                   Bookkeeper& books)
    : callbacks_(callbacks),
      books_(books),
      times_(options, callbacks.look ? callbacks.look_at : std::vector<double>()),
      wants_begin_(eq.sizes().n_lambda > 0 || callbacks.step) {}

void StepRows::give(const State& s, const Eigen::VectorXd& v_dot) {
  if (callbacks_.row) callbacks_.row(s, v_dot, books_.book().account());
}

void StepRows::enter_look(double t, Integrator& integrator) {
  Instant& look = books_.next(BookEntry::Kind::look).row;
  integrator.interpolate(t, look.state, look.v_dot);
  books_.enter();
}

void StepRows::enter_step(double t_begin, double t_end, double rows_until, Integrator& integrator) {
  BookEntry& step = books_.next(BookEntry::Kind::step);
  step.t_end = t_end;
  const std::array<double, 3> times = EnergyBook::node_times(t_begin, t_end);
  for (int i = 0; i < 3; ++i) integrator.interpolate(times[i], step.nodes[i].state, step.nodes[i].v_dot);
  if (wants_begin_) integrator.interpolate(t_begin, step.begin.state, step.begin.v_dot);
  books_.enter();
  double seen = t_begin;
  for (;;) {
    if (const double look = times_.look_until(rows_until); look < RowTimes::kNever) {
      enter_look(std::min(look, t_end), integrator);
      times_.take_look();
      seen = look;
      continue;
    }
    if (!times_.is_row_until(rows_until)) break;
    seen = times_.take_row();
    Instant& row = books_.next(BookEntry::Kind::row).row;
    integrator.interpolate(std::min(seen, t_end), row.state, row.v_dot);
    books_.enter();
    times_.pass_looks(seen);
  }
  if (seen < t_end && callbacks_.look && callbacks_.wants_look && callbacks_.wants_look(t_begin, t_end))
    enter_look(t_end, integrator);
  books_.next(BookEntry::Kind::end);
  books_.enter();
}

void StepRows::give_equilibria(double t_end, double rows_until, Integrator& integrator) {
  for (;;) {
    if (const double look = times_.look_until(rows_until); look < RowTimes::kNever) {
      integrator.interpolate(std::min(look, t_end), row_.state, row_.v_dot);
      callbacks_.look(row_.state, row_.v_dot);
      times_.take_look();
      continue;
    }
    if (!times_.is_row_until(rows_until)) break;
    const double t = times_.take_row();
    integrator.interpolate(std::min(t, t_end), row_.state, row_.v_dot);
    give(row_.state, row_.v_dot);
    times_.pass_looks(t);
  }
}

}  // namespace flexura::mbs
