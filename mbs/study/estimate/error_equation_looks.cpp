// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
/// ErrorEquation: what the equations say of the run less its error.
#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/lobatto.hpp"
#include "mbs/study/estimate/error_equation.hpp"

namespace flexura::study {

using Eigen::Index;
using Eigen::VectorXd;
using mbs::Instant;
using mbs::KinematicBlocks;
using mbs::lobatto::kNode;

// 1 at Radau's point i and 0 at the others.
double ErrorEquation::parabola(std::size_t i, double x) const {
  const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
  const std::array<double, 3>& c = k_.c;
  return (x - c[j]) * (x - c[k]) / ((c[i] - c[j]) * (c[i] - c[k]));
}

// Of the polynomial of the last solution, at its share x of the span.
void ErrorEquation::error_at(double x, double h, Error& out) const {
  if (part_ == 0.0) {
    out = none_;
    return;
  }
  value_at(x, out.y);
  const std::size_t piece = piece_at(x);
  const auto m = static_cast<double>(e_.size());
  x = x * m - static_cast<double>(piece);
  const Piece& e = e_[piece];
  acceleration_at(piece, x, h / m, out.v_dot);
  // Multipliers and algebraic states have no value at the begin: the parabola through the stages.
  const Index n = form_.size() - form_.at_a();
  out.y.tail(n).setZero();
  for (std::size_t i = 0; i < 3; ++i) out.y.tail(n) += parabola(i, x) * e[i].tail(n);
}

// How large the error is, in parts of the mechanism and of its greatest speed.
double ErrorEquation::size_of(const VectorXd& y) {
  off_p_ = off_v_ = 0.0;
  for (const KinematicBlocks::Block& block : form_.kinematics().blocks())
    for (std::size_t i = 0; i < block.v.size(); ++i) {
      const int v = block.v[i];
      off_p_ = std::max(off_p_,
                        std::abs(block.T_inverse.row(static_cast<Index>(i)).dot(y(block.p))) * reach_v_(v));
      off_v_ = std::max(off_v_, std::abs(y(form_.at_v() + v)) * reach_v_(v));
    }
  return std::max(off_p_ / length_, off_v_ / speed_);
}

// F of w - e* at `at` of w, of so small a part of e* that it is small, and what is linear of the rest.
void ErrorEquation::look(const Instant& at, const VectorXd& gaps, const Error& e, VectorXd& out) {
  if (!(part_ < 1.0)) {
    residual(at, e, out);
    out.tail(2 * n_.n_lambda) -= gaps;
    return;
  }
  residual(at, none_, out_);
  if (part_ > 0.0) {
    error_part_.y = part_ * e.y;
    error_part_.v_dot = part_ * e.v_dot;
    residual(at, error_part_, out);
    out = out / part_ + (1.0 - 1.0 / part_) * out_;
  } else {
    out = out_;
  }
  out.tail(2 * n_.n_lambda) -= gaps;
}

// How far the run itself is off its constraints is not followed: rows of a run are moved onto them.
void ErrorEquation::gaps(const Instant& at, VectorXd& out) {
  out.setZero(2 * n_.n_lambda);
  if (n_.n_lambda == 0) return;
  eq_.constraints(at.state, at.state.p, at.state.v, *scratch_, g_, g_dot_);
  out.head(n_.n_lambda) = g_dot_;
  for (int k = 0; k < n_.n_lambda; ++k)
    if (form_.is_holonomic(k)) out(n_.n_lambda + k) = g_(k);
}

// w at Lobatto's points, and half way.
void ErrorEquation::lay_nodes(std::size_t steps) {
  nodes_[0].w = waiting_.front().begin;
  nodes_[0].w.v_dot = v_dot_end_;
  for (std::size_t k = 1; k < 4; ++k) {
    Instant& w = nodes_[k].w;
    if (k == 3)
      w = waiting_[steps - 1].nodes[2];
    else if (steps == 1)
      w = waiting_.front().nodes[k - 1];
    else
      state_at(steps, path_.begin() + kNode[k] * path_.length(), w);
    if (k < 3) path_.at(kNode[k], w.state, w.v_dot);
  }
  for (Node& node : nodes_) gaps(node.w, node.gaps);
  state_at(steps, path_.begin() + 0.5 * path_.length(), middle_.w);
  path_.at(0.5, middle_.w.state, middle_.w.v_dot);
  gaps(middle_.w, middle_.gaps);
}

// F of w - e at `at` of w, in the order of the form; of the dynamic states their rates.
void ErrorEquation::residual(const Instant& at, const Error& e, VectorXd& out) {
  mbs::State& u = moved_.state;
  u = at.state;
  moved_rates(e, at, out);
  u.v -= e.y.segment(form_.at_v(), n_.n_v);
  u.c -= e.y.segment(form_.at_c(), n_.n_dyn);
  u.a -= e.y.segment(form_.at_a(), n_.n_alg);
  u.lambda -= e.y.segment(form_.at_lambda(), n_.n_lambda);
  moved_.v_dot = at.v_dot - e.v_dot;
  eq_.residuals(u, moved_.v_dot, zero_, *scratch_, v_, c_rate_, b_, g_dot_, g_, dv_);
  out.segment(form_.at_v(), n_.n_v) = v_;
  out.segment(form_.at_c(), n_.n_dyn) = c_rate_;
  out.segment(form_.at_a(), n_.n_alg) = b_;
  out.segment(form_.at_lambda(), n_.n_lambda) = g_dot_;
  out.tail(n_.n_lambda) = g_;
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!form_.is_holonomic(k)) out(form_.at_mu() + k) = 0.0;
}

