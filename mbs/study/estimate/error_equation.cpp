// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/error_equation.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/lobatto.hpp"

namespace flexura::study {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mbs::Instant;
using mbs::lobatto::integral_of_basis;

ErrorEquation::ErrorEquation(const mbs::Equations& eq, const mbs::State& start, double duration)
    : eq_(eq),
      n_(eq.sizes()),
      scratch_(eq.make_scratch()),
      form_(eq, start),
      real_(form_),
      complex_(form_),
      n_rates_(n_.n_p + n_.n_v + n_.n_dyn),
      duration_(duration),
      kinematics_(eq, start.p),
      t_begin_(start.t),
      t_end_(start.t) {
  const Eigen::Index n = form_.size();
  for (VectorXd* x :
       {&e_begin_, &e_end_, &y_, &yp_, &rhs_, &x_, &rates_, &e_[0], &e_[1], &e_[2], &R_, &R_sum_, &R_moment_})
    x->setZero(n);
  rhs_c_.setZero(n);
  x_c_.setZero(n);
  for (VectorXd& r : r_) r.setZero(n_.n_v);
  for (VectorXd& c : c_rate_) c.setZero(n_.n_dyn);
  for (VectorXd* p : {&p_, &p_up_, &p_down_, &p_rate_, &p_rate2_}) p->setZero(n_.n_p);
  for (VectorXd& p : path_.p) p.setZero(n_.n_p);
  c_rate_end_.setZero(n_.n_dyn);
  r_end_.setZero(n_.n_v);
  inner_v_dot_.setZero(n_.n_v);
  b_.setZero(n_.n_alg);
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
    has_turns_ = has_turns_ || block.p.size() > 1;
}

void ErrorEquation::restart(const mbs::State& s, const VectorXd& v_dot, int steps_at_once) {
  close();
  form_.set_start(s);
  is_stale_ = true;
  span_ = 1;
  steps_at_once_ = std::max(1, steps_at_once);
  v_dot_end_ = v_dot;
  eq_.momentum(s, v_dot, *scratch_, r_end_, c_rate_end_, b_);
  has_end_ = true;
  path_.h = 0.0;
}

// The largest change of an entry of M, D or K, relative to the largest entry, all scaled to unit masses; of D and K where
// they do something within the run.
double ErrorEquation::change() const {
  const mbs::Tangents& d = form_.tangents();
  const VectorXd scale = d.M.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const auto part = [&](const MatrixXd& now, const MatrixXd& before, double least) {
    const MatrixXd change = scale.asDiagonal() * (now - before) * scale.asDiagonal(),
                   size = scale.asDiagonal() * now * scale.asDiagonal();
    return change.cwiseAbs().maxCoeff() / (size.cwiseAbs().maxCoeff() + least);
  };
  return std::max({part(d.M, M_, 0.0), part(d.z_v.topRows(n_.n_v), D_, 1.0 / duration_),
                   part(K_now_, K_, 1.0 / (duration_ * duration_))});
}

// In the middle of the steps that wait.
void ErrorEquation::linearise() {
  if (!is_stale_ && left_ > 0) {
    --left_;
    return;
  }
  form_.pack(middle_.state, middle_.v_dot, y_, yp_);
  form_.linearise(middle_.state.t, y_, yp_, mbs::TangentScope::everything);
  ++linearised_;
  h_factors_ = 0.0;
  const mbs::Tangents& d = form_.tangents();
  if (n_.n_v > 0) {
    form_.kinematics().multiply_T(d.z_p.topRows(n_.n_v), K_now_);
    if (!is_stale_) {
      const double part = change();
      if (part < kSmallChange)
        span_ = std::min(2 * span_, kLongestSpan);
      else if (!(part < 2.0 * kSmallChange))
        span_ = std::max(span_ / 2, 1);
    }
    M_ = d.M;
    D_ = d.z_v.topRows(n_.n_v);
    K_ = K_now_;
  }
  left_ = span_ - 1;
  is_stale_ = false;
}

// p, h p' and h^2 p'' of a state with accelerations v_dot.
void ErrorEquation::rates(const mbs::State& s, const VectorXd& v_dot, double h, VectorXd* p) {
  p[0] = s.p;
  eq_.kinematic(s.p, s.v, p_rate_);
  eq_.kinematic(s.p, v_dot, p[2]);
  if (has_turns_) {
    // T is quadratic in p at most: its change along p' by differences is exact but for round-off.
    constexpr double kStep = 1e-4;
    p_up_ = s.p + kStep * p_rate_;
    eq_.kinematic(p_up_, s.v, p_rate2_);
    p[2] += p_rate2_ / (2.0 * kStep);
    p_up_ = s.p - kStep * p_rate_;
    eq_.kinematic(p_up_, s.v, p_rate2_);
    p[2] -= p_rate2_ / (2.0 * kStep);
  }
  p[1] = h * p_rate_;
  p[2] *= h * h;
}

// Fills p, v and v_dot of the path at its share x.
void ErrorEquation::follow(double x, mbs::State& s, VectorXd& v_dot) {
  const double x2 = x * x, x3 = x2 * x, x4 = x3 * x, x5 = x4 * x, h = path_.h;
  const double value[6] = {
      1 - 10 * x3 + 15 * x4 - 6 * x5, x - 6 * x3 + 8 * x4 - 3 * x5, 0.5 * x2 - 1.5 * x3 + 1.5 * x4 - 0.5 * x5,
      10 * x3 - 15 * x4 + 6 * x5,     -4 * x3 + 7 * x4 - 3 * x5,    0.5 * x3 - x4 + 0.5 * x5};
  const double slope[6] = {-30 * x2 + 60 * x3 - 30 * x4,     1 - 18 * x2 + 32 * x3 - 15 * x4,
                           x - 4.5 * x2 + 6 * x3 - 2.5 * x4, 30 * x2 - 60 * x3 + 30 * x4,
                           -12 * x2 + 28 * x3 - 15 * x4,     1.5 * x2 - 4 * x3 + 2.5 * x4};
  const double bend[6] = {-60 * x + 180 * x2 - 120 * x3, -36 * x + 96 * x2 - 60 * x3,
                          1 - 9 * x + 18 * x2 - 10 * x3, 60 * x - 180 * x2 + 120 * x3,
                          -24 * x + 84 * x2 - 60 * x3,   3 * x - 12 * x2 + 10 * x3};
  s.p = value[0] * path_.p[0];
  p_rate_ = slope[0] * path_.p[0];
  p_rate2_ = bend[0] * path_.p[0];
  for (std::size_t k = 1; k < 6; ++k) {
    s.p += value[k] * path_.p[k];
    p_rate_ += slope[k] * path_.p[k];
    p_rate2_ += bend[k] * path_.p[k];
  }
  p_rate_ /= h;
  p_rate2_ /= h * h;
  s.v.resize(n_.n_v);
  v_dot.resize(n_.n_v);
  const auto to_velocities = [&](const VectorXd& p, VectorXd& v) {
    for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
      for (std::size_t i = 0; i < block.v.size(); ++i) {
        double sum = 0.0;
        for (std::size_t j = 0; j < block.p.size(); ++j)
          sum += block.T_inverse(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) * p(block.p[j]);
        v(block.v[i]) = sum;
      }
  };
  kinematics_.update_T(s.p);
  to_velocities(p_rate_, s.v);
  if (has_turns_) {
    constexpr double kStep = 1e-4;
    p_ = s.p + kStep * p_rate_;
    eq_.kinematic(p_, s.v, p_up_);
    p_ = s.p - kStep * p_rate_;
    eq_.kinematic(p_, s.v, p_down_);
    p_rate2_ -= (p_up_ - p_down_) / (2.0 * kStep);
  }
  to_velocities(p_rate2_, v_dot);
  if (has_turns_) follow_norms(s, v_dot);
}

// Of a quaternion the path leaves the norm, p' = T v + n with T^T n = 0, and v = T^+ p' changes by (T^T T)^-1 T'^T n more.
void ErrorEquation::follow_norms(const mbs::State& s, VectorXd& v_dot) {
  eq_.kinematic(s.p, s.v, p_up_);
  p_down_ = p_rate_ - p_up_;  // n
  v_step_.setZero(n_.n_v);
  std::size_t widest = 0;
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
    if (block.p.size() > 1) widest = std::max(widest, block.v.size());
  // T is linear in a quaternion: its rate is T of the quaternion's rate.
  std::vector<VectorXd> sums(kinematics_.blocks().size());
  for (std::size_t k = 0; k < widest; ++k) {
    v_step_.setZero();
    for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks())
      if (k < block.v.size()) v_step_(block.v[k]) = 1.0;
    eq_.kinematic(p_rate_, v_step_, p_up_);
    for (std::size_t b = 0; b < sums.size(); ++b) {
      const mbs::KinematicBlocks::Block& block = kinematics_.blocks()[b];
      if (block.p.size() < 2 || k >= block.v.size()) continue;
      if (sums[b].size() == 0) sums[b].setZero(static_cast<Eigen::Index>(block.v.size()));
      for (const int i : block.p) sums[b](static_cast<Eigen::Index>(k)) += p_up_(i) * p_down_(i);
    }
  }
  for (std::size_t b = 0; b < sums.size(); ++b) {
    if (sums[b].size() == 0) continue;
    const mbs::KinematicBlocks::Block& block = kinematics_.blocks()[b];
    const VectorXd more = block.T_inverse * (block.T_inverse.transpose() * sums[b]);
    for (std::size_t k = 0; k < block.v.size(); ++k) v_dot(block.v[k]) += more(static_cast<Eigen::Index>(k));
  }
}

