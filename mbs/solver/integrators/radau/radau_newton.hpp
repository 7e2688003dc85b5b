// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <functional>
#include <string>

#include "mbs/solver/algebra/history.hpp"
#include "mbs/solver/integrators/radau/radau_tableau.hpp"
#include "mbs/solver/integrators/stabilised_index2.hpp"

namespace flexura::mbs {

/// Newton's simplified method for the stages of Radau IIA (radau.hpp): iterates until the corrections are a hundredth of the
/// error allowed, and tells when that will not come (Hairer and Wanner, Solving ODEs II, section IV.8).
class RadauNewton {
 public:
  enum class Outcome { converged, slow, diverged };
  /// A step from t to t + h; stages do not look beyond t_stop.
  struct Step {
    double t, h, t_stop;
    const Eigen::VectorXd &y, &weights2;  ///< at t; squares of the weights of its entries
    double n_norm;                        ///< entries that the norm is the mean of
    bool is_narrow;  ///< stiffness may end within the step: one small correction proves nothing
  };
  struct Result {
    Outcome outcome;
    double shorter = 0.5;  ///< the part of the step to try next where it failed
    int iterations = 0;
    std::string trouble;  ///< what was not finite
  };
  using Stages = std::array<Eigen::VectorXd, 3>;
  using Solve = std::function<void(Stages&)>;  ///< makes corrections dZ_i of residuals R_i

  RadauNewton(const RadauTableau& tableau, StabilisedIndex2& form, double tolerance);

  /// Nothing is known of the matrix: at a start.
  void start();
  /// From guesses Z_i = Y_i - y of the stages in at most `most` iterations; the first `trusted` may diverge.
  Result iterate(const Step& step, int most, int trusted, const Solve& solve, Stages& Z);
  /// It contracts so slowly that new derivatives are worth their cost.
  bool is_slow() const;
  /// Nothing is known of one matrix for all stages: others were at work.
  void doubt_matrix() { theta_ = 1.0; }

  void remember(History& history);

 private:
  const RadauTableau& k_;
  StabilisedIndex2& form_;
  double tolerance_, theta_ = 0.0, convergence_ = 1.0;
  Stages R_;
  Eigen::VectorXd stage_, rate_;
};

}  // namespace flexura::mbs
