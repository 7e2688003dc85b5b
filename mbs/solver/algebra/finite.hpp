// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <stdexcept>
#include <string>

#include "mbs/equations/equations.hpp"

namespace flexura::mbs {

/// A force, rate or constraint came out as inf or NaN: the text names the coordinate or state and the time.
class NonFiniteError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The sentence for the first entry that is not finite, or "" when all are.
std::string describe_non_finite(const Equations& eq, double t, const Eigen::VectorXd& r,
                                const Eigen::VectorXd& c_rate, const Eigen::VectorXd& b);

/// Throws NonFiniteError with that sentence.
void require_finite_forces(const Equations& eq, double t, const Eigen::VectorXd& r,
                           const Eigen::VectorXd& c_rate, const Eigen::VectorXd& b);

}  // namespace flexura::mbs
