// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/settle.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs/solver/accelerations.hpp"
#include "mbs/solver/saddle.hpp"

namespace flexura::mbs {

namespace {

using Eigen::VectorXd;

constexpr int kMostIterations = 50;

class Settler {
 public:
  Settler(const Equations& eq, const AssembleOptions& keep)
      : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()), options_(keep), is_rigid_(n_.n_v, true) {
    options_.keep_position.resize(n_.n_v, false);
    options_.keep_velocity.resize(n_.n_v, false);
    for (int i = 0; i < n_.n_v; ++i) {
      Elastic e{i, -1, 0.0};
      double damping = 0.0;
      if (!eq.elastic_coordinate(i, e.i_p, e.stiffness, damping)) continue;
      if (!(e.stiffness > 0.0)) coupled_.push_back(static_cast<int>(elastic_.size()));
      elastic_.push_back(e);
      is_rigid_[i] = false;
      options_.keep_position[i] = options_.keep_velocity[i] = true;
    }
    M_.setZero(n_.n_v, n_.n_v);
    G_.setZero(n_.n_lambda, n_.n_v);
    r_.setZero(n_.n_v);
    c_rate_.setZero(n_.n_dyn);
    b_.setZero(n_.n_alg);
    g_ddot_.setZero(n_.n_lambda);
  }

  bool has_elastic() const { return !elastic_.empty(); }
  const AssembleOptions& options() const { return options_; }

  /// The lowest frequency of a coordinate on its own [1/s].
  double lowest_frequency() const {
    double least = std::numeric_limits<double>::infinity();
    for (const Elastic& e : elastic_)
      if (e.stiffness > 0.0) least = std::min(least, std::sqrt(e.stiffness));
    return std::isfinite(least) ? least : 100.0;  // beams of coupled coordinates: of the order of bending
  }

  /// Of the last iteration, with s'' = 0.
  const VectorXd& v_dot() const { return v_dot_; }

  VectorXd deformation(const State& s) const {
    VectorXd out(elastic_.size());
    for (std::size_t k = 0; k < elastic_.size(); ++k) out(k) = s.p(elastic_[k].i_p);
    return out;
  }
  void set_rates(State& s, const VectorXd& rates) const {
    for (std::size_t k = 0; k < elastic_.size(); ++k) s.v(elastic_[k].i_v) = rates(k);
  }

  /// Moves s to where the elastic rows balance.
  int settle(State& s) {
    double before = std::numeric_limits<double>::infinity();
    for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
      find_motion(s);
      double change = 0.0, size = 0.0;
      step_.resize(elastic_.size());
      for (std::size_t k = 0; k < elastic_.size(); ++k)
        if (elastic_[k].stiffness > 0.0) step_(k) = -r_(elastic_[k].i_v) / elastic_[k].stiffness;
      solve_coupled(s);
      for (std::size_t k = 0; k < elastic_.size(); ++k) {
        const Elastic& e = elastic_[k];
        const double step = step_(k), scale = 1.0 / eq_.position_scale(e.i_p);
        s.p(e.i_p) += step;
        change = std::max(change, std::abs(step) * scale);
        size = std::max(size, std::abs(s.p(e.i_p)) * scale);
      }
      assemble_positions(eq_, s, options_);
      AssembleReport report;
      assemble_velocities(eq_, s, options_, report);
      // Down to round-off, or where it stops to fall close to it.
      if (change <= 1e-13 * size || (change > 0.5 * before && change <= 1e-9 * size)) return iteration;
      if (iteration > 5 && change > before && change > 1e-9 * size) break;
      before = change;
    }
    throw AssemblyError(
        "the deformation that follows the loads is not found from the start given (the bodies are too soft "
        "for their "
        "loads, or vibrate with them): start undeformed (initial_deformation = \"none\")");
  }

 private:
  struct Elastic {
    int i_v, i_p;
    double stiffness;
  };

