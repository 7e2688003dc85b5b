// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/error_equation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/accuracy/scales.hpp"
#include "mbs/solver/algebra/lobatto.hpp"

namespace flexura::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using mbs::Instant;
using mbs::KinematicBlocks;
using mbs::lobatto::integral_of_basis;
using mbs::lobatto::kNode;

namespace {

// From d at Lobatto's points to R = int d dt at Radau's, in spans: of the cubic a x + b x^2 + c x^3 that has R, int R dt and
// int x R dt of the whole span.
Eigen::Matrix3d cubic(const mbs::RadauTableau& k) {
  Eigen::Matrix3d A, X;
  A << 1.0, 1.0, 1.0,                   //
      1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0,  //
      1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0;
  for (int i = 0; i < 3; ++i) {
    const double x = k.c[static_cast<std::size_t>(i)];
    X.row(i) << x, x * x, x * x * x;
  }
  return X * A.inverse();
}

Eigen::Matrix<double, 3, 4> moments_of_rate() {
  Eigen::Matrix<double, 3, 4> m;
  for (int k = 0; k < 4; ++k) {
    const double x = kNode[k], w = integral_of_basis(k, 1.0);
    m.col(k) << w, w * (1.0 - x), 0.5 * w * (1.0 - x * x);
  }
  return m;
}

}  // namespace

ErrorEquation::ErrorEquation(const mbs::Equations& eq, const mbs::State& start,
                             const mbs::SolverOptions& options)
    : eq_(eq),
      n_(eq.sizes()),
      scratch_(eq.make_scratch()),
      form_(eq, start),
      radau_(k_, form_),
      gauss_(gauss_k_, form_),
      at_once_(form_),
      weights_(eq, options),
      n_rates_(n_.n_p + n_.n_v + n_.n_dyn),
      duration_(options.end_time - options.start_time),
      path_(eq, start.p),
      turns_(path_.kinematics().blocks().size()),
      t_begin_(start.t),
      t_end_(start.t) {
  const Index n = form_.size();
  for (VectorXd* x : {&e_begin_, &e_end_, &y_, &yp_, &rhs_, &x_, &rates_, &error_.y}) x->setZero(n);
  e_.assign(1, {e_end_, e_end_, e_end_, e_end_});
  for (VectorXd& d : d_) d.setZero(n);
  d_middle_.setZero(n);
  for (VectorXd& r : R_) r.setZero(n);
  has_cheap_matrices_ = n_.n_v <= kCheap;
  holds_ = has_cheap_matrices_ ? kClose : kRough;
  rhs_c_.setZero(n);
  x_c_.setZero(n);
  for (VectorXd* p : {&p_, &p_rate_, &dp_}) p->setZero(n_.n_p);
  for (VectorXd* v : {&v_, &dv_, &error_.v_dot, &greatest_run_, &greatest_, &lost_, &a_}) v->setZero(n_.n_v);
  for (VectorXd* g : {&g_, &g_dot_, &zero_}) g->setZero(n_.n_lambda);
  none_ = error_part_ = error_;
  out_ = error_.y;
  tolerance_ = options.tolerance;
  reach_p_.resize(n_.n_p);
  reach_v_.resize(n_.n_v);
  for (int i = 0; i < n_.n_p; ++i) reach_p_(i) = 1.0 / eq.position_scale(i);
  for (int i = 0; i < n_.n_v; ++i) reach_v_(i) = 1.0 / eq.velocity_scale(i);
  if (options.scales && options.scales->reach_v.size() == n_.n_v &&
      options.scales->reach_p.size() == n_.n_p) {
    length_ = options.scales->length;
    reach_p_ = options.scales->reach_p;
    reach_v_ = options.scales->reach_v;
  }
  c_rate_.setZero(n_.n_dyn);
  b_.setZero(n_.n_alg);
}

void ErrorEquation::restart(const mbs::State& s, const VectorXd& v_dot, int longest_span) {
  form_.set_start(s);
  if (!has_start_)
    weights_.start(s, v_dot);
  else
    weights_.take(s.p, s.v);
  has_start_ = true;
  is_stale_ = true;
  span_ = 1;
  longest_span_ = static_cast<std::size_t>(std::max(1, longest_span));
  v_dot_end_ = v_dot;
  path_.clear();
}

void ErrorEquation::step(const Instant& begin, const std::array<Instant, 3>& nodes) {
  if (!(nodes[2].state.t > begin.state.t) || is_lost_) return;
  if (waiting_.size() == count_) waiting_.emplace_back();
  waiting_[count_].begin = begin;
  waiting_[count_].nodes = nodes;
  ++count_;
}

bool ErrorEquation::advance(bool end) {
  if (count_ == 0 || (!end && count_ < span_)) return false;
  const std::size_t steps = choose_span();
  carry(steps);
  std::rotate(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(steps),
              waiting_.begin() + static_cast<std::ptrdiff_t>(count_));
  count_ -= steps;
  return true;
}