void ErrorEquation::defects(const Instant& begin, const std::array<Instant, 3>& nodes) {
  path_.t = begin.state.t;
  path_.h = nodes[2].state.t - begin.state.t;
  // The accelerations that the equations were met with there, by the step before.
  rates(begin.state, has_end_ ? v_dot_end_ : begin.v_dot, path_.h, path_.p.data());
  rates(nodes[2].state, nodes[2].v_dot, path_.h, path_.p.data() + 3);
  r_[0] = r_end_;
  c_rate_[0] = c_rate_end_;
  if (!has_end_) eq_.momentum(begin.state, begin.v_dot, *scratch_, r_[0], c_rate_[0], b_);
  for (std::size_t k = 0; k < 2; ++k) {
    inner_ = nodes[k].state;
    follow(mbs::lobatto::kNode[k + 1], inner_, inner_v_dot_);
    eq_.momentum(inner_, inner_v_dot_, *scratch_, r_[k + 1], c_rate_[k + 1], b_);
  }
  eq_.momentum(nodes[2].state, nodes[2].v_dot, *scratch_, r_[3], c_rate_[3], b_);
  r_end_ = r_[3];
  c_rate_end_ = c_rate_[3];
  v_dot_end_ = nodes[2].v_dot;
  has_end_ = true;
}

