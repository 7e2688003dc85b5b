// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/start/following_start.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/position/assemble.hpp"

namespace flexura::mbs {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class Followers {
 public:
  Followers(const Mechanism& m, const State& s) : m_(m), scratch_(m.make_scratch()) {
    const Sizes n = m.sizes();
    r_.setZero(n.n_v);
    c_rate_.setZero(n.n_dyn);
    b_.setZero(n.n_alg);
    for (int b = 0; b < static_cast<int>(m.description().bodies.size()); ++b) {
      const FlexibleBody* const body = m.deforming(b);
      if (!body || body->acts_back()) continue;
      const Index first = m.modal_coordinates(b, s) - s.c.data();
      for (Index i = 0; i < body->m(); ++i) {
        at_.push_back(first + i);
        rate_at_.push_back(first + body->m() + i);
        if (const double k = body->spring(static_cast<int>(i)).stiffness; k > 0.0)
          lowest_ = std::min(lowest_, std::sqrt(k));
      }
    }
  }

  bool any() const { return !at_.empty(); }
  double lowest_frequency() const { return std::isfinite(lowest_) ? lowest_ : 100.0; }
  VectorXd deformation(const State& s) const { return s.c(at_); }

  // s'' = 0, which is linear in the coordinates: one step and one that takes round-off away.
  void settle(State& s, const VectorXd& v_dot) {
    const auto n = static_cast<Index>(at_.size());
    MatrixXd K(n, n);
    for (Index j = 0; j < n; ++j) {
      const double here = s.c(at_[static_cast<std::size_t>(j)]);
      VectorXd ends[2];
      for (const int side : {0, 1}) {
        s.c(at_[static_cast<std::size_t>(j)]) = here + (side == 0 ? 1.0 : -1.0);
        ends[side] = accelerations(s, v_dot);
      }
      s.c(at_[static_cast<std::size_t>(j)]) = here;
      K.col(j) = 0.5 * (ends[0] - ends[1]);
    }
    const Eigen::PartialPivLU<MatrixXd> solver(K);
    for (int pass = 0; pass < 2; ++pass) s.c(at_) -= solver.solve(accelerations(s, v_dot));
  }

  void set_rates(State& s, const VectorXd& rates) const { s.c(rate_at_) = rates; }

 private:
  VectorXd accelerations(const State& s, const VectorXd& v_dot) {
    m_.momentum(s, v_dot, *scratch_, r_, c_rate_, b_);
    return c_rate_(rate_at_);
  }

  const Mechanism& m_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::vector<Index> at_, rate_at_;  // in c: coordinates and their rates
  double lowest_ = std::numeric_limits<double>::infinity();
  VectorXd r_, c_rate_, b_;
};

}  // namespace

void start_following(const Mechanism& m, State& s, const VectorXd& v_dot) {
  Followers followers(m, s);
  if (!followers.any()) return;
  AccelerationSolver solver(m);
  // Twice: the loads depend on the rates too.
  for (int round = 0; round < 2; ++round) {
    followers.settle(s, v_dot);
    // Along the motion, a hundredth of a radian of the slowest vibration to either side.
    const double tau = 0.01 / followers.lowest_frequency();
    VectorXd ends[2];
    for (const int k : {0, 1}) {
      State there = s;
      const double h = k == 0 ? -tau : tau;
      const VectorXd d = h * s.v + 0.5 * h * h * v_dot;
      m.retract(s.p, d, there.p);
      there.v += h * v_dot;
      there.t += h;
      assemble_positions(m, there);
      AssembleReport report;
      assemble_velocities(m, there, {}, report);
      VectorXd a = v_dot;
      solver.solve(there, a);
      followers.settle(there, a);
      ends[k] = followers.deformation(there);
    }
    followers.set_rates(s, (ends[1] - ends[0]) / (2.0 * tau));
  }
}

}  // namespace flexura::mbs