// The run itself at a time within these steps: what the path does not tell of a state.
void ErrorEquation::state_at(std::size_t steps, double t, Instant& out) const {
  std::size_t i = 0;
  while (i + 1 < steps && t > waiting_[i].nodes[2].state.t) ++i;
  const Step& step = waiting_[i];
  const double begin = step.begin.state.t, h = step.nodes[2].state.t - begin;
  mbs::EnergyBook::interpolate(step.begin, step.nodes, (t - begin) / h, out);
}

// Between e of p at the pose of the derivatives and the turn of each block, which the motion carries along.
void ErrorEquation::to_turns(VectorXd& e) {
  for (std::size_t b = 0; b < turns_.size(); ++b)
    if (const KinematicBlocks::Block& block = form_.kinematics().blocks()[b]; block.p.size() > 1)
      turns_[b] = block.T_inverse * e(block.p);
}
void ErrorEquation::from_turns(VectorXd& e) {
  for (std::size_t b = 0; b < turns_.size(); ++b)
    if (const KinematicBlocks::Block& block = form_.kinematics().blocks()[b]; block.p.size() > 1)
      e(block.p) = block.T * turns_[b];
}

// In the middle of the span.
void ErrorEquation::linearise(std::size_t steps) {
  std::array<VectorXd*, 2> carried = {&e_begin_, &e_end_};
  std::array<std::vector<VectorXd>, 2> turns;
  for (std::size_t i = 0; i < carried.size(); ++i) {
    to_turns(*carried[i]);
    turns[i] = turns_;
  }
  state_at(steps, path_.begin() + 0.5 * path_.length(), between_);
  path_.at(0.5, between_.state, between_.v_dot);
  form_.pack(between_.state, between_.v_dot, y_, yp_);
  form_.linearise(between_.state.t, y_, yp_, mbs::TangentScope::everything);
  form_.carry_along();
  for (std::size_t i = 0; i < carried.size(); ++i) {
    turns_ = turns[i];
    from_turns(*carried[i]);
  }
  ++linearised_;
  radau_.h = gauss_.h = 0.0;
  has_at_once_ = false;
  is_stale_ = false;
  unchecked_ = 0;
  most_unchecked_ = 1;
}

// R of Radau's points for d of w - e*, with e* the last solution.
void ErrorEquation::integrals(double h) {
  static const Eigen::Matrix3d to_radau = cubic(k_);
  static const Eigen::Matrix<double, 3, 4> from_rate = to_radau * moments_of_rate();
  // At the begin anew, too: where the run leaves its equations between its states, e' is not what it was at the end of the
  // span before, and derivatives that have changed since would take the difference for a defect.
  for (std::size_t k = 0; k < 4; ++k) {
    error_at(kNode[k], h, error_);
    look(nodes_[k].w, nodes_[k].gaps, error_, d_[k]);
    add_linear(error_, d_[k]);
  }
  if (pieces_ > 1 && is_one_step_) look_half_way(h);
  const Index n_rates = n_.n_p + n_.n_v, n_rest = form_.size() - form_.at_a();
  for (int i = 0; i < 3; ++i) {
    VectorXd& r = R_[static_cast<std::size_t>(i)];
    r.setZero();
    for (int k = 0; k < 4; ++k) {
      const VectorXd& d = d_[static_cast<std::size_t>(k)];
      r.head(n_rates) += h * from_rate(i, k) * d.head(n_rates);
      r.tail(n_rest) += mbs::lobatto::basis(k, k_.c[static_cast<std::size_t>(i)]) * d.tail(n_rest);
    }
  }
  if (n_.n_dyn == 0) return;
  // Of dynamic states R = c - c(0) - int f_c dt at Lobatto's points.
  Eigen::Matrix3Xd moments = Eigen::Matrix3Xd::Zero(3, n_.n_dyn);
  for (int k = 1; k < 4; ++k) {
    const double x = kNode[k], w = integral_of_basis(k, 1.0);
    VectorXd R_c = nodes_[static_cast<std::size_t>(k)].w.state.c - nodes_[0].w.state.c;
    for (int j = 0; j < 4; ++j)
      R_c -= h * integral_of_basis(j, x) * d_[static_cast<std::size_t>(j)].segment(form_.at_c(), n_.n_dyn);
    if (k == 3) moments.row(0) = R_c;
    moments.row(1) += w * R_c;
    moments.row(2) += w * x * R_c;
  }
  const Eigen::Matrix3Xd R_c = to_radau * moments;
  for (int i = 0; i < 3; ++i) R_[static_cast<std::size_t>(i)].segment(form_.at_c(), n_.n_dyn) = R_c.row(i);
}

