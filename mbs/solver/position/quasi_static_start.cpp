// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/quasi_static_start.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/downhill.hpp"
#include "mbs/solver/algebra/saddle.hpp"

namespace flexura::mbs {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kMostIterations = 50, kMostDownhill = 300, kShortenings = 8;
/// Steps are told from round-off to 1e-13 of the deformation, or of this part of the scale of coordinates where there is none (a
/// wire under tension that is held at both ends).
constexpr double kNothing = 1e-3;

class QuasiStaticStart {
 public:
  /// Begins at the undeformed mechanism where its loops close without deformation.
  QuasiStaticStart(const Equations& eq, const AssembleOptions& keep, State& start)
      : eq_(eq), n_(eq.sizes()), scratch_(eq.make_scratch()), given_(keep), is_rigid_(n_.n_v, true) {
    given_.keep_position.resize(n_.n_v, false);
    given_.keep_velocity.resize(n_.n_v, false);
    held_ = given_;
    for (int i = 0; i < n_.n_v; ++i) {
      Elastic e{i, -1, 0.0};
      double damping = 0.0;
      if (!eq.elastic_coordinate(i, e.i_p, e.stiffness, damping)) continue;
      if (!(e.stiffness > 0.0)) coupled_.push_back(static_cast<int>(elastic_.size()));
      elastic_.push_back(e);
      is_rigid_[i] = false;
      held_.keep_position[i] = held_.keep_velocity[i] = true;
    }
    M_.setZero(n_.n_v, n_.n_v);
    G_.setZero(n_.n_lambda, n_.n_v);
    r_.setZero(n_.n_v);
    c_rate_.setZero(n_.n_dyn);
    b_.setZero(n_.n_alg);
    g_.setZero(n_.n_lambda);
    if (!has_elastic()) return;
    for (const Elastic& e : elastic_) start.v(e.i_v) = 0.0;
    split_rows(start);
    if (n_.n_lambda > 0) close_velocities(start);
  }

  bool has_elastic() const { return !elastic_.empty(); }

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
  /// Sets s' and makes all velocities consistent.
  void set_rates(State& s, const VectorXd& rates) {
    for (std::size_t k = 0; k < elastic_.size(); ++k) s.v(elastic_[k].i_v) = rates(k);
    close_velocities(s);
    AssembleReport report;
    assemble_velocities(eq_, s, given_, report);  // where N^T G v is left: round-off of the differences
  }

  /// Moves s to where the elastic rows balance.  Returns the number of iterations.
  int find(State& s) {
    const State start = s;
    if (!loads_change_)
      if (const int iterations = iterate(s)) return iterations;
    loads_change_ = true;
    s = start;
    if (const int iterations = iterate_downhill(s)) return iterations;
    throw AssemblyError(
        "the deformation that follows the loads is not found from the start given (the bodies are too soft "
        "for their loads, as a cable that is pushed along itself is, or vibrate with them): start undeformed "
        "(initial_deformation = \"none\")");
  }

 private:
  struct Elastic {
    int i_v, i_p;
    double stiffness;
  };

  /// Of the step, as parts of the scales of coordinates: its largest part, and what it is measured against.
  struct Change {
    double step = 0.0, size = kNothing;
  };
  Change change_of(const State& s) const {
    Change out;
    for (std::size_t k = 0; k < elastic_.size(); ++k) {
      const double scale = 1.0 / eq_.position_scale(elastic_[k].i_p);
      out.step = std::max(out.step, std::abs(step_(k)) * scale);
      out.size = std::max(out.size, std::abs(s.p(elastic_[k].i_p) + step_(k)) * scale);
    }
    return out;
  }

  void take_step(State& s, double part) {
    for (std::size_t k = 0; k < elastic_.size(); ++k) s.p(elastic_[k].i_p) += part * step_(k);
    close_positions(s);
    close_velocities(s);
  }