// The moved positions, p - T theta, and how far the rate of theta is off: with T linear in p, as of a quaternion,
//
//     T theta' = T(p) v - T(p - T theta) (v - e_v) - T(p') theta.
void ErrorEquation::moved_rates(const Error& e, const Instant& at, VectorXd& out) {
  out.head(n_.n_p).setZero();
  mbs::State& u = moved_.state;
  if (!path_.has_turns()) {
    u.p -= e.y.head(n_.n_p);
    return;
  }
  const std::vector<KinematicBlocks::Block>& blocks = form_.kinematics().blocks();
  v_.setZero();
  for (const KinematicBlocks::Block& block : blocks)
    for (std::size_t i = 0; i < block.v.size(); ++i)
      v_(block.v[i]) = block.T_inverse.row(static_cast<Index>(i)).dot(e.y(block.p));
  eq_.kinematic(at.state.p, v_, p_);
  u.p -= p_;
  // T(p') theta
  eq_.kinematic(at.state.p, at.state.v, p_rate_);
  eq_.kinematic(p_rate_, v_, p_);
  p_rate_ -= p_;
  dv_ = at.state.v - e.y.segment(form_.at_v(), n_.n_v);
  eq_.kinematic(u.p, dv_, p_);
  p_rate_ -= p_;
  // T of the pose there is wanted once more, for T^+ = T^T / |T|^2: as far as the rate is along T.
  for (const KinematicBlocks::Block& block : blocks) {
    if (block.p.size() < 2) continue;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 8, 1> turn(static_cast<Index>(block.v.size()));
    for (std::size_t k = 0; k < block.v.size(); ++k) {
      v_.setZero();
      v_(block.v[k]) = 1.0;
      eq_.kinematic(at.state.p, v_, p_);
      turn(static_cast<Index>(k)) = p_(block.p).dot(p_rate_(block.p)) / p_(block.p).squaredNorm();
    }
    out(block.p) = block.T * turn;
  }
}

// e of p as a change of velocities' integrals.
void ErrorEquation::to_rates(const VectorXd& e, VectorXd& theta) const {
  theta.setZero(n_.n_v);
  for (const KinematicBlocks::Block& block : form_.kinematics().blocks())
    for (std::size_t i = 0; i < block.v.size(); ++i)
      theta(block.v[i]) = block.T_inverse.row(static_cast<Index>(i)).dot(e(block.p));
}

// out += J e but for its rates of p and c.
void ErrorEquation::add_linear(const Error& e, VectorXd& out) {
  const mbs::Tangents& d = form_.tangents();
  const auto e_p = e.y.head(n_.n_p), e_v = e.y.segment(form_.at_v(), n_.n_v),
             e_c = e.y.segment(form_.at_c(), n_.n_dyn), e_a = e.y.segment(form_.at_a(), n_.n_alg),
             e_lambda = e.y.segment(form_.at_lambda(), n_.n_lambda);
  auto z = out.segment(form_.at_v(), n_.n_v + n_.n_dyn + n_.n_alg);
  z.noalias() += d.z_p * e_p;
  z.noalias() += d.z_v * e_v;
  if (n_.n_dyn > 0) z.noalias() += d.z_c * e_c;
  if (n_.n_alg > 0) z.noalias() += d.z_a * e_a;
  z.head(n_.n_v).noalias() += d.M * e.v_dot;
  if (d.c_v_dot.size() > 0) z.segment(n_.n_v, n_.n_dyn).noalias() += d.c_v_dot * e.v_dot;
  if (d.b_v_dot.size() > 0) z.tail(n_.n_alg).noalias() += d.b_v_dot * e.v_dot;
  if (path_.has_turns())
    for (const KinematicBlocks::Block& block : form_.kinematics().blocks()) {
      if (block.p.size() < 2) continue;
      // theta' as the form has it, where the equations' own is in `out`.
      out(block.p) -= block.A * e_p(block.p) + block.T * e_v(block.v);
    }
  if (n_.n_lambda == 0) return;
  z.head(n_.n_v).noalias() += d.G.transpose() * e_lambda;
  if (d.c_lambda.size() > 0) z.segment(n_.n_v, n_.n_dyn).noalias() += d.c_lambda * e_lambda;
  if (d.b_lambda.size() > 0) z.tail(n_.n_alg).noalias() += d.b_lambda * e_lambda;
  auto g_dot = out.segment(form_.at_lambda(), n_.n_lambda), g = out.tail(n_.n_lambda);
  g_dot.noalias() += d.G * e_v + d.h_p * e_p;
  to_rates(e.y, theta_);
  g.noalias() += d.G * theta_;
  if (d.g_c.size() > 0) {
    g_dot.noalias() += d.h_c * e_c;
    g.noalias() += d.g_c * e_c;
  }
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!form_.is_holonomic(k)) g(k) = 0.0;
}

}  // namespace flexura::study
