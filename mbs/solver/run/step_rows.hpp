// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/run/bookkeeper.hpp"
#include "mbs/solver/run/row_times.hpp"
#include "mbs/solver/run/run.hpp"

/// The rows of a step that was taken, and what others look at in it, in their order.
namespace flexura::mbs {

class StepRows {
 public:
  /// `books` and `callbacks` must outlive it.
  StepRows(const Equations& eq, const SolverOptions& options, const RunCallbacks& callbacks,
           Bookkeeper& books);

  RowTimes& times() { return times_; }
  /// Gives a row that is already on its constraints.
  void give(const State& s, const Eigen::VectorXd& v_dot);
  /// Of a motion: enters them, and the step, into the books.  Rows until `rows_until` show what is at t_end.
  void enter_step(double t_begin, double t_end, double rows_until, Integrator& integrator);
  /// Of equilibria: gives them at once.
  void give_equilibria(double t_end, double rows_until, Integrator& integrator);

 private:
  void enter_look(double t, Integrator& integrator);

  const RunCallbacks& callbacks_;
  Bookkeeper& books_;
  RowTimes times_;
  bool wants_begin_;
  Instant row_;
};

}  // namespace flexura::mbs
