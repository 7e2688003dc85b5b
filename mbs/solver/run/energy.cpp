// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/run/energy.hpp"

#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/lobatto.hpp"

namespace flexura::mbs {

double EnergyAccount::relative_error() const {
  const double scale = std::max(gross_work, peak);
  // A structure that stands still moves no energy but the round-off of what it holds.
  constexpr double kRoundOff = 1e-10;
  const double held = kRoundOff * (now.kinetic + std::abs(now.strain) + std::abs(now.potential));
  return scale > held && scale > round_off ? std::abs(error()) / scale : 0.0;
}

namespace {

// Of typical speeds: what the last digits of positions do within 0.1 ms.
constexpr double kRoundOffSpeed = 1e-12;

// A step is halved no further than into parts of 2^-12 of it, and into no more than these.
constexpr double kShortest = 1.0 / 4096.0;
constexpr std::size_t kMostParts = 128;

}  // namespace

EnergyBook::EnergyBook(const Equations& eq, double tolerance)
    : eq_(eq), scratch_(eq.make_scratch()), tolerance_(tolerance) {
  parts_.reserve(kMostParts);
  parts_.resize(1);
}

void EnergyBook::look(const EnergyReport& now, EnergyAccount& account) const {
  account.now = now;
  account.peak = std::max({account.peak, account.now.kinetic, std::abs(account.total() - account.start)});
}

double EnergyBook::round_off_energy(const State& s, const Eigen::VectorXd& v_dot) const {
  State noise = s;
  for (Eigen::Index i = 0; i < s.v.size(); ++i)
    noise.v(i) = kRoundOffSpeed * eq_.rate_scale(static_cast<int>(i));
  return eq_.energy(noise, v_dot, *scratch_).kinetic;
}

void EnergyBook::start(const State& s, const Eigen::VectorXd& v_dot) {
  account_ = {};
  account_.round_off = round_off_energy(s, v_dot);
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

using lobatto::basis;
using lobatto::integral_of_basis;
using lobatto::kNode;

std::array<double, 3> EnergyBook::node_times(double t_begin, double t_end) {
  const double h = t_end - t_begin;
  return {t_begin + kNode[1] * h, t_begin + kNode[2] * h, t_end};
}

void EnergyBook::interpolate(const Instant& begin, const std::array<Instant, 3>& nodes, double x,
                             Instant& at) {
  const double N[4] = {basis(0, x), basis(1, x), basis(2, x), basis(3, x)};
  const auto mix = [&](Eigen::VectorXd State::*y) {
    at.state.*y = N[0] * begin.state.*y + N[1] * nodes[0].state.*y + N[2] * nodes[1].state.*y +
                  N[3] * nodes[2].state.*y;
  };
  for (const auto y : {&State::p, &State::v, &State::c, &State::lambda, &State::a}) mix(y);
  at.state.t = begin.state.t + x * (nodes[2].state.t - begin.state.t);
  at.state.root = nodes[0].state.root;
  at.state.u = nodes[0].state.u;
  at.v_dot = N[0] * begin.v_dot + N[1] * nodes[0].v_dot + N[2] * nodes[1].v_dot + N[3] * nodes[2].v_dot;
}

// What the four points may miss of the part's work [J]. With c_k the coefficients of Legendre's polynomials, which fall
// by a ratio r each where the power is analytic about the part, the first one missed is c_6: of size P r^6 with r from
// c_2 = P r^2 and c_3 = P r^3, the larger of the two (a power that is odd or even about the middle has one of them).
double EnergyBook::unresolved(const Part& part) const {
  double missed = 0.0;
  for (const auto power : {&EnergyReport::input_power, &EnergyReport::dissipated_power}) {
    const double f[4] = {part.at[0].*power, part.at[1].*power, part.at[2].*power, part.at[3].*power};
    const double P = std::max({std::abs(f[0]), std::abs(f[1]), std::abs(f[2]), std::abs(f[3])});
    if (P == 0.0) continue;
    const double c_2 = 5.0 / 12.0 * std::abs(f[0] + f[3] - f[1] - f[2]) / P;
    const double c_3 = 0.25 * std::abs(f[3] - f[0] - std::sqrt(5.0) * (f[2] - f[1])) / P;
    missed += h_ * part.length * P * std::max(c_2 * c_2 * c_2, c_3 * c_3);
  }
  return missed;
}

void EnergyBook::halve(std::size_t k, const Between& between) {
  const Part whole = parts_[k];
  const auto look_at = [&](double x) {
    const Instant& at = between(x);
    return eq_.energy(at.state, at.v_dot, *scratch_);
  };
  Part left, right;
  left.begin = whole.begin;
  left.length = right.length = 0.5 * whole.length;
  right.begin = left.begin + left.length;
  for (const int i : {1, 2}) {
    left.at[i] = look_at(left.begin + kNode[i] * left.length);
    right.at[i] = look_at(right.begin + kNode[i] * right.length);
  }
  left.at[0] = whole.at[0];
  left.at[3] = right.at[0] = look_at(right.begin);
  right.at[3] = whole.at[3];
  parts_[k] = left;
  parts_.insert(parts_.begin() + static_cast<std::ptrdiff_t>(k) + 1, right);
}

void EnergyBook::open_step(double t_end, const std::array<Instant, 3>& nodes, const Between& between) {
  t_end_ = t_end;
  h_ = t_end - t_;
  parts_.resize(1);
  parts_[0].begin = 0.0;
  parts_[0].length = 1.0;
  parts_[0].at[0] = account_.now;
  for (int i = 0; i < 3; ++i) parts_[0].at[i + 1] = eq_.energy(nodes[i].state, nodes[i].v_dot, *scratch_);
  if (!between) return;
  for (std::size_t k = 0; k < parts_.size();) {
    const Part& part = parts_[k];
    EnergyAccount then = account_;
    add(1.0, then);
    const double moved = std::max(then.gross_work, account_.peak);
    // A tenth: the errors of steps add up.
    const bool is_enough = unresolved(part) <= 0.1 * tolerance_ * moved || part.length <= kShortest ||
                           parts_.size() >= kMostParts;
    if (is_enough)
      ++k;
    else
      halve(k, between);
  }
}

void EnergyBook::add(double x, EnergyAccount& account) const {
  for (const Part& part : parts_) {
    if (x <= part.begin) break;
    const double share = std::min(1.0, (x - part.begin) / part.length);
    for (int i = 0; i < 4; ++i) {
      const double weight = h_ * part.length * integral_of_basis(i, share);
      account.work_in += weight * part.at[i].input_power;
      account.gross_work += weight * std::abs(part.at[i].input_power);
      account.dissipated += weight * part.at[i].dissipated_power;
    }
  }
}

bool EnergyBook::asks_multipliers(const State& s) {
  const int n_lambda = static_cast<int>(s.lambda.size());
  if (n_lambda == 0) return false;
  g_t_.resize(n_lambda);
  rest_.setZero(s.v.size());
  eq_.velocity_constraints(s, s.p, rest_, *scratch_, g_t_);
  return !g_t_.isZero(0.0);
}

EnergyAccount EnergyBook::at_row(const State& s, const Eigen::VectorXd& v_dot) {
  if (account_.round_off == 0.0) account_.round_off = round_off_energy(s, v_dot);
  EnergyAccount account = account_;
  if (h_ > 0.0) add((s.t - t_) / h_, account);
  look(eq_.energy(s, v_dot, *scratch_), account);
  account_.peak = account.peak;
  return account;
}

void EnergyBook::close_step() {
  if (h_ > 0.0) add(1.0, account_);
  look(parts_.back().at[3], account_);
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
