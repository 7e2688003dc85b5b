// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/energy.hpp"

#include <algorithm>
#include <cmath>

namespace flexura::mbs {

double EnergyAccount::relative_error() const {
  const double scale = std::max(gross_work, peak);
  // A structure that stands still moves no energy but the round-off of what it holds.
  constexpr double kRoundOff = 1e-10;
  const double held = kRoundOff * (now.kinetic + std::abs(now.strain) + std::abs(now.potential));
  return scale > held ? std::abs(error()) / scale : 0.0;
}

EnergyBook::EnergyBook(const Equations& eq) : eq_(eq), scratch_(eq.make_scratch()) {}

void EnergyBook::look(const EnergyReport& now, EnergyAccount& account) const {
  account.now = now;
  account.peak = std::max({account.peak, account.now.kinetic, std::abs(account.total() - account.start)});
}

void EnergyBook::start(const State& s, const Eigen::VectorXd& v_dot) {
  account_ = {};
  account_.now = eq_.energy(s, v_dot, *scratch_);
  account_.start = account_.total();
  account_.peak = account_.now.kinetic;
  t_ = s.t;
  h_ = 0.0;
}

void EnergyBook::resume(const EnergyAccount& account, double t) {
  account_ = account;
  t_ = t;
  h_ = 0.0;
}

namespace {

// Lobatto's four points: the ends, which are evaluated anyway, and two between.
const double kNode[4] = {0.0, 0.5 - std::sqrt(0.05), 0.5 + std::sqrt(0.05), 1.0};

// Integral from 0 to x of the cubic that is 1 at node i and 0 at the others; at x = 1 Lobatto's weights.
double integral_of_basis(int i, double x) {
  // The other three nodes: (u - a)(u - b)(u - c) = u^3 - S u^2 + P u - Q.
  double a[3], scale = 1.0;
  for (int j = 0, k = 0; j < 4; ++j)
    if (j != i) {
      a[k++] = kNode[j];
      scale *= kNode[i] - kNode[j];
    }
  const double S = a[0] + a[1] + a[2], P = a[0] * a[1] + a[1] * a[2] + a[2] * a[0], Q = a[0] * a[1] * a[2];
  return x * (x * (x * (0.25 * x - S / 3.0) + 0.5 * P) - Q) / scale;
}

}  // namespace

std::array<double, 3> EnergyBook::node_times(double t_begin, double t_end) {
  const double h = t_end - t_begin;
  return {t_begin + kNode[1] * h, t_begin + kNode[2] * h, t_end};
}

void EnergyBook::open_step(double t_end, const std::array<Instant, 3>& nodes) {
  t_end_ = t_end;
  h_ = t_end - t_;
  at_node_[0] = account_.now;
  for (int i = 0; i < 3; ++i) at_node_[i + 1] = eq_.energy(nodes[i].state, nodes[i].v_dot, *scratch_);
}

void EnergyBook::add(double x, EnergyAccount& account) const {
  for (int i = 0; i < 4; ++i) {
    const double weight = h_ * integral_of_basis(i, x);
    account.work_in += weight * at_node_[i].input_power;
    account.gross_work += weight * std::abs(at_node_[i].input_power);
    account.dissipated += weight * at_node_[i].dissipated_power;
  }
}

bool EnergyBook::asks_multipliers(const State& s) {
  const int n_lambda = static_cast<int>(s.lambda.size());
  if (n_lambda == 0) return false;
  g_t_.resize(n_lambda);
  rest_.setZero(s.v.size());
  eq_.velocity_constraints(s.t, s.p, rest_, *scratch_, g_t_);
  return !g_t_.isZero(0.0);
}

EnergyAccount EnergyBook::at_row(const State& s, const Eigen::VectorXd& v_dot) {
  EnergyAccount account = account_;
  if (h_ > 0.0) add((s.t - t_) / h_, account);
  look(eq_.energy(s, v_dot, *scratch_), account);
  account_.peak = account.peak;
  return account;
}

void EnergyBook::close_step() {
  if (h_ > 0.0) add(1.0, account_);
  look(at_node_[3], account_);
  t_ = t_end_;
  h_ = 0.0;
}

void EnergyBook::jump(const State& s, const Eigen::VectorXd& v_dot) {
  const double before = account_.total();
  look(eq_.energy(s, v_dot, *scratch_), account_);
  // What it takes is lost; what it gives comes from a drive whose speed jumps.
  const double lost = before - account_.total();
  if (lost >= 0.0) {
    account_.dissipated += lost;
  } else {
    account_.work_in -= lost;
    account_.gross_work -= lost;
  }
}

}  // namespace flexura::mbs