  // Steps of the coordinates whose stiffness is a matrix.
  void solve_coupled(const State& s) {
    if (coupled_.empty()) return;
    Eigen::MatrixXd r_p = Eigen::MatrixXd::Zero(n_.n_v, n_.n_p), r_v = Eigen::MatrixXd::Zero(n_.n_v, n_.n_v);
    eq_.add_elastic_tangents(s, r_p, r_v);
    const auto n = static_cast<Eigen::Index>(coupled_.size());
    Eigen::MatrixXd K(n, n);
    VectorXd r(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Elastic& row = elastic_[coupled_[i]];
      r(i) = r_(row.i_v);
      for (Eigen::Index j = 0; j < n; ++j) K(i, j) = r_p(row.i_v, elastic_[coupled_[j]].i_p);
    }
    r = K.partialPivLu().solve(r).eval();
    for (Eigen::Index i = 0; i < n; ++i) step_(coupled_[i]) = -r(i);
  }

  // v' and lambda of the motion with s'' = 0; r_ is then what the elastic rows lack.
  void find_motion(State& s) {
    eq_.mass_matrix(s.p, *scratch_, M_);
    eq_.constraint_matrix(s.t, s.p, *scratch_, G_);
    saddle_.factor(eq_, M_, G_);
    const int rank = n_.n_lambda == 0 ? 0 : saddle_.rank();
    saddle_.factor(eq_, M_, G_, is_rigid_);
    if (n_.n_lambda > 0 && saddle_.rank() < rank)
      throw AssemblyError(
          "the loops of this mechanism close through the deformation of its bodies alone, which leaves no "
          "rigid "
          "motion to follow: start undeformed (initial_deformation = \"none\") or from the equilibrium "
          "(flexura "
          "statics)");
    v_dot_.setZero(n_.n_v);
    for (int pass = 0; pass < 3; ++pass) {
      eq_.momentum(s, v_dot_, *scratch_, r_, c_rate_, b_);
      if (pass == 2) return;
      eq_.acceleration_constraints(s.t, s.p, s.v, v_dot_, *scratch_, g_ddot_);
      const VectorXd r = -r_, h = -g_ddot_;
      saddle_.solve(r, h, dv_, dlambda_);
      v_dot_ += dv_;
      s.lambda += dlambda_;
    }
  }

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  AssembleOptions options_;
  std::vector<bool> is_rigid_;
  std::vector<Elastic> elastic_;
  std::vector<int> coupled_;  // among them
  SaddleSolver saddle_;
  Eigen::MatrixXd M_, G_;
  VectorXd r_, c_rate_, b_, g_ddot_, v_dot_, dv_, dlambda_, step_;
};

}  // namespace

int settle(const Equations& eq, State& s, VectorXd& v_dot, const AssembleOptions& keep) {
  Settler settler(eq, keep);
  if (!settler.has_elastic()) return 0;
  AccelerationSolver accelerations(eq);
  AssembleReport report;
  // Twice: the loads depend on the rates too, and these on the loads.
  int iterations = 0;
  for (int round = 0; round < 2; ++round) {
    iterations += settler.settle(s);
    const VectorXd a = settler.v_dot();
    // Along the motion, a hundredth of a radian of the slowest vibration to either side.
    const double tau = 0.01 / settler.lowest_frequency();
    VectorXd ends[2];
    for (int k = 0; k < 2; ++k) {
      State there = s;
      const double h = k == 0 ? -tau : tau;
      const VectorXd d = h * s.v + 0.5 * h * h * a;
      eq.retract(s.p, d, there.p);
      there.v += h * a;
      there.t += h;
      iterations += settler.settle(there);
      ends[k] = settler.deformation(there);
    }
    settler.set_rates(s, (ends[1] - ends[0]) / (2.0 * tau));
    assemble_velocities(eq, s, settler.options(), report);
  }
  accelerations.solve(s, v_dot);
  return iterations;
}

}  // namespace flexura::mbs
