// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "mbs/study/choice/body_alone.hpp"
#include "mbs/study/estimate/full_model.hpp"
#include "mbs/study/estimate/linear_correction.hpp"

namespace flexura::study {

/// A row of the run with rigid bodies, in the full model.
struct ScreenedRow {
  mbs::State s;
  Eigen::VectorXd v_dot, residual;
  Eigen::MatrixXd G;
  Eigen::VectorXd corrected;  ///< outputs with every deformation of every body
  std::shared_ptr<const LinearisedRow> linearised;
  bool jumped = false;   ///< a load has, since the row before
  bool is_look = false;  ///< between rows, see Shadows::ask_for_looks
};

/// The linear correction in the deformations S of one body (n_block x k) while the others are rigid, row by row and no
/// further than it is asked.  Rows, full model and outputs outlive it.
class Follower {
 public:
  /// Of the rows one in `every`; `extra_damping` [1/s] (k x k or empty) of the columns of S beside the superelement's own.
  /// `transients` are those of all of the body's deformations, whatever S has of them: between rows all steps are then alike,
  /// and what they cost cancels where two are compared (at a resonance it is more than the modes left out).  `next_order`: with
  /// what the first order leaves of the equations, as shadows follow it.
  Follower(FullModel& full, const std::vector<ScreenedRow>& rows, std::size_t every,
           const std::vector<int>& outputs, const ModalBlock& block, const Eigen::MatrixXd& S,
           const Eigen::MatrixXd& extra_damping, Transients transients, bool next_order);

  /// To the next row, and the outputs there unless y is null; false behind the last.
  bool next(Eigen::VectorXd* y);

 private:
  FullModel& full_;
  const std::vector<ScreenedRow>& rows_;
  const std::size_t every_;
  const std::vector<int>& outputs_;
  BodyAlone alone_;
  LinearCorrection correction_;
  Transients transients_;
  LinearisedRow small_, own_;
  bool has_next_order_;
  Eigen::VectorXd next_order_, r_;  // load, from the row before
  Eigen::MatrixXd G_;
  mbs::State moved_;
  std::size_t at_ = 0;  // the next row
};

/// What of the body may ring while the other bodies are rigid.
Transients transients_of(FullModel& full, const std::vector<ScreenedRow>& rows, const ModalBlock& block);

/// The outputs of a body in all its deformations, followed as far as a candidate has come so far.
class WholeBody {
 public:
  /// `follower` null: as the rows' own, where no other body deforms.  Of the rows followed one in `compared` has outputs.
  WholeBody(const std::vector<ScreenedRow>& rows, std::size_t compared, std::unique_ptr<Follower> follower);

  /// At the row i of those followed, a multiple of `compared`.
  const Eigen::VectorXd& at(std::size_t i);

 private:
  const std::vector<ScreenedRow>& rows_;
  std::size_t compared_, followed_ = 0;
  std::unique_ptr<Follower> follower_;
  std::vector<Eigen::VectorXd> known_;
};

/// Stiffness (m) and damping (m x m) of the block's deformations [1/s^2, 1/s].
const Eigen::VectorXd& stiffness_of(const FullModel& full, const ModalBlock& block);
Eigen::MatrixXd damping_of(const FullModel& full, const ModalBlock& block);

}  // namespace flexura::study