// One step of Newton's method from the last solution.
void ErrorEquation::improve(double h) {
  part_ = kFollowed / std::max({kFollowed, size_of(e_begin_), size_of(e_end_)});
  try {
    integrals(h);
  } catch (const std::runtime_error&) {
    // Beyond where the equations hold: on the path itself the run has asked them.
    part_ = 0.0;
    integrals(h);
  }
  solve(h);
}

// The span of these steps, whose path is laid.
void ErrorEquation::carry(std::size_t steps) {
  t_begin_ = path_.begin();
  t_end_ = t_begin_ + path_.length();
  if (is_lost_) return;
  const double h = path_.length();
  e_begin_ = e_end_;
  lay_nodes(steps);
  is_one_step_ = steps == 1;
  pieces_ = next_pieces_;
  for (;;) {
    const bool is_fresh = is_stale_;
    if (is_fresh) linearise(steps);
    // What the error becomes by itself.
    for (VectorXd& r : R_) r.setZero();
    for (VectorXd& d : d_) d.setZero();
    d_middle_.setZero();
    has_middle_ = false;
    rings_ = false;
    e_.assign(pieces_, {e_begin_, e_begin_, e_begin_, e_begin_});
    if (spans_ > 0 && has_cheap_matrices_) solve(h);
    predicted_ = e_;
    improve(h);
    if (!is_lost_ && !keeps_vibration(h)) {
      e_end_ = e_begin_;
      continue;
    }
    if (is_fresh || is_lost_ || ++unchecked_ < most_unchecked_) break;
    const double first = distance_of_rates(predicted_);
    predicted_ = e_;
    improve(h);
    const double second = distance_of_rates(predicted_), counts = size_of_rates(e_) * h / duration_;
    const double third = first > 0.0 ? second * second / first : 0.0;
    unchecked_ = 0;
    if (second > holds_.contracts * first && third > holds_.far * counts) {
      is_stale_ = true;
      e_end_ = e_begin_;
      continue;
    }
    is_stale_ = third > holds_.far * counts;
    most_unchecked_ =
        second < holds_.near * counts ? std::min(2 * most_unchecked_, holds_.most_unchecked) : 1;
    break;
  }
  if (rings_ && !is_lost_) keep_ringing(h);
  rang_ = rings_;
  ++spans_;
  v_dot_end_ = waiting_[steps - 1].nodes[2].v_dot;
}

// What the solution leaves out at a share x of the span: the quartic int d dt less the cubic R that stands for it, and what
// w itself lacks of the motion.  That is c x^3 (1 - x)^3 of positions, whose second derivative vanishes at Lobatto's points
// and is -3/8 c / h^2 half way, d there less the cubic of the others; of speeds it is of order five, as what a step of order
// five leaves at its end.  Of spans of several steps that is less than the tolerance.
void ErrorEquation::add_within(double x, VectorXd& y) {
  const double h = t_end_ - t_begin_;
  if (is_one_step_ && !has_middle_) {
    part_ = kFollowed / std::max({kFollowed, size_of(e_begin_), size_of(e_end_)});
    look_half_way(h);
  }
  rhs_.setZero();
  add_defects(x, h, rhs_);
  auto R = rhs_.segment(form_.at_v(), n_.n_v);
  for (int i = 0; i < 3; ++i)
    R -= k_.basis(i, x) * R_[static_cast<std::size_t>(i)].segment(form_.at_v(), n_.n_v);
  R *= k_.gamma / radau_.h;
  rhs_.head(form_.at_v()).setZero();
  radau_.real.solve(rhs_, x_);
  y.segment(form_.at_v(), n_.n_v) += x_.segment(form_.at_v(), n_.n_v);
}

void ErrorEquation::at(const mbs::State& s, VectorXd& e) {
  VectorXd y = e_end_;
  if (t_end_ > t_begin_) {
    const double x = std::clamp((s.t - t_begin_) / (t_end_ - t_begin_), 0.0, 1.0);
    value_at(x, y);
    if (rings_) {
      // Of what is faster than its steps the stages of Gauss hold nothing, the ends all.
      const auto end = static_cast<std::size_t>(std::lround(x * static_cast<double>(kMostPieces)));
      if (end > 0) y += ringing_[end - 1];
    }
    if (e_.size() == 1 && x > 0.0 && x < 1.0) add_within(x, y);
  }
  e = y.head(n_rates_);
  if (path_.has_turns()) {
    to_turns(y);
    v_.setZero();
    const std::vector<KinematicBlocks::Block>& blocks = path_.kinematics().blocks();
    for (std::size_t b = 0; b < turns_.size(); ++b)
      if (blocks[b].p.size() > 1) v_(blocks[b].v) = turns_[b];
    eq_.kinematic(s.p, v_, p_);
    for (const KinematicBlocks::Block& block : blocks)
      if (block.p.size() > 1) e(block.p) = p_(block.p);
  }
  path_.beside(s, dp_, dv_);
  e.head(n_.n_p) += dp_;
  e.segment(n_.n_p, n_.n_v) += dv_;
}

}  // namespace flexura::study
