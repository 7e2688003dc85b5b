// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>

#include "mbs/solver/integrators/radau/radau_matrices.hpp"

namespace flexura::mbs {

/// Errors of a step of Radau IIA (radau.hpp) in units of the error allowed, by the matrices it was solved with.
class RadauErrors {
 public:
  /// A step from t to t + h whose stages y + Z_i have converged.
  struct Step {
    double t, h;
    const Eigen::VectorXd &y, &yp, &weights2;  ///< at t; squares of the weights of the entries
    const std::array<Eigen::VectorXd, 3>& Z;
    double n_norm;   ///< entries that the norm is the mean of
    bool is_narrow;  ///< stiffness may end within the step
  };
  RadauErrors(const Equations& eq, const RadauTableau& tableau, RadauMatrices& matrices);

  /// Of the embedded formula (Hairer and Wanner, Solving ODEs II, section IV.8); `again`: what belongs to stiff components is
  /// damped where it would refuse the step.  Infinite where it is not finite.
  double local(const Step& step, bool again);
  /// How far the step's polynomial lies from the constraints between its nodes.
  double between_nodes(const Step& step);
  /// The vector that local() took the norm of last.
  const Eigen::VectorXd& last() const { return error_; }

 private:
  const Equations& eq_;
  const RadauTableau& k_;
  RadauMatrices& matrices_;
  StabilisedIndex2& form_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  State between_;
  Eigen::VectorXd stage_, rate_, step_, rhs_, x_, error_, g_;
};

}  // namespace flexura::mbs
