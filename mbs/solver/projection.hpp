// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/model/equations.hpp"
#include "mbs/solver/saddle.hpp"

/// Back onto the constraints by the smallest change in the norm of M, from nearby (the end of a step):
///     position   p <- retract(p, d),  M d + G^T x = 0,  G d = -g         simplified Newton with one
///     factorisation velocity   v <- v + d,          M d + G^T x = 0,  G d = -(G v + g_t)
namespace flexura::mbs {

class Projector {
 public:
  explicit Projector(const Equations& eq);

  /// False when g does not come down: s is then too far away.  Positions, then velocities.
  bool project(State& s);

 private:
  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  SaddleSolver saddle_;
  Eigen::MatrixXd M_, G_;
  Eigen::VectorXd g_, zero_, d_, x_, p_, scale_;
};

}  // namespace flexura::mbs