  // By the bodies' own stiffness; 0 where it does not converge.
  int iterate(State& s) {
    double before = std::numeric_limits<double>::infinity();
    for (int iteration = 1; iteration <= kMostIterations; ++iteration) {
      try {
        find_motion(s);
      } catch (const std::runtime_error&) {
        if (iteration == 1) throw;
        return 0;  // deformed beyond what its bodies are made for
      }
      find_step(s);
      if (!step_.allFinite()) return 0;  // nothing of the bodies themselves resists
      const Change change = change_of(s);
      take_step(s, 1.0);
      // Down to round-off, or where it stops to fall close to it.
      if (change.step <= 1e-13 * change.size ||
          (change.step > 0.5 * before && change.step <= 1e-9 * change.size))
        return iteration;
      if (iteration > 5 && change.step > before && change.step > 1e-9 * change.size) return 0;
      before = change.step;
    }
    return 0;
  }

  // By the stiffness that the loads have a part in, downhill (algebra/downhill.hpp); 0 where it does not converge.
  int iterate_downhill(State& s) {
    Stride stride;
    double before = std::numeric_limits<double>::infinity();
    find_motion(s);
    for (int iteration = 1; iteration <= kMostDownhill; ++iteration) {
      MatrixXd K = stiffness_with_loads(s);
      const auto n = static_cast<Eigen::Index>(elastic_.size());
      VectorXd unit(n), row_unit(N_.cols());
      MatrixXd C(N_.cols(), n);
      for (Eigen::Index k = 0; k < n; ++k) {
        unit(k) = column_scale_(elastic_[k].i_v);
        C.col(k) = N_.transpose() * G_.col(elastic_[k].i_v);
      }
      for (Eigen::Index k = 0; k < C.rows(); ++k) {
        const double norm = (C.row(k) * unit.asDiagonal()).norm();
        row_unit(k) = norm > 0.0 ? 1.0 / norm : 1.0;
      }
      constexpr double kFloor = 1e-6;  // of the shift, as where statics begin
      const double shift = downhill_shift(K, C, unit, row_unit, kFloor);
      K.diagonal() += shift * unit.cwiseAbs2().cwiseInverse();
      K_.compute(K);
      find_step(s);
      if (!step_.allFinite()) return 0;
      const Change change = change_of(s);
      double part = stride.part(change.step);
      const double slope = along_step();
      for (int k = 0;; ++k) {
        State tried = s;
        try {
          take_step(tried, part);
          find_motion(tried);
          if (k == kShortenings || change.step < 1e-6 || stride.stands(slope, along_step(), part)) {
            s = std::move(tried);
            break;
          }
        } catch (const std::runtime_error&) {
          if (k == kShortenings) return 0;
          part *= 0.25;
        }
      }
      if (shift == 0.0 && part == 1.0 &&
          (change.step <= 1e-13 * change.size ||
           (change.step > 0.5 * before && change.step <= 1e-9 * change.size)))
        return iteration;
      before = change.step;
    }
    return 0;
  }

  // The forces that the elastic rows lack, times the step.
  double along_step() const {
    double out = 0.0;
    for (std::size_t k = 0; k < elastic_.size(); ++k) out += r_(elastic_[k].i_v) * step_(k);
    return out;
  }

  // dr_s/ds at the present motion, by central differences: elastic, geometric and centrifugal stiffness.
  MatrixXd stiffness_with_loads(const State& s) {
    const auto n = static_cast<Eigen::Index>(elastic_.size());
    MatrixXd K(n, n);
    State moved = s;
    for (Eigen::Index j = 0; j < n; ++j) {
      const int at = elastic_[j].i_p;
      const double h = 1e-5 * eq_.position_scale(at);
      for (const double side : {h, -h}) {
        moved.p(at) = s.p(at) + side;
        eq_.momentum(moved, v_dot_, *scratch_, r_, c_rate_, b_);
        for (Eigen::Index i = 0; i < n; ++i)
          K(i, j) = (side > 0.0 ? 0.0 : K(i, j)) + r_(elastic_[i].i_v) / (2.0 * side);
      }
      moved.p(at) = s.p(at);
    }
    eq_.momentum(s, v_dot_, *scratch_, r_, c_rate_, b_);
    return K;
  }

