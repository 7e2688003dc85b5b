// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/without_loads.hpp"

#include <algorithm>
#include <cmath>

namespace flexura::mbs {
namespace {

/// What an element puts on markers, coordinates and modes, as numbers in one order.
class Recorded final : public Loads {
 public:
  explicit Recorded(const Kinematics& kin) : kin_(kin) {}
  using Loads::apply;
  void apply(int marker, const Spatial& wrench_W) override {
    const Matrix3d R_PW = kin_.markers[marker].X_WP.R.transpose();
    add(in_W, wrench_W);
    add(in_P, R_PW * wrench_W);
  }
  void apply(CoordinateRef, double force) override {
    in_W.push_back(force);
    in_P.push_back(force);
  }
  void apply_modal(int, const Eigen::VectorXd& f, double factor) override {
    for (const double x : f) {
      in_W.push_back(factor * x);
      in_P.push_back(factor * x);
    }
  }

  std::vector<double> in_W, in_P;  ///< wrenches in the world's axes and in their markers'

 private:
  static void add(std::vector<double>& to, const Spatial& wrench) {
    const Vector6d w = wrench.vector();
    to.insert(to.end(), w.begin(), w.end());
  }
  const Kinematics& kin_;
};

double largest(const std::vector<double>& x) {
  double out = 0.0;
  for (const double one : x) out = std::max(out, std::abs(one));
  return out;
}

bool same(const std::vector<double>& x, const std::vector<double>& y) {
  if (x.size() != y.size()) return false;
  // Some hundred roundings of what was computed twice.
  const double bound = 1e-12 * std::max(largest(x), largest(y));
  for (std::size_t i = 0; i < x.size(); ++i)
    if (!(std::abs(x[i] - y[i]) <= bound)) return false;
  return true;
}

/// What force `force` does in a state.
Recorded recorded(const MechanismParts& m, const Residual& residual, std::size_t force, const State& s,
                  MechanismScratch& work) {
  residual.move_and_observe(s, work);
  Recorded loads(work.motion.kin);
  m.states.own_states(force, work.motion, work.signals);
  m.tree.d.forces[force]->apply(work.motion.kin, work.signals.values.data(), loads);
  return loads;
}

/// What force `force` is, judged by what it does in the state and in two others near by, which differ from it in every
/// position, speed and dynamic state: a force that is the same there, in the world's axes or in those of its markers,
/// is a load; one that does not act is a response.
ForceNature nature_by_trial(const MechanismParts& m, const Residual& residual, std::size_t force,
                            const State& s, MechanismScratch& work) {
  const auto act = [&](const State& at) {
    const Recorded loads = recorded(m, residual, force, at, work);
    return std::pair(loads.in_W, loads.in_P);
  };
  const auto here = act(s);
  bool in_W = true, in_P = true;
  double elsewhere = 0.0;
  for (int trial = 0; trial < 2; ++trial) {
    // Numbers without a pattern: parts of the golden ratio's multiples.
    int count = 0;
    const auto next = [&] {
      const double x = 0.6180339887498949 * ++count + 0.3 * trial;
      return 1e-3 * (x - std::floor(x) - 0.5);
    };
    State moved = s;
    Eigen::VectorXd d(m.tree.n_v);
    for (int i = 0; i < m.tree.n_v; ++i) {
      const double scale = m.coordinates.velocity_scale(i);
      d(i) = next() * scale;
      moved.v(i) += next() * scale;
    }
    m.coordinates.retract(s.p, d, moved.p);
    for (double& c : moved.c) c += next() * std::max(1.0, std::abs(c));
    const auto there = act(moved);
    in_W = in_W && same(here.first, there.first);
    in_P = in_P && same(here.second, there.second);
    elsewhere = std::max(elsewhere, largest(there.first));
  }
  if (largest(here.first) <= 1e-9 * elsewhere) return ForceNature::response;
  return in_W || in_P ? ForceNature::load : ForceNature::unknown;
}

}  // namespace

Unloaded without_loads(const MechanismParts& m, const Residual& residual, const State& s,
                       MechanismScratch& work) {
  const MechanismDescription& d = m.tree.d;
  Unloaded out{d, {}, {}};
  if (!d.gravity.isZero(0.0)) out.loads.push_back("weight");
  out.description.gravity.setZero();
  out.description.forces.clear();
  for (std::size_t i = 0; i < d.forces.size(); ++i) {
    const ForceElement& force = *d.forces[i];
    ForceNature nature = force.nature();
    const bool says = nature != ForceNature::unknown;
    if (!says) nature = nature_by_trial(m, residual, i, s, work);
    if (nature == ForceNature::unknown) out.unknown.push_back(force.name());
    if (nature != ForceNature::load) {
      out.description.forces.push_back(d.forces[i]);
      continue;
    }
    out.loads.push_back(force.name());
    if (!says) continue;  // the whole of it is a load
    residual.move_and_observe(s, work);
    m.states.own_states(i, work.motion, work.signals);
    if (auto rest = force.without_load(work.motion.kin, work.signals.values.data()))
      out.description.forces.push_back(std::move(rest));
  }
  return out;
}

std::vector<double> sizes_of_forces(const MechanismParts& m, const Residual& residual, const State& s,
                                    MechanismScratch& work) {
  std::vector<double> out;
  for (std::size_t i = 0; i < m.tree.d.forces.size(); ++i)
    out.push_back(largest(recorded(m, residual, i, s, work).in_W));
  return out;
}

}  // namespace flexura::mbs
