// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/study/estimate/full_model.hpp"

namespace flexura::study {

/// The linear correction of a full model in some deformations of one body alone, the other bodies rigid.
///
/// Its n coordinates are the n_joint of the full model that are no mode of any body, then those of the columns of S:
/// delta_full = [delta_joint; S delta_S].  Matrices are projected block by block, since all of the full model's times a
/// basis of its size was most of what screening five bodies took.
class BodyAlone {
 public:
  /// S: m x k, deformations of the block by its free modes; `extra_damping` [1/s] of them (k x k), beside the body's; empty: none.
  BodyAlone(const FullModel& full, const ModalBlock& block, Eigen::MatrixXd S, Eigen::MatrixXd extra_damping);

  Eigen::Index n() const { return static_cast<Eigen::Index>(joint_.size()) + S_.cols(); }

  /// M, D and K of the row (n_v x n_v), n x n, and what its states are beside them; not its G.
  void project(const LinearisedRow& row, LinearisedRow& small) const;
  /// G (n_lambda x n_v), n_lambda x n.
  void project(const Eigen::MatrixXd& G, Eigen::MatrixXd& small) const;
  /// What drives the body's own deformations of minus the residual r (n_v), the load that they are not there to feel (n).
  Eigen::VectorXd load(const Eigen::VectorXd& r) const;
  /// The transpose of spread(): x (n_v) on the coordinates here (n).
  Eigen::VectorXd gather(const Eigen::VectorXd& x) const;
  /// x (n) in the full model (n_v).
  Eigen::VectorXd spread(const Eigen::VectorXd& x) const;

 private:
  void project_matrix(const Eigen::MatrixXd& full, Eigen::MatrixXd& small) const;

  std::vector<Eigen::Index> joint_;  // coordinates in v
  Eigen::Index n_v_, v_, m_;
  Eigen::MatrixXd S_, extra_damping_;
};

}  // namespace flexura::study
