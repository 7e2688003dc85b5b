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

void EnergyBook::advance(double t, Integrator& integrator, const State& s, const Eigen::VectorXd& v_dot) {
  static const double node[3] = {0.5 - std::sqrt(0.15), 0.5, 0.5 + std::sqrt(0.15)};
  static constexpr double weight[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  const double h = t - t_;
  if (h > 0.0) {
    for (int k = 0; k < 3; ++k) {
      integrator.interpolate(t_ + node[k] * h, s_, v_dot_);
      const EnergyReport e = eq_.energy(s_, v_dot_, *scratch_);
      account_.work_in += weight[k] * h * e.input_power;
      account_.gross_work += weight[k] * h * std::abs(e.input_power);
      account_.dissipated += weight[k] * h * e.dissipated_power;
    }
  }
  t_ = t;
  look(s, v_dot);
}

void EnergyBook::jump(const State& s, const Eigen::VectorXd& v_dot) {
  const double before = account_.total();
  look(s, v_dot);
  account_.dissipated += before - account_.total();
}

}  // namespace flexura::mbs
