// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/statics/late_loads.hpp"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <vector>

namespace flexura::mbs {
namespace {

/// Looks over the time of the run; a pulse shorter than the time between two may be missed.
constexpr int kLooks = 100;
/// What round-off leaves of a load that begins at zero (that of 100 N cos(t) at pi / 2).
constexpr double kRoundOff = 1e-12;
/// Beyond so many states (of bodies that deform one-way) they stay as they are.
constexpr int kMostStates = 200;

/// Dynamic states where they come to rest if time stands still: what an actuator or a filter has built up. Those that find no
/// rest, like integrators, stay.
class SettledStates {
 public:
  SettledStates(const Mechanism& mechanism, const State& s) : mechanism_(mechanism), n_(mechanism.sizes()) {
    scratch_ = mechanism.make_scratch();
    if (n_.n_dyn == 0 || n_.n_dyn > kMostStates) return;
    State moved = s;
    const Eigen::VectorXd rest = rates(s);
    Eigen::MatrixXd J(n_.n_dyn, n_.n_dyn);
    for (int j = 0; j < n_.n_dyn; ++j) {
      const double step = 1e-3 * std::max(1.0, std::abs(s.c(j)));
      moved.c(j) += step;
      J.col(j) = (rates(moved) - rest) / step;
      moved.c(j) = s.c(j);
    }
    if (J.allFinite()) inverse_.compute(J);
  }
  void settle(State& s) {
    if (inverse_.rows() == 0) return;
    for (int pass = 0; pass < 3; ++pass) {  // one where rates are linear in the states
      const Eigen::VectorXd step = inverse_.solve(rates(s));
      if (!step.allFinite()) return;
      s.c -= step;
    }
  }

 private:
  Eigen::VectorXd rates(const State& s) {
    Eigen::VectorXd r = Eigen::VectorXd::Zero(n_.n_v), c = Eigen::VectorXd::Zero(n_.n_dyn),
                    b = Eigen::VectorXd::Zero(s.a.size());
    mechanism_.momentum(s, Eigen::VectorXd::Zero(n_.n_v), *scratch_, r, c, b);
    return c;
  }
  const Mechanism& mechanism_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse_;
};

}  // namespace

std::string late_loads(const Mechanism& mechanism, const State& s, double end_time) {
  if (mechanism.functions_of_time().empty() || !(end_time > s.t)) return {};
  const auto scratch = mechanism.make_scratch();
  const auto& forces = mechanism.description().forces;
  const std::vector<double> now = mechanism.sizes_of_forces(s, *scratch);
  std::vector<double> largest = now, time(now.size(), s.t);
  State later = s;
  SettledStates states(mechanism, s);
  for (int k = 1; k <= kLooks; ++k) {
    later.t = s.t + (end_time - s.t) * k / kLooks;
    states.settle(later);
    const std::vector<double> then = mechanism.sizes_of_forces(later, *scratch);
    for (std::size_t i = 0; i < then.size(); ++i)
      if (std::isfinite(then[i]) && then[i] > largest[i] * (1.0 + 1e-9))
        largest[i] = then[i], time[i] = later.t;
  }
  std::string names;
  int count = 0;
  double when = s.t, most = 0.0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    if (!(largest[i] > 0.0) || now[i] > kRoundOff * largest[i]) continue;
    // A message is read, not studied.
    if (++count <= 4) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", forces[i]->name());
    if (largest[i] > most) most = largest[i], when = time[i];
  }
  if (count == 0) return {};
  return fmt::format(
      "the force{} {}{} {} nothing at t = {:.6g} s, the instant that is looked at, and so {} no part in the "
      "factors; look at "
      "another with --set solver.start_time={:.6g}, where {} largest, or give a constant load",
      count == 1 ? "" : "s", names, count > 4 ? fmt::format(" and {} more", count - 4) : "",
      count == 1 ? "is" : "are", s.t, count == 1 ? "has" : "have", when,
      count == 1 ? "it is" : "the greatest of them is");
}

}  // namespace flexura::mbs
