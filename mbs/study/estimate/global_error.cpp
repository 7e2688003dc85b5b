// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/global_error.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/study/estimate/percent.hpp"

namespace flexura::study {
namespace {

using Eigen::VectorXd;

// Rows that are compared, and those of them that tell how large forces and motions are: every output of a row costs as
// much as the row itself.
constexpr double kMostRows = 200.0;
constexpr long kForFamilies = 8;
// Velocities that differ by more than this part across an event have jumped there.
constexpr double kJump = 1e-6;
// Up to here a linear equation tells an error: of a slider-crank by generalised alpha of 1e-3 it told 9.5 % of 110 %.
constexpr double kTrusted = 0.05;

// `largest` of them so far: where all is at rest again, what is left of the steps is no jump.
bool jumps(const VectorXd& before, const VectorXd& after, double& largest) {
  if (before.size() != after.size() || before.size() == 0) return false;
  largest = std::max({largest, after.lpNorm<Eigen::Infinity>(), before.lpNorm<Eigen::Infinity>()});
  return (after - before).lpNorm<Eigen::Infinity>() > kJump * largest;
}

class Clock {
 public:
  explicit Clock(double& sum) : sum_(sum) {}
  ~Clock() { sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }

 private:
  double& sum_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

}  // namespace

std::unique_ptr<GlobalError> GlobalError::make(const mbs::PreparedMechanism& run) {
  const mbs::Sizes n = run.mechanism->sizes();
  if (!mbs::kind_of(run.options).integrates || n.n_v + n.n_dyn == 0) return nullptr;
  std::unique_ptr<GlobalError> out(new GlobalError(run));
  return out->which_.empty() ? nullptr : std::move(out);
}

GlobalError::GlobalError(const mbs::PreparedMechanism& run)
    : run_(run),
      rows_(*run.mechanism, run.options),
      equation_(rows_.equations(), run.state, run.options),
      closer_(rows_.equations(), run.options),
      scratch_(run.mechanism->make_scratch()),
      which_(judged_outputs(run, *run.mechanism, outputs_)),
      families_(*run.mechanism, length_of(run)) {
  const mbs::SolverOptions& o = run.options;
  every_ = std::max(1L, std::lround((o.end_time - o.start_time) / o.output_step / kMostRows));
  squares_.setZero(static_cast<Eigen::Index>(which_.size()));
  sizes_ = y_ = y_moved_ = squares_;
}

void GlobalError::watch(mbs::RunCallbacks& callbacks) {
  callbacks.restart = [this](const mbs::State& s, const VectorXd& v_dot, const mbs::IntegratorKind& kind) {
    restart(s, v_dot, kind);
  };
  callbacks.step = [this](const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes) {
    step(begin, nodes);
  };
  callbacks.row = [this, then = callbacks.row](const mbs::State& s, const VectorXd& v_dot,
                                               const mbs::EnergyAccount& energy) {
    row(s, v_dot);
    if (then) then(s, v_dot, energy);
  };
}

void GlobalError::restart(const mbs::State& s, const VectorXd& v_dot, const mbs::IntegratorKind& kind) {
  const Clock clock(wall_);
  advance(true);
  longest_span_ = kind.steps_of_error;
  equation_.restart(s, v_dot, longest_span_);
  // Steps may leave the constraints, where a restart has velocities that keep to them.
  if (has_stepped_ && jumps(last_.v, s.v, largest_v_)) closer_.close(last_);
  closes_steps_ = kind.method == mbs::Method::generalised_alpha && run_.mechanism->sizes().n_lambda > 0;
  is_new_ = true;
  has_jumped_ =
      has_jumped_ || (has_stepped_ && (jumps(last_.v, s.v, largest_v_) || jumps(last_.c, s.c, largest_c_)));
  has_stepped_ = true;
}

void GlobalError::step(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes) {
  const Clock clock(wall_);
  // A run that goes on from where another one ended: what that one has lost is not known.
  if (!has_stepped_) {
    misses_part_ = true;
    longest_span_ = mbs::kind_of(run_.options).steps_of_error;
    equation_.restart(begin.state, begin.v_dot, longest_span_);
    has_stepped_ = true;
  }
  choose_rows(begin, nodes);
  begin_ = begin;
  nodes_ = nodes;
  rows_.take(begin_.state, begin_.v_dot);
  for (mbs::Instant& node : nodes_) rows_.take(node.state, node.v_dot);
  if (closes_steps_) close_step();
  equation_.step(begin_, nodes_);
  last_ = nodes[2].state;
  if (last_.v.size() > 0) largest_v_ = std::max(largest_v_, last_.v.lpNorm<Eigen::Infinity>());
  if (last_.c.size() > 0) largest_c_ = std::max(largest_c_, last_.c.lpNorm<Eigen::Infinity>());
  advance(false);
}

// Steps that wait have the multipliers of the rows before.
void GlobalError::choose_rows(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes) {
  if (!rows_.hold_little(nodes)) return;
  advance(true);
  if (!rows_.choose()) return;
  closer_.forget_factors();
  // Rates that integrators give at the begin of a step are less accurate than those of a start.
  end_ = begin;
  close(end_);
  equation_.restart(end_.state, end_.v_dot, longest_span_);
  is_new_ = true;
}

void GlobalError::close(mbs::Instant& at) {
  closer_.close(at.state);
  closer_.accelerate(at.state, at.v_dot);
}

// The run moved onto its constraints, as its rows are, with the accelerations that belong to it.
void GlobalError::close_step() {
  if (is_new_) {
    end_ = begin_;
    close(end_);
    is_new_ = false;
  }
  begin_ = end_;
  close(nodes_[2]);
  end_ = nodes_[2];
}

void GlobalError::advance(bool end) {
  do compare_waiting();
  while (equation_.advance(end));
}

void GlobalError::row(const mbs::State& s, const VectorXd& v_dot) {
  if (shown_++ % every_ != 0) return;
  const Clock clock(wall_);
  waiting_.push_back({s, v_dot});
  compare_waiting();
}

void GlobalError::compare_waiting() {
  std::size_t done = 0;
  while (done < waiting_.size() && (!has_stepped_ || waiting_[done].state.t <= equation_.known_until())) {
    compare(waiting_[done].state, waiting_[done].v_dot);
    ++done;
  }
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(done));
}

void GlobalError::compare(const mbs::State& s, const VectorXd& v_dot) {
  equation_.at(s, e_);
  const mbs::Sizes n = run_.mechanism->sizes();
  moved_ = s;
  moved_.p -= e_.head(n.n_p);
  moved_.v -= e_.segment(n.n_p, n.n_v);
  moved_.c -= e_.tail(n.n_dyn);
  v_dot_moved_ = v_dot;
  try {
    closer_.close(moved_);
    closer_.accelerate(moved_, v_dot_moved_);
    rows_.show(moved_, v_dot_moved_);
    run_.mechanism->evaluate(which_, moved_, v_dot_moved_, *scratch_, y_moved_);
  } catch (const std::runtime_error&) {
    misses_rows_ = true;  // beyond where the equations hold: the run itself is not
    return;
  }
  run_.mechanism->evaluate(which_, s, v_dot, *scratch_, y_);
  if (!y_moved_.allFinite() || !y_.allFinite()) {
    misses_rows_ = true;
    return;
  }
  squares_ += (y_ - y_moved_).cwiseAbs2();
  sizes_ += y_.cwiseAbs2();
  if (compared_++ % kForFamilies == 0) families_.take(s, v_dot);
}

double GlobalError::spent(const std::vector<OutputEstimate>& outputs) {
  if (scales_.empty())
    for (const OutputEstimate& mine : outputs_) {
      const auto known = std::ranges::find(outputs, mine.name, &OutputEstimate::name);
      scales_.push_back(known != outputs.end() && known->counts ? known->scale : 0.0);
    }
  const mbs::SolverOptions& o = run_.options;
  const double rows = 1.0 + (o.end_time - o.start_time) / o.output_step / static_cast<double>(every_);
  double worst = 0.0;
  for (std::size_t i = 0; i < scales_.size(); ++i)
    if (const auto k = static_cast<Eigen::Index>(i); scales_[i] > 0.0) {
      const double so_far = std::sqrt(sizes_(k) / std::max(1.0, static_cast<double>(compared_)));
      worst = std::max(worst, std::sqrt(squares_(k) / rows) / std::max(scales_[i], so_far));
    }
  return worst;
}

IntegratorEstimate GlobalError::estimate() {
  const Clock clock(wall_);
  advance(true);
  IntegratorEstimate out;
  out.wall = wall_;
  if (compared_ == 0) {
    out.note = "none of its rows could be judged; --check-integrator tells";
    return out;
  }
  const auto count = static_cast<double>(compared_);
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    outputs_[i].rms = std::sqrt(squares_(static_cast<Eigen::Index>(i)) / count);
    outputs_[i].size_rms = std::sqrt(sizes_(static_cast<Eigen::Index>(i)) / count);
  }
  families_.judge(outputs_, !run_.file.outputs.empty(), tolerance_of_noise(run_), Families::Of::run);
  const auto [error, worst] = worst_output(squares_, count, outputs_);
  if (worst >= 0) out.output = outputs_[static_cast<std::size_t>(worst)].name;
  out.note = why_unknown(error);
  out.is_whole = out.note.empty();
  if (out.is_whole) out.error = error;
  return out;
}

std::string GlobalError::why_unknown(double error) const {
  if (equation_.is_lost()) return "its error grew beyond all numbers; --check-integrator tells";
  // Of an error as large as the output itself a linear equation knows nothing.
  if (!(error < 1.0)) return "its error grows beyond what can be followed; --check-integrator tells";
  const std::string about = "about " + percent(error);
  if (misses_part_) return about + " since then; of the part before it is not known";
  if (has_jumped_)
    return about +
           ", but how jumps of velocities and of sampled controls change is not followed; "
           "--check-integrator tells";
  if (misses_rows_) return about + ", but some rows could not be judged; --check-integrator tells";
  if (error > kTrusted) return about + " to first order, too large to be trusted; --check-integrator tells";
  return {};
}

}  // namespace flexura::study
