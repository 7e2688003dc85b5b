// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/kinematic_inverse.hpp"

#include <Eigen/LU>
#include <complex>

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

}  // namespace flexura::mbs
