// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

namespace flexura::study {

/// What a step of the linear correction makes of load, predicted rate and predicted position, as one product:
///
///     next = W_load load + W_rate rate + W_position position,      all n x columns.
///
/// Short steps of few coordinates spend most of their time beside their arithmetic.
class StepOperator {
 public:
  bool is_there() const { return n_ > 0; }
  void clear() { n_ = 0; }

  /// The three n x n, in that order.
  void set(const std::array<const Eigen::MatrixXd*, 3>& W);
  void apply(const Eigen::MatrixXd& load, const Eigen::MatrixXd& rate, const Eigen::MatrixXd& position,
             Eigen::MatrixXd& next) const;

 private:
  Eigen::Index n_ = 0, padded_ = 0;
  std::vector<double> W_;  // column after column, each padded with zeros
  mutable std::vector<double> sums_;
};

}  // namespace flexura::study
