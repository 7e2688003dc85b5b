// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/alpha_matrix.hpp"

#include <cmath>

#include "mbs/solver/algebra/remembered.hpp"

namespace flexura::mbs {

AlphaCoefficients::AlphaCoefficients(double rho)
    : alpha_m((2.0 * rho - 1.0) / (rho + 1.0)), alpha_f(rho / (rho + 1.0)), delta(alpha_m - alpha_f) {
  gamma = 0.5 - delta;
  beta = 0.25 * (1.0 - delta) * (1.0 - delta);
  kappa = (1.0 - alpha_f) / (1.0 - alpha_m);
  error_p = beta + 0.5 * delta - 1.0 / 6.0;
  const double later = (1.0 + delta) * (1.0 + delta), now = delta * delta;
  const double e = 0.5 * ((1.0 - alpha_f) - (1.0 - alpha_m) * later - alpha_m * now);
  error_v = 0.5 * ((1.0 - gamma) * now + gamma * later) + e - 1.0 / 6.0;
}

AlphaMatrix::AlphaMatrix(const Equations& eq, const AlphaCoefficients& coefficients)
    : eq_(eq), n_(eq.sizes()), k_(coefficients), tangents_(eq) {
  const int n_x = n_.n_v + n_.n_dyn + n_.n_alg + n_.n_lambda;
  F_.setZero(n_x);
  row_scale_.setOnes(n_x);
  column_scale_.setOnes(n_x);
  J_.setZero(n_x, n_x);
  lu_ = Eigen::PartialPivLU<Eigen::MatrixXd>(n_x);
}

void AlphaMatrix::factor(double h, const State& s, const Eigen::VectorXd& v_dot) {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  const double by_v = k_.by_v(h), by_d = k_.by_d(h);
  if (!kinematics_) kinematics_ = std::make_unique<KinematicBlocks>(eq_, s.p);
  tangents_.evaluate(s, v_dot);
  ++factored_;
  const Tangents& t = tangents_;
  kinematics_->update(s.p, s.v);
  kinematics_->multiply_T(t.z_p, Z_q_);
  J_.setZero();
  J_.topLeftCorner(n_z, n_v) = by_v * t.z_v + by_d * Z_q_;
  J_.block(0, n_v, n_z, n_c) = by_v * t.z_c;
  J_.block(0, n_v + n_c, n_z, n_a) = t.z_a;
  if (t.c_v_dot.size() > 0) {
    J_.block(n_v, 0, n_c, n_v) += t.c_v_dot;
    J_.block(n_v, n_z, n_c, n_l) = t.c_lambda;
  }
  if (t.b_v_dot.size() > 0) {
    J_.block(n_v + n_c, 0, n_a, n_v) += t.b_v_dot;
    J_.block(n_v + n_c, n_z, n_a, n_l) = t.b_lambda;
  }
  J_.middleRows(n_v, n_c) *= -1.0;
  J_.topLeftCorner(n_v, n_v) += t.M;
  J_.block(n_v, n_v, n_c, n_c).diagonal().array() += 1.0;
  for (int i = 0; i < n_v; ++i)
    row_scale_(i) = column_scale_(i) = t.M(i, i) > 0.0 ? 1.0 / std::sqrt(t.M(i, i)) : 1.0;
  J_.block(0, n_z, n_v, n_l) = t.G.transpose();
  J_.block(n_z, 0, n_l, n_v) = t.G;
  for (int k = 0; k < n_l && t.g_c.size() > 0; ++k) {  // see GeneralisedAlpha::newton
    if (eq_.is_holonomic(k))
      J_.block(n_z + k, n_v, 1, n_c) = by_v / by_d * t.g_c.row(k);
    else
      J_.block(n_z + k, n_v, 1, n_c) = t.h_c.row(k);
  }
  for (int k = 0; k < n_l; ++k) {
    const double norm = (t.G.row(k).transpose().array() * column_scale_.head(n_v).array()).matrix().norm();
    row_scale_(n_z + k) = column_scale_(n_z + k) = norm > 0.0 ? 1.0 / norm : 1.0;
  }
  J_ = row_scale_.asDiagonal() * J_ * column_scale_.asDiagonal();
  // Redundant rows and dead points: see NewtonMatrix.
  for (int k = 0; k < n_l; ++k) J_(n_z + k, n_z + k) -= 1e-12;
  lu_.compute(J_);
  h_ = h;
  at_ = s;
  v_dot_ = v_dot;
}

void AlphaMatrix::solve(Eigen::VectorXd& F, Eigen::VectorXd& x) {
  F.array() *= row_scale_.array();
  x = lu_.solve(F);
  x.array() *= column_scale_.array();
}

void AlphaMatrix::filter(Eigen::VectorXd& e) {
  F_.setZero();
  F_.head(n_.n_v).noalias() = tangents_.M * e;
  solve(F_, x_);
  e = x_.head(n_.n_v);
}

void AlphaMatrix::remember(History& history) {
  history(h_);
  history(at_);
  history(v_dot_);
  if (!history.reads() || !(h_ > 0.0)) return;
  require_sizes(at_, n_);
  require_size(v_dot_.size(), n_.n_v);
  factor(h_, at_, v_dot_);
}

}  // namespace flexura::mbs
