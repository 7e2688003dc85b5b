// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>

#include "mbs/solver/integrators/background_queue.hpp"
#include "mbs/solver/position/projection.hpp"
#include "mbs/solver/position/row_watch.hpp"
#include "mbs/solver/run/energy.hpp"
#include "mbs/solver/run/growth.hpp"

/// What a run makes of the steps that its integrator took: the energy book and the rows, on their constraints
/// to round-off.  Nothing of it enters the next steps, so it may be done beside them.
namespace flexura::mbs {

/// What is entered in turn: a step that was taken, the rows within it and what others look at, its end.
struct BookEntry {
  enum class Kind { step, row, look, end };
  Kind kind = Kind::step;
  double t_end = 0.0;            ///< of the step
  std::array<Instant, 3> nodes;  ///< of the step, at EnergyBook::node_times()
  Instant begin;                 ///< of the step, where there are constraints or somebody looks at steps
  Instant row;                   ///< or look
};

class Bookkeeper {
 public:
  using Row = std::function<void(const State&, const Eigen::VectorXd& v_dot, const EnergyAccount&)>;
  using Look = std::function<void(const State&, const Eigen::VectorXd& v_dot)>;
  using Step = std::function<void(const Instant& begin, const std::array<Instant, 3>& nodes)>;
  /// The largest of a run so far.
  struct Peaks {
    LoopCloser::Drift drift;  ///< left open in what the run gave away
    double energy_error = 0.0;
  };

  /// `row`, `look` and `step` may be empty.  With `beside` entries are made by a second thread, in their order, which calls
  /// them; the numbers are the same to the bit.  `given` are the equations of those who are called: multipliers are
  /// those of its rows, also where `eq` keeps others (change_rows()).
  Bookkeeper(const Equations& eq, const Equations& given, const SolverOptions& options, Row row, Look look,
             Step step, bool beside);

  /// The state from which the run goes: what its loops are open by is how little their parts fit.
  void begin(const State& s) { watch_.begin(s); }
  /// To be filled, then entered.
  BookEntry& next(BookEntry::Kind kind);
  /// What an earlier entry threw may come from here: IntegrationError of a row that is off its constraints.
  void enter() { entries_.push(); }
  /// Waits until all is entered; only then the following may be asked for.
  void drain() { entries_.drain(); }
  /// The same when something else went wrong.
  void drain_what_can_be() noexcept;

  EnergyBook& book() { return book_; }
  /// Of what was drained: GrowthWatch::suspicion().
  std::string suspected_growth() const { return growth_.suspicion(); }
  LoopCloser& closer() { return closer_; }
  const Peaks& peaks() const { return peaks_; }
  const RowWatch& watch() const { return watch_; }
  void note(const LoopCloser::Drift& left);
  /// After drain(): `eq` keeps other rows from s on.
  void change_rows(const State& s);
  /// Takes multipliers of a state of `eq` to the rows that `given` keeps.
  void show(State& s, const Eigen::VectorXd& v_dot);
  /// Closes the loops of s, notes what is left open, of rows left out as redundant, too, and returns it.
  const RowWatch::Opening& close(State& s);
  /// A state to give away, with accelerations and multipliers of its own.  Throws IntegrationError where it stays off its constraints.
  void close_row(Instant& row);

 private:
  void work_off(BookEntry& entry);
  void enter_step(BookEntry& entry);
  void watch_growth(double t);

  const Equations& eq_;
  EnergyBook book_;
  LoopCloser closer_, shown_;
  RowWatch watch_;
  bool has_other_rows_ = false;
  double allowed_;  // see RowWatch::Opening
  Row row_;
  Look look_;
  Step step_;
  Peaks peaks_;
  Instant between_;
  GrowthWatch growth_;
  double t_end_ = 0.0;         // of the step last entered
  Eigen::VectorXd travelled_;  // by every speed, in its typical size
  BackgroundQueue<BookEntry> entries_;
};

}  // namespace flexura::mbs