  // U_ and N_, where the bodies are undeformed: there a row that the rigid motion leaves alone has no entry
  // but round-off in it, while a deformed axis would lend it one as small as the deformation.
  void split_rows(State& start) {
    const int n = n_.n_lambda;
    U_.setIdentity(n, n);
    N_.resize(n, 0);
    if (n == 0) return;
    State s = start;
    for (const Elastic& e : elastic_) s.p(e.i_p) = 0.0;
    try {
      assemble_positions(eq_, s, held_);
      start = s;
    } catch (const AssemblyError&) {
      s = start;  // a loop that only deformation closes
    }
    linearise(s);
    MatrixXd A = G_rigid();
    for (int k = 0; k < n; ++k) A.row(k) *= row_scale_(k);
    Eigen::ColPivHouseholderQR<MatrixXd> qr;
    // Rows have unit length over all coordinates; see SaddleSolver for the threshold.
    qr.setThreshold(1e-10);
    qr.compute(A);
    int rank = static_cast<int>(qr.rank());
    if (A.size() == 0 || qr.maxPivot() < 1e-10) rank = 0;
    if (rank == n) return;
    const MatrixXd Q = qr.householderQ() * MatrixXd::Identity(n, n);
    U_ = row_scale_.asDiagonal() * Q.leftCols(rank);
    N_ = row_scale_.asDiagonal() * Q.rightCols(n - rank);
  }

  void linearise(const State& s) {
    eq_.mass_matrix(s.p, *scratch_, M_);
    eq_.constraint_matrix(s, s.p, *scratch_, G_);
    column_scale_ = M_.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    row_scale_ = (G_ * column_scale_.asDiagonal()).rowwise().norm();
    for (double& x : row_scale_) x = x > 0.0 ? 1.0 / x : 1.0;
  }
  // The columns of G of rigid coordinates, in units of their inertia.
  MatrixXd G_rigid(const std::vector<bool>& held = {}) const {
    MatrixXd A = G_ * column_scale_.asDiagonal();
    for (int i = 0; i < n_.n_v; ++i)
      if (!is_rigid_[i] || (!held.empty() && held[i])) A.col(i).setZero();
    return A;
  }

  // Least motion of the rigid coordinates with U^T (g + G d) = 0, those held by the user only where it cannot
  // be done without them.
  VectorXd closing_motion(const std::vector<bool>& held, const VectorXd& g) const {
    const VectorXd g_U = -(U_.transpose() * g);
    VectorXd d;
    for (const bool hold : {true, false}) {
      const MatrixXd A = U_.transpose() * G_rigid(hold ? held : std::vector<bool>{});
      const VectorXd x = A.completeOrthogonalDecomposition().solve(g_U);
      d = column_scale_.cwiseProduct(x);
      if ((A * x - g_U).norm() <= 1e-6 * g_U.norm()) break;
    }
    return d;
  }

  void close_positions(State& s) {
    if (N_.cols() == 0) {
      assemble_positions(eq_, s, held_);
      return;
    }
    VectorXd p(n_.n_p);
    double before = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 10; ++k) {
      linearise(s);
      eq_.position_constraints(s, s.p, *scratch_, g_);
      const double size = (U_.transpose() * g_).norm();
      if (size == 0.0 || size > 0.5 * before) return;
      before = size;
      eq_.retract(s.p, closing_motion(given_.keep_position, g_), p);
      s.p = p;
    }
  }

  void close_velocities(State& s) {
    if (N_.cols() == 0) {
      AssembleReport report;
      assemble_velocities(eq_, s, held_, report);
      return;
    }
    linearise(s);
    for (int pass = 0; pass < 2; ++pass) {  // the second refines
      eq_.velocity_constraints(s, s.p, s.v, *scratch_, g_);
      s.v += closing_motion(given_.keep_velocity, g_);
    }
  }

  // v' and lambda of the motion with s'' = 0; r_ is then what the elastic rows lack.
  void find_motion(State& s) {
    linearise(s);
    const MatrixXd G_U = U_.transpose() * G_;
    saddle_.factor(eq_, M_, G_U, is_rigid_);
    v_dot_.setZero(n_.n_v);
    for (int pass = 0; pass < 3; ++pass) {
      eq_.momentum(s, v_dot_, *scratch_, r_, c_rate_, b_);
      if (pass == 2) return;
      eq_.acceleration_constraints(s, s.p, s.v, v_dot_, *scratch_, g_);
      const VectorXd r = -r_, h = -(U_.transpose() * g_);
      saddle_.solve(r, h, dv_, dlambda_);
      v_dot_ += dv_;
      s.lambda += U_ * dlambda_;
    }
  }

