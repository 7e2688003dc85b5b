// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/newton_matrix.hpp"

#include <Eigen/LU>
#include <cmath>
#include <complex>

#include "mbs/solver/small_lu.hpp"

namespace flexura::mbs {

template <class Scalar>
void KinematicInverse<Scalar>::compute(const KinematicBlocks& blocks, Scalar c) {
  blocks_ = &blocks;
  n_v_ = 0;
  for (const KinematicBlocks::Block& b : blocks.blocks()) n_v_ += static_cast<int>(b.v.size());
  inverse_.resize(blocks.blocks().size());
  using Small = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, 0, 8, 8>;
  for (std::size_t k = 0; k < inverse_.size(); ++k) {
    const KinematicBlocks::Block& b = blocks.blocks()[k];
    Block& out = inverse_[k];
    if (b.p.size() == 1 && b.v.size() == 1) {
      out.E.setConstant(1, 1, 1.0 / (c - b.A(0, 0)));
      out.ET.setConstant(1, 1, out.E(0, 0) * b.T(0, 0));
      out.TET = out.E;
      continue;
    }
    Small D = (-b.A).template cast<Scalar>();
    D.diagonal().array() += c;
    out.E = Small(D.inverse());
    out.ET.noalias() = out.E * b.T;
    if (!b.v.empty()) out.TET.noalias() = b.T_inverse * out.ET;
  }
}

template <class Scalar>
void KinematicInverse<Scalar>::multiply_TET(const Eigen::MatrixXd& Z_v, Matrix& Z) const {
  Z.setZero(Z_v.rows(), n_v_);
  for (std::size_t k = 0; k < inverse_.size(); ++k) {
    const std::vector<int>& v = blocks_->blocks()[k].v;
    for (std::size_t j = 0; j < v.size(); ++j)
      for (std::size_t i = 0; i < v.size(); ++i) Z.col(v[j]) += inverse_[k].TET(i, j) * Z_v.col(v[i]);
  }
}

template <class Scalar>
void KinematicInverse<Scalar>::multiply_ET(const Eigen::MatrixXd& Z_p, Matrix& Z) const {
  Z.setZero(Z_p.rows(), n_v_);
  for (std::size_t k = 0; k < inverse_.size(); ++k) {
    const KinematicBlocks::Block& b = blocks_->blocks()[k];
    for (std::size_t j = 0; j < b.v.size(); ++j)
      for (std::size_t i = 0; i < b.p.size(); ++i) Z.col(b.v[j]) += inverse_[k].ET(i, j) * Z_p.col(b.p[i]);
  }
}

template <class Scalar>
void KinematicInverse<Scalar>::apply_E(const Vector& y, Vector& x) const {
  for (std::size_t k = 0; k < inverse_.size(); ++k) {
    const std::vector<int>& p = blocks_->blocks()[k].p;
    for (std::size_t i = 0; i < p.size(); ++i) {
      Scalar sum = 0.0;
      for (std::size_t j = 0; j < p.size(); ++j) sum += inverse_[k].E(i, j) * y(p[j]);
      x(p[i]) = sum;
    }
  }
}

template <class Scalar>
void KinematicInverse<Scalar>::add_ET(const Vector& w, Vector& x) const {
  for (std::size_t k = 0; k < inverse_.size(); ++k) {
    const KinematicBlocks::Block& b = blocks_->blocks()[k];
    for (std::size_t i = 0; i < b.p.size(); ++i)
      for (std::size_t j = 0; j < b.v.size(); ++j) x(b.p[i]) += inverse_[k].ET(i, j) * w(b.v[j]);
  }
}

template <class Scalar>
void KinematicInverse<Scalar>::apply_T_inverse(const Vector& y, Vector& w) const {
  for (const KinematicBlocks::Block& b : blocks_->blocks())
    for (std::size_t i = 0; i < b.v.size(); ++i) {
      Scalar sum = 0.0;
      for (std::size_t j = 0; j < b.p.size(); ++j) sum += b.T_inverse(i, j) * y(b.p[j]);
      w(b.v[i]) = sum;
    }
}

template class KinematicInverse<double>;
template class KinematicInverse<std::complex<double>>;

template <class Scalar>
struct NewtonMatrix<Scalar>::Factor {
  SmallLu<Scalar> lu;
};

template <class Scalar>
NewtonMatrix<Scalar>::NewtonMatrix(const Sizes& sizes, std::vector<bool> holonomic)
    : n_(sizes), holonomic_(std::move(holonomic)), factor_(std::make_unique<Factor>()) {
  const int n_z = n_.n_v + n_.n_dyn + n_.n_alg, n_x = n_z + 2 * n_.n_lambda;
  row_scale_.setOnes(n_x);
  column_scale_.setOnes(n_x);
  J_.setZero(n_x, n_x);
  GS_.setZero(n_.n_v, n_.n_lambda);
  rhs_.setZero(n_x);
  y_p_.setZero(n_.n_p);
  dp_.setZero(n_.n_p);
  dp_0_.setZero(n_.n_p);
  w_.setZero(n_.n_v);
  z_.setZero(n_z);
}

template <class Scalar>
NewtonMatrix<Scalar>::~NewtonMatrix() = default;

template <class Scalar>
bool NewtonMatrix<Scalar>::factor(const Tangents& d, const KinematicBlocks& kinematics,
                                  const Eigen::VectorXd& S, Scalar cj) {
  const int n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda, n_z = n_v + n_c + n_a;
  inverse_.compute(kinematics, cj);
  inverse_.multiply_ET(d.z_p, z_v_);

  // Momentum rows are divided by |cj| and the multipliers carry it, position rows are multiplied by it: all
  // blocks are then of the size of M and G.
  const double size = std::abs(cj);
  for (int i = 0; i < n_v; ++i) {
    const double scale = d.M(i, i) > 0.0 ? 1.0 / std::sqrt(d.M(i, i)) : 1.0;
    row_scale_(i) = scale / size;
    column_scale_(i) = scale;
  }
  row_scale_.segment(n_v, n_c).setConstant(1.0 / size);
  column_scale_.segment(n_v, n_c).setOnes();
  row_scale_.segment(n_v + n_c, n_a).setOnes();
  column_scale_.segment(n_v + n_c, n_a).setOnes();

  J_.setZero();
  J_.topLeftCorner(n_z, n_v) = z_v_ + d.z_v.template cast<Scalar>();
  J_.topLeftCorner(n_v, n_v) += cj * d.M.template cast<Scalar>();
  J_.block(0, n_v, n_z, n_c) = d.z_c.template cast<Scalar>();
  J_.block(0, n_v + n_c, n_z, n_a) = d.z_a.template cast<Scalar>();
  // The dynamic states' residual is c' - f_c.
  J_.block(n_v, 0, n_c, n_z) *= -1.0;
  J_.block(n_v, n_v, n_c, n_c).diagonal().array() += cj;

  if (n_l > 0) {
    inverse_.multiply_ET(d.h_p, h_v_);
    inverse_.multiply_TET(d.G, g_v_);
    GS_ = (S.asDiagonal() * d.G.transpose()).template cast<Scalar>();
    const int at_l = n_z, at_m = n_z + n_l;
    J_.block(0, at_l, n_v, n_l) = d.G.transpose().template cast<Scalar>();
    J_.block(0, at_m, n_z, n_l).noalias() = z_v_ * GS_;
    J_.block(n_v, at_m, n_c, n_l) *= -1.0;
    J_.block(at_l, 0, n_l, n_v) = d.G.template cast<Scalar>() + h_v_;
    J_.block(at_l, at_m, n_l, n_l).noalias() = h_v_ * GS_;
    J_.block(at_m, 0, n_l, n_v) = g_v_;
    J_.block(at_m, at_m, n_l, n_l).noalias() = g_v_ * GS_;
    for (int k = 0; k < n_l; ++k) {
      const double norm = (d.G.row(k).transpose().array() * column_scale_.head(n_v).array()).matrix().norm();
      const double scale = norm > 0.0 ? 1.0 / norm : 1.0;
      row_scale_(at_l + k) = scale;
      column_scale_(at_l + k) = scale * size;
      row_scale_(at_m + k) = scale * size;
      column_scale_(at_m + k) = scale;
      if (!holonomic_[k]) {
        J_.row(at_m + k).setZero();
        J_(at_m + k, at_m + k) = 1.0;
        row_scale_(at_m + k) = column_scale_(at_m + k) = 1.0;
      }
    }
  }
  for (Eigen::Index j = 0; j < J_.cols(); ++j) J_.col(j).array() *= row_scale_.array() * column_scale_(j);
  // Where rows of G depend on each other (redundant, or at a dead point) the blocks of the multipliers are
  // singular; 1e-12 of their scale keeps the factors finite and is far below Newton's need elsewhere.
  for (int k = 0; k < n_l; ++k) {
    J_(n_z + k, n_z + k) -= 1e-12;
    J_(n_z + n_l + k, n_z + n_l + k) += 1e-12;
  }
  if (!J_.allFinite()) return false;
  factor_->lu.compute(J_);
  return true;
}

template <class Scalar>
void NewtonMatrix<Scalar>::solve(const Tangents& d, const Vector& rhs, Vector& x) {
  const int n_p = n_.n_p, n_v = n_.n_v, n_c = n_.n_dyn, n_a = n_.n_alg, n_l = n_.n_lambda,
            n_z = n_v + n_c + n_a;
  // Positions: dp = E (r_p + T (dv + S G^T dmu)); what E r_p does to the other rows goes to the right.
  y_p_ = rhs.head(n_p);
  inverse_.apply_E(y_p_, dp_0_);
  z_.noalias() = d.z_p * dp_0_;
  rhs_.head(n_z) = rhs.segment(n_p, n_z);
  rhs_.head(n_v) -= z_.head(n_v);
  rhs_.segment(n_v, n_c) += z_.segment(n_v, n_c);
  rhs_.segment(n_v + n_c, n_a) -= z_.tail(n_a);
  if (n_l > 0) {
    rhs_.segment(n_z, n_l) = rhs.segment(n_p + n_z, n_l);
    rhs_.segment(n_z, n_l).noalias() -= d.h_p * dp_0_;
    rhs_.tail(n_l) = rhs.tail(n_l);
    inverse_.apply_T_inverse(dp_0_, w_);
    for (int k = 0; k < n_l; ++k)
      if (holonomic_[k])
        rhs_(n_z + n_l + k) -= d.G.row(k).transpose().template cast<Scalar>().cwiseProduct(w_).sum();
  }
  rhs_.array() *= row_scale_.array();
  factor_->lu.solve_in_place(rhs_);
  rhs_.array() *= column_scale_.array();
  w_ = rhs_.head(n_v);
  if (n_l > 0) w_.noalias() += GS_ * rhs_.tail(n_l);
  dp_ = dp_0_;
  inverse_.add_ET(w_, dp_);
  x.resize(rhs.size());
  x.head(n_p) = dp_;
  x.segment(n_p, n_z) = rhs_.head(n_z);
  x.tail(2 * n_l) = rhs_.tail(2 * n_l);
}

template class NewtonMatrix<double>;
template class NewtonMatrix<std::complex<double>>;

}  // namespace flexura::mbs