// The step's defects to those that wait.
void ErrorEquation::add(const Instant& begin, const std::array<Instant, 3>& nodes) {
  const double h = path_.h, since = path_.t - t_begin_;
  // int R dt and int (t - t_begin) R dt of what R was before.
  R_sum_ += h * R_;
  R_moment_ += h * (since + 0.5 * h) * R_;
  auto R = R_.segment(form_.at_v(), n_.n_v), sum = R_sum_.segment(form_.at_v(), n_.n_v),
       moment = R_moment_.segment(form_.at_v(), n_.n_v);
  for (std::size_t k = 0; k < 4; ++k) {
    const double x = mbs::lobatto::kNode[k], w = integral_of_basis(static_cast<int>(k), 1.0);
    R += h * w * r_[k];
    sum += h * h * w * (1.0 - x) * r_[k];
    moment += h * h * w * ((1.0 - x) * since + 0.5 * (1.0 - x * x) * h) * r_[k];
  }
  if (n_.n_dyn == 0) return;
  auto c = R_.segment(form_.at_c(), n_.n_dyn), c_sum = R_sum_.segment(form_.at_c(), n_.n_dyn),
       c_moment = R_moment_.segment(form_.at_c(), n_.n_dyn);
  for (int k = 1; k < 4; ++k) {
    const double x = mbs::lobatto::kNode[k], w = integral_of_basis(k, 1.0);
    VectorXd R_c = nodes[static_cast<std::size_t>(k - 1)].state.c - begin.state.c;
    for (int j = 0; j < 4; ++j) R_c -= h * integral_of_basis(j, x) * c_rate_[static_cast<std::size_t>(j)];
    c_sum += h * w * R_c;
    c_moment += h * w * (since + x * h) * R_c;
    if (k == 3) c += R_c;
  }
}