  // K ds + (N^T G_s)^T dnu = -r_s,  N^T (g + G_s ds) = 0,  lambda += N dnu.
  void find_step(State& s) {
    const auto n = static_cast<Eigen::Index>(elastic_.size());
    MatrixXd X(n, 1 + N_.cols());
    for (Eigen::Index k = 0; k < n; ++k) {
      X(k, 0) = -r_(elastic_[k].i_v);
      X.row(k).tail(N_.cols()) = G_.col(elastic_[k].i_v).transpose() * N_;
    }
    const MatrixXd C = X.rightCols(N_.cols()).transpose();
    divide_by_stiffness(s, X);
    step_ = X.col(0);
    if (N_.cols() == 0) return;
    eq_.position_constraints(s, s.p, *scratch_, g_);
    const MatrixXd F = C * X.rightCols(N_.cols());
    const VectorXd open = N_.transpose() * g_ + C * step_,
                   dnu = F.completeOrthogonalDecomposition().solve(open);
    step_ -= X.rightCols(N_.cols()) * dnu;
    s.lambda += N_ * dnu;
  }

  // X <- K^-1 X.
  void divide_by_stiffness(const State& s, MatrixXd& X) const {
    if (loads_change_) {
      X = K_.solve(X).eval();
      return;
    }
    for (std::size_t k = 0; k < elastic_.size(); ++k)
      if (elastic_[k].stiffness > 0.0) X.row(k) /= elastic_[k].stiffness;
    if (coupled_.empty()) return;
    MatrixXd r_p = MatrixXd::Zero(n_.n_v, n_.n_p), r_v = MatrixXd::Zero(n_.n_v, n_.n_v);
    eq_.add_elastic_tangents(s, r_p, r_v);
    const auto n = static_cast<Eigen::Index>(coupled_.size());
    MatrixXd K(n, n), x(n, X.cols());
    for (Eigen::Index i = 0; i < n; ++i) {
      x.row(i) = X.row(coupled_[i]);
      for (Eigen::Index j = 0; j < n; ++j)
        K(i, j) = r_p(elastic_[coupled_[i]].i_v, elastic_[coupled_[j]].i_p);
    }
    x = K.partialPivLu().solve(x).eval();
    for (Eigen::Index i = 0; i < n; ++i) X.row(coupled_[i]) = x.row(i);
  }

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  AssembleOptions given_, held_;  // what the user gave, and with the elastic coordinates
  std::vector<bool> is_rigid_;
  std::vector<Elastic> elastic_;
  std::vector<int> coupled_;   // among them: stiffness is a matrix
  bool loads_change_ = false;  // more with deformation than the bodies resist: K_ in place of their stiffness
  Eigen::PartialPivLU<MatrixXd> K_;
  // Combinations of the constraint rows that the rigid motion has to meet, and those that it always meets.
  MatrixXd U_, N_;
  SaddleSolver saddle_;
  MatrixXd M_, G_;
  VectorXd row_scale_, column_scale_;  // of G: 1 / length of the rows over 1 / sqrt(M_ii)
  VectorXd r_, c_rate_, b_, g_, v_dot_, dv_, dlambda_, step_;
};

}  // namespace

int start_quasi_static(const Equations& eq, State& s, VectorXd& v_dot, const AssembleOptions& keep) {
  QuasiStaticStart start(eq, keep, s);
  if (!start.has_elastic()) return 0;
  AccelerationSolver accelerations(eq);
  // Twice: the loads depend on the rates too, and these on the loads.
  int iterations = 0;
  for (int round = 0; round < 2; ++round) {
    iterations += start.find(s);
    const VectorXd a = start.v_dot();
    // Along the motion, a hundredth of a radian of the slowest vibration to either side.
    const double tau = 0.01 / start.lowest_frequency();
    VectorXd ends[2];
    for (int k = 0; k < 2; ++k) {
      State there = s;
      const double h = k == 0 ? -tau : tau;
      const VectorXd d = h * s.v + 0.5 * h * h * a;
      eq.retract(s.p, d, there.p);
      there.v += h * a;
      there.t += h;
      iterations += start.find(there);
      ends[k] = start.deformation(there);
    }
    start.set_rates(s, (ends[1] - ends[0]) / (2.0 * tau));
  }
  accelerations.solve(s, v_dot);
  return iterations;
}

}  // namespace flexura::mbs
