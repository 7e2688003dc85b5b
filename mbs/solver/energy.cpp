// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/energy.hpp"

#include <algorithm>
#include <cmath>

namespace flexura::mbs {

double EnergyAccount::relative_error() const {
  const double scale = std::max(gross_work, peak);
  return scale > 0.0 ? std::abs(error()) / scale : 0.0;
}

EnergyBook::EnergyBook(const Equations& eq) : eq_(eq), scratch_(eq.make_scratch()) {}

void EnergyBook::look(const State& s, const Eigen::VectorXd& v_dot) {
  account_.now = eq_.energy(s, v_dot, *scratch_);
  account_.peak =
      std::max({account_.peak, account_.now.kinetic, std::abs(account_.total() - account_.start)});
}

void EnergyBook::start(const State& s, const Eigen::VectorXd& v_dot) {
  account_ = {};
  account_.now = eq_.energy(s, v_dot, *scratch_);
  account_.start = account_.total();
  account_.peak = account_.now.kinetic;
  t_ = s.t;
  s_ = s;
  v_dot_ = v_dot;
}

void EnergyBook::resume(const EnergyAccount& account, const State& s, const Eigen::VectorXd& v_dot) {
  account_ = account;
  t_ = s.t;
  s_ = s;
  v_dot_ = v_dot;
}

void EnergyBook::advance(double t, Integrator& integrator, const State& s, const Eigen::VectorXd& v_dot) {
  // Lobatto's four points: the ends, which are evaluated anyway, and two between.
  static const double node[2] = {0.5 - std::sqrt(0.05), 0.5 + std::sqrt(0.05)};
  const double h = t - t_;
  const auto add = [&](const EnergyReport& e, double weight) {
    account_.work_in += weight * h * e.input_power;
    account_.gross_work += weight * h * std::abs(e.input_power);
    account_.dissipated += weight * h * e.dissipated_power;
  };
  if (h > 0.0) {
    add(account_.now, 1.0 / 12.0);
    for (const double x : node) {
      integrator.interpolate(t_ + x * h, s_, v_dot_);
      add(eq_.energy(s_, v_dot_, *scratch_), 5.0 / 12.0);
    }
  }
  look(s, v_dot);
  if (h > 0.0) add(account_.now, 1.0 / 12.0);
  t_ = t;
}

void EnergyBook::jump(const State& s, const Eigen::VectorXd& v_dot) {
  const double before = account_.total();
  look(s, v_dot);
  account_.dissipated += before - account_.total();
}

}  // namespace flexura::mbs