void ErrorEquation::step(const Instant& begin, const std::array<Instant, 3>& nodes) {
  const double h = nodes[2].state.t - begin.state.t;
  if (!(h > 0.0) || is_lost_) return;
  if (waiting_ == 0) {
    t_begin_ = begin.state.t;
    e_begin_ = e_end_;
    for (VectorXd* R : {&R_, &R_sum_, &R_moment_}) R->setZero();
  }
  defects(begin, nodes);
  add(begin, nodes);
  if (waiting_ == 0 || waiting_ == steps_at_once_ / 2) {
    middle_.state = nodes[0].state;
    follow(0.5, middle_.state, middle_.v_dot);
  }
  t_waiting_ = nodes[2].state.t;
  if (++waiting_ >= steps_at_once_) close();
}

void ErrorEquation::close() {
  if (waiting_ == 0) return;
  waiting_ = 0;
  t_end_ = t_waiting_;
  const double h = t_end_ - t_begin_;
  // The cubic a x + b x^2 + c x^3 that has R at the end and its two integrals.
  static const Eigen::Matrix3d inverse = [] {
    Eigen::Matrix3d A;
    A << 1.0, 1.0, 1.0, 1.0 / 2.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 3.0, 1.0 / 4.0, 1.0 / 5.0;
    return Eigen::Matrix3d(A.inverse());
  }();
  std::array<VectorXd, 3> R;
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = k_.c[i];
    const Eigen::RowVector3d weights = Eigen::RowVector3d(x, x * x, x * x * x) * inverse;
    R[i] = weights(0) * R_ + weights(1) / h * R_sum_ + weights(2) / (h * h) * R_moment_;
  }
  linearise();
  solve(h, R);
}

void ErrorEquation::solve(double h, const std::array<VectorXd, 3>& R) {
  if (h != h_factors_) {
    h_factors_ = h;
    if (!real_.factor(k_.gamma / h) || !complex_.factor(k_.lambda / h)) is_lost_ = true;
  }
  // (1/h) sum_j B_ij F_y' (e_j - e_begin) + F_y e_i = (1/h) sum_j B_ij R_j
  form_.multiply_rates(e_begin_, rates_);
  std::array<VectorXd, 3> rhs;
  for (int i = 0; i < 3; ++i)
    rhs[i] = (k_.B(i, 0) * (R[0] + rates_) + k_.B(i, 1) * (R[1] + rates_) + k_.B(i, 2) * (R[2] + rates_)) / h;
  rhs_ = k_.v_left(0) * rhs[0] + k_.v_left(1) * rhs[1] + k_.v_left(2) * rhs[2];
  rhs_c_ = k_.w_left(0) * rhs[0] + k_.w_left(1) * rhs[1] + k_.w_left(2) * rhs[2];
  real_.solve(rhs_, x_);
  complex_.solve(rhs_c_, x_c_);
  for (int i = 0; i < 3; ++i) e_[i] = k_.v(i) * x_ + 2.0 * (k_.w(i) * x_c_).real();
  e_end_ = e_[2];
  if (is_lost_ || !e_end_.allFinite()) {
    is_lost_ = true;
    for (VectorXd* e : {&e_[0], &e_[1], &e_[2], &e_begin_, &e_end_}) e->setZero();
  }
}

void ErrorEquation::beside(const mbs::State& s, VectorXd& out) {
  out.setZero(n_rates_);
  if (!(path_.h > 0.0) || s.t < path_.t) return;
  inner_ = s;
  follow(std::min((s.t - path_.t) / path_.h, 1.0), inner_, inner_v_dot_);
  out.head(n_.n_p) = s.p - inner_.p;
  // A quaternion and its opposite are one.
  for (const mbs::KinematicBlocks::Block& block : kinematics_.blocks()) {
    if (block.p.size() < 2) continue;
    double sum = 0.0;
    for (const int i : block.p) sum += s.p(i) * inner_.p(i);
    if (sum < 0.0)
      for (const int i : block.p) out(i) = s.p(i) + inner_.p(i);
  }
  out.segment(n_.n_p, n_.n_v) = s.v - inner_.v;
}

void ErrorEquation::at(double t, VectorXd& e) const {
  if (!(t_end_ > t_begin_)) {
    e = e_end_.head(n_rates_);
    return;
  }
  const double x = std::clamp((t - t_begin_) / (t_end_ - t_begin_), 0.0, 1.0);
  e = e_begin_.head(n_rates_);
  for (int i = 0; i < 3; ++i) e += k_.basis(i, x) * (e_[i] - e_begin_).head(n_rates_);
}

}  // namespace flexura::study
