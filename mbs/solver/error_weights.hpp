// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/model/equations.hpp"
#include "mbs/solver/options.hpp"

/// What an error in each state is allowed to be, the same for all integrators:
///
///     positions        tolerance * (min(|p|, scale) + absolute_factor scale)
///     velocities       tolerance * (|v| + absolute_factor scale)
///     dynamic states   tolerance * (|c| + absolute_factor)
///
/// A wheel's angle does not loosen the tolerance with its revolutions, hence the bound on |p|.
namespace flexura::mbs {

class ErrorWeights {
 public:
  ErrorWeights(const Equations& eq, const SolverOptions& options);

  /// w (n_p + n_v + n_dyn) = 1 / allowed error at these values.
  void evaluate(ConstVectorRef p, ConstVectorRef v, ConstVectorRef c, VectorRef w) const;

 private:
  double tolerance_, floor_;
  Eigen::VectorXd position_scale_, velocity_scale_;
};

}  // namespace flexura::mbs
