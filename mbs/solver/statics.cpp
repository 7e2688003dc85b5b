// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/statics.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/assemble.hpp"
#include "mbs/solver/finite.hpp"
#include "mbs/solver/kinematic_blocks.hpp"
#include "mbs/solver/tangents.hpp"

namespace flexura::mbs {

namespace {

// The shift that makes K positive definite on the null space of G, in scaled coordinates; 0 where it is so
// already.
double needed_shift(const Eigen::MatrixXd& K_hat, const Eigen::MatrixXd& G_hat) {
  const auto n_v = K_hat.rows();
  if (n_v == 0) return 0.0;
  Eigen::MatrixXd N = Eigen::MatrixXd::Identity(n_v, n_v);
  if (G_hat.rows() > 0) {
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(G_hat.transpose());
    qr.setThreshold(1e-10);
    N = (qr.householderQ() * N).rightCols(n_v - qr.rank()).eval();
  }
  if (N.cols() == 0) return 0.0;
  const Eigen::MatrixXd H = N.transpose() * (0.5 * (K_hat + K_hat.transpose())) * N;
  const Eigen::VectorXd mu =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = mu.cwiseAbs().maxCoeff();
  if (mu(0) > 1e-10 * largest) return 0.0;
  // As stiff as the softest direction is unstable, and never below a part of the rest.
  return 2.0 * std::abs(mu(0)) + 1e-6 * largest;
}

}  // namespace

StaticsReport solve_statics(const Equations& eq, State& s, const StaticsOptions& options) {
  const Sizes n = eq.sizes();
  const int n_v = n.n_v, n_c = n.n_dyn, n_a = n.n_alg, n_l = n.n_lambda, n_z = n_v + n_c + n_a;
  assemble_positions(eq, s);
  s.v.setZero();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(n_v);
  auto scratch = eq.make_scratch();
  KinematicBlocks kinematics(eq, s.p);
  Tangents tangents(eq);
  Eigen::MatrixXd K, J(n_z + n_l, n_z + n_l);
  Eigen::VectorXd F(n_z + n_l), x, scale = Eigen::VectorXd::Ones(n_z + n_l), size_v(n_v), g(n_l);
  for (int i = 0; i < n_v; ++i) size_v(i) = eq.velocity_scale(i);
  StaticsReport report;

  auto residual = [&](const State& state, Eigen::VectorXd& out) {
    eq.momentum(state, rest, *scratch, out.head(n_v), out.segment(n_v, n_c), out.segment(n_v + n_c, n_a));
    if (n_l > 0) eq.position_constraints(state.t, state.p, *scratch, out.tail(n_l));
  };
  // Contacts close and open on the way, like every switch whose function falls below 0.
  Eigen::VectorXd switching = Eigen::VectorXd::Zero(n.n_root);
  const auto take_switches = [&] {
    if (n.n_root == 0) return;
    eq.roots(s, *scratch, switching);
    for (int k = 0; k < n.n_root; ++k)
      if (switching(k) < 0.0) eq.on_root(k, s, *scratch);
    s.v.setZero();  // an impact leaves nothing behind here
  };
  take_switches();
  // Without the multipliers' part: forces that no reaction carries, in the norm of M^-1.
  residual(s, F);
  require_finite_forces(eq, s.t, F.head(n_v), F.segment(n_v, n_c), F.segment(n_v + n_c, n_a));

  double extra = 0.0;  // more damping where the steps swing to and fro
  Eigen::VectorXd step_before = rest;
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    tangents.evaluate(s, rest);
    kinematics.update(s.p, s.v);
    kinematics.multiply_T(tangents.z_p, K);
    for (int i = 0; i < n_v; ++i) scale(i) = tangents.M(i, i) > 0.0 ? 1.0 / std::sqrt(tangents.M(i, i)) : 1.0;
    for (int k = 0; k < n_l; ++k) {
      const double norm = (tangents.G.row(k).transpose().array() * scale.head(n_v).array()).matrix().norm();
      scale(n_z + k) = norm > 0.0 ? 1.0 / norm : 1.0;
    }
    residual(s, F);
    double sigma = 0.0;
    if (options.stable) {
      sigma = needed_shift(scale.head(n_v).asDiagonal() * K.topRows(n_v) * scale.head(n_v).asDiagonal(),
                           scale.tail(n_l).asDiagonal() * tangents.G * scale.head(n_v).asDiagonal());
      // Where nothing is stiff: no step of more than a tenth of a typical size.
      if (n_v > 0 && sigma == 0.0 && K.topRows(n_v).isZero()) extra = std::max(extra, 1.0);
      sigma += extra;
    }
    J.setZero();
    J.topLeftCorner(n_z, n_v) = K;
    J.topLeftCorner(n_v, n_v) += sigma * tangents.M;
    J.block(0, n_v, n_z, n_c) = tangents.z_c;
    J.block(0, n_v + n_c, n_z, n_a) = tangents.z_a;
    J.block(0, n_z, n_v, n_l) = tangents.G.transpose();
    if (tangents.c_lambda.size() > 0) J.block(n_v, n_z, n_c, n_l) = tangents.c_lambda;
    J.block(n_z, 0, n_l, n_v) = tangents.G;
    J = scale.asDiagonal() * J * scale.asDiagonal();
    J.bottomRightCorner(n_l, n_l).diagonal().array() -= 1e-13;
    x = scale.cwiseProduct(J.partialPivLu().solve(-scale.cwiseProduct(F)));
    ++report.iterations;
    const double step = x.allFinite() ? x.head(n_v).cwiseQuotient(size_v).lpNorm<Eigen::Infinity>()
                                      : std::numeric_limits<double>::infinity();
    if (!(step < 1e6)) {
      extra = std::max(4.0 * extra, 1.0);
      continue;
    }
    // Half a typical size at a time, so that a swing does not turn into a somersault.
    const double alpha = step > 0.5 ? 0.5 / step : 1.0;
    State trial = s;
    eq.retract(s.p, alpha * x.head(n_v), trial.p);
    trial.c += alpha * x.segment(n_v, n_c);
    trial.a += alpha * x.segment(n_v + n_c, n_a);
    trial.lambda += alpha * x.tail(n_l);
    s = trial;
    take_switches();
    residual(s, F);
    require_finite_forces(eq, s.t, F.head(n_v), F.segment(n_v, n_c), F.segment(n_v + n_c, n_a));
    report.force_residual = F.head(n_v).lpNorm<Eigen::Infinity>();
    report.constraint_residual = n_l > 0 ? F.tail(n_l).cwiseAbs().maxCoeff() : 0.0;
    if (alpha == 1.0 && step < options.tolerance && extra < 1e-9 * (1.0 + K.lpNorm<Eigen::Infinity>()))
      return report;
    if (options.stable) {
      const bool swings = x.head(n_v).dot(step_before) < 0.0 && x.head(n_v).norm() > 0.5 * step_before.norm();
      extra = swings ? std::max(4.0 * extra, 0.1 * K.diagonal().lpNorm<Eigen::Infinity>() *
                                                 scale.head(n_v).cwiseAbs2().lpNorm<Eigen::Infinity>())
                     : (step < 1e-3 ? 1e-3 : 0.5) * extra;
    }
    step_before = x.head(n_v);
  }
  if (n_v == 0) throw std::runtime_error("no equilibrium found of a mechanism that cannot move");
  int worst = 0;
  F.head(n_v).cwiseAbs().maxCoeff(&worst);
  throw std::runtime_error(
      fmt::format("no equilibrium found in {} steps at t = {:.6g} s: on \"{}\" {:.4g} N (or N m) are left "
                  "unbalanced; something "
                  "may be free to run away: hold it by a joint or a spring",
                  report.iterations, s.t, eq.name_of_velocity(worst), F(worst)));
}

}  // namespace flexura::mbs
