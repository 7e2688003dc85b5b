// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/study/estimate/full_model.hpp"

namespace flexura::study {

/// Linearised rows of a run for its linear correction, taken anew as often as they change.
///
/// Derivatives of the full model cost many times what a step of the correction does, and rows lie close where
/// forces vibrate while the mechanism hardly moves.  Rows in between take the last derivatives over: twice as
/// many as before while two that follow each other differ by less than a small change of themselves in what a
/// step solves with, half as many where by more than twice that, none where a switch has changed.  The
/// constraints' G is every row's own: a correction that obeyed an old one would have to jump to the next.
class HeldRows {
 public:
  /// What is taken over, and for how many rows at most.
  struct Span {
    double small_change;
    int longest;
  };
  static constexpr Span kOfEstimates = {0.005, 16};
  /// For a choice, which a run with its own estimate follows: derivatives that are off by a part make the losses of all
  /// candidates off by this part.
  static constexpr Span kOfChoice = {0.1, 64};

  explicit HeldRows(FullModel& full, const Span& span = kOfEstimates) : full_(full), most_(span) {}

  /// The next row: at the state s with accelerations v_dot, h [s] after the one before it.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot, double h);

  /// Its derivatives or those of one shortly before; its own G (n_lambda x n_v).
  const std::shared_ptr<const LinearisedRow>& row() const { return last_; }
  const Eigen::MatrixXd& G() const { return G_; }

  long linearised() const { return linearised_; }  ///< how often

 private:
  FullModel& full_;
  Span most_;
  std::shared_ptr<const LinearisedRow> last_;
  Eigen::MatrixXd G_;
  std::vector<int> switches_;
  int span_ = 1, left_ = 0;  // rows that one takes, and those to come
  long linearised_ = 0;
};

}  // namespace flexura::study
