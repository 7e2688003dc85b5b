// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/bookkeeper.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/solver/integrators/integrator.hpp"

namespace flexura::mbs {

Bookkeeper::Bookkeeper(const Equations& eq, const Equations& given, const SolverOptions& options, Row row,
                       Look look, Step step, bool beside)
    : eq_(eq),
      book_(eq, options.tolerance),
      closer_(eq, options),
      shown_(given, options),
      watch_(eq),
      allowed_(RowWatch::allowed(options.tolerance)),
      row_(std::move(row)),
      look_(std::move(look)),
      step_(std::move(step)),
      entries_([this](BookEntry& entry) { work_off(entry); }, beside) {}

BookEntry& Bookkeeper::next(BookEntry::Kind kind) {
  BookEntry& entry = entries_.next();
  entry.kind = kind;
  return entry;
}

void Bookkeeper::work_off(BookEntry& entry) {
  switch (entry.kind) {
    case BookEntry::Kind::step:
      enter_step(entry);
      break;
    case BookEntry::Kind::row:
      close_row(entry.row);
      if (row_) {
        const EnergyAccount account = book_.at_row(entry.row.state, entry.row.v_dot);
        show(entry.row.state, entry.row.v_dot);
        row_(entry.row.state, entry.row.v_dot, account);
      }
      break;
    case BookEntry::Kind::look:
      closer_.close(entry.row.state);
      closer_.accelerate(entry.row.state, entry.row.v_dot);
      show(entry.row.state, entry.row.v_dot);
      look_(entry.row.state, entry.row.v_dot);
      break;
    case BookEntry::Kind::end:
      book_.close_step();
      peaks_.energy_error = std::max(peaks_.energy_error, std::abs(book_.account().error()));
      watch_growth(t_end_);
      break;
  }
}

// Rows may lie too far apart: a sampled loop whose gain is too high grows by 80 and more within one period, and has wheels
// turn so fast that steps from one row to the next would never end.
void Bookkeeper::watch_growth(double t) {
  if (travelled_.size() == 0) return;
  Eigen::Index farthest = 0;
  const double travel = travelled_.cwiseAbs().maxCoeff(&farthest);
  growth_.observe(t, book_.account().now.kinetic, travel, 0.0);
  if (!growth_.reason().empty())
    throw IntegrationError(growth_.reason() + " (\"" + eq_.name_of_velocity(static_cast<int>(farthest)) +
                           "\" goes farthest)");
}

void Bookkeeper::enter_step(BookEntry& entry) {
  const auto& [first, second, last] = entry.nodes;
  if (travelled_.size() == 0) travelled_.setZero(last.state.v.size());
  // Between Gauss' points and these nodes it makes no difference here.
  const double h = (second.state.t - first.state.t) * std::sqrt(5.0);
  for (Eigen::Index i = 0; i < travelled_.size(); ++i)
    travelled_(i) +=
        0.5 * h * (first.state.v(i) + second.state.v(i)) / eq_.velocity_scale(static_cast<int>(i));
  t_end_ = entry.t_end;
  if (step_ && has_other_rows_) {
    Instant begin = entry.begin;
    std::array<Instant, 3> nodes = entry.nodes;
    show(begin.state, begin.v_dot);
    for (Instant& node : nodes) show(node.state, node.v_dot);
    step_(begin, nodes);
  } else if (step_) {
    step_(entry.begin, entry.nodes);
  }
  if (!book_.asks_multipliers(entry.nodes[2].state)) {
    book_.open_step(entry.t_end, entry.nodes);
    return;
  }
  for (Instant& node : entry.nodes) {
    closer_.close(node.state, false);
    closer_.accelerate(node.state, node.v_dot);
  }
  // Two pointers: a std::function holds no more without memory of its own.
  book_.open_step(entry.t_end, entry.nodes, [this, &entry](double x) -> const Instant& {
    EnergyBook::interpolate(entry.begin, entry.nodes, x, between_);
    closer_.close(between_.state, false);
    closer_.accelerate(between_.state, between_.v_dot);
    return between_;
  });
}

void Bookkeeper::change_rows(const State& s) {
  has_other_rows_ = true;
  closer_.forget_factors();
  watch_.change_rows(s);
}

void Bookkeeper::show(State& s, const Eigen::VectorXd& v_dot) {
  if (!has_other_rows_) return;
  // Accelerations are the same, and those of `eq` are better where the rows of `given` come near to depending on each other.
  Eigen::VectorXd same = v_dot;
  shown_.accelerate(s, same);
}

const RowWatch::Opening& Bookkeeper::close(State& s) {
  LoopCloser::Drift left = closer_.close(s, true);
  const RowWatch::Opening& open = watch_.look(s);
  left.position = std::max(left.position, open.drift);
  left.velocity = std::max(left.velocity, open.drift_rate);
  note(left);
  return open;
}

// Where the kept rows nearly depend on each other, closing them opens those left out; the integrator's polynomial keeps to all.
void Bookkeeper::close_row(Instant& row) {
  const State given = row.state;
  RowWatch::Opening open = close(row.state);
  if (open.contradicts(allowed_)) {
    row.state = given;
    open = watch_.look(given);
  }
  // RowWatch::allowed() is that of rows which Newton's method closed to the run's tolerance, as the polynomial is.
  // Beside a dead point the polynomial's error moves the mechanism along what the rows nearly allow (near_rank_loss() tells).
  constexpr double kBeside = 1e3;
  const double kept = closer_.is_beside_dead_point() ? open.kept / kBeside : open.kept;
  if (std::max(open.left_out, kept) > allowed_)
    throw IntegrationError(watch_.complaint(given.t, given.t, allowed_));
  closer_.accelerate(row.state, row.v_dot);
  closer_.judge(row.state, row.v_dot);
}

void Bookkeeper::drain_what_can_be() noexcept {
  try {
    drain();
  } catch (...) {
    // The run has its first trouble to tell already.
  }
}

void Bookkeeper::note(const LoopCloser::Drift& left) {
  peaks_.drift.position = std::max(peaks_.drift.position, left.position);
  peaks_.drift.velocity = std::max(peaks_.drift.velocity, left.velocity);
}

}  // namespace flexura::mbs
