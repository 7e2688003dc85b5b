// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/body_alone.hpp"

#include <algorithm>
#include <utility>

namespace flexura::study {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

BodyAlone::BodyAlone(const FullModel& full, const ModalBlock& block, MatrixXd S, MatrixXd extra_damping)
    : n_v_(full.mechanism().sizes().n_v),
      v_(block.v),
      m_(block.m),
      S_(std::move(S)),
      extra_damping_(std::move(extra_damping)) {
  std::vector<bool> modal(static_cast<std::size_t>(n_v_), false);
  for (const ModalBlock& other : full.blocks()) std::fill_n(modal.begin() + other.v, other.m, true);
  for (Index i = 0; i < n_v_; ++i)
    if (!modal[static_cast<std::size_t>(i)]) joint_.push_back(i);
}

void BodyAlone::project_matrix(const MatrixXd& full, MatrixXd& small) const {
  const auto n_joint = static_cast<Index>(joint_.size());
  MatrixXd beside(n_joint, m_), below(m_, n_joint);
  small.resize(n(), n());
  for (Index j = 0; j < n_joint; ++j) {
    const Index from = joint_[static_cast<std::size_t>(j)];
    below.col(j) = full.col(from).segment(v_, m_);
    beside.row(j) = full.row(from).segment(v_, m_);
    for (Index i = 0; i < n_joint; ++i) small(i, j) = full(joint_[static_cast<std::size_t>(i)], from);
  }
  small.topRightCorner(n_joint, S_.cols()).noalias() = beside * S_;
  small.bottomLeftCorner(S_.cols(), n_joint).noalias() = S_.transpose() * below;
  const MatrixXd right = full.block(v_, v_, m_, m_) * S_;
  small.bottomRightCorner(S_.cols(), S_.cols()).noalias() = S_.transpose() * right;
}

void BodyAlone::project(const LinearisedRow& row, LinearisedRow& small) const {
  project_matrix(row.M, small.M);
  project_matrix(row.D, small.D);
  project_matrix(row.K, small.K);
  project(row.C_p, small.C_p);
  project(row.C_v, small.C_v);
  MatrixXd transposed;
  project(row.Z_c.transpose(), transposed);
  small.Z_c = transposed.transpose();
  small.C_c = row.C_c;
  if (extra_damping_.size() > 0) small.D.bottomRightCorner(S_.cols(), S_.cols()) += extra_damping_;
  small.number = row.number;
}

void BodyAlone::project(const MatrixXd& G, MatrixXd& small) const {
  small.resize(G.rows(), n());
  for (std::size_t j = 0; j < joint_.size(); ++j) small.col(static_cast<Index>(j)) = G.col(joint_[j]);
  small.rightCols(S_.cols()).noalias() = G.middleCols(v_, m_) * S_;
}

VectorXd BodyAlone::load(const VectorXd& r) const {
  VectorXd out = VectorXd::Zero(n());
  out.tail(S_.cols()).noalias() = -(S_.transpose() * r.segment(v_, m_));
  return out;
}

VectorXd BodyAlone::gather(const VectorXd& x) const {
  VectorXd out(n());
  for (std::size_t j = 0; j < joint_.size(); ++j) out(static_cast<Index>(j)) = x(joint_[j]);
  out.tail(S_.cols()).noalias() = S_.transpose() * x.segment(v_, m_);
  return out;
}

VectorXd BodyAlone::spread(const VectorXd& x) const {
  VectorXd out = VectorXd::Zero(n_v_);
  for (std::size_t j = 0; j < joint_.size(); ++j) out(joint_[j]) = x(static_cast<Index>(j));
  out.segment(v_, m_).noalias() = S_ * x.tail(S_.cols());
  return out;
}

}  // namespace flexura::study
