// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>

#include "mbs/model/equations.hpp"

/// Derivatives of the equations of motion about one state, for Newton matrices and linearisation.
///
/// With z = (r, c_rate, b), r = M v_dot - f + G^T lambda, stacked (n_z = n_v + n_dyn + n_alg):
///     z_p = dz/dp, z_v = dz/dv, z_c = dz/dc, z_a = dz/da      at fixed v_dot and lambda
///     M, G                                                      exact, from the equations
///     g_p = dg/dp, h_p = d(G v + g_t)/dp
/// by forward differences with relative step sqrt(eps): errors of about 1e-8 of the entries' scale. `central`
/// doubles the cost and brings them to about 1e-10.
namespace flexura::mbs {

class Tangents {
 public:
  explicit Tangents(const Equations& eq);

  void evaluate(const State& s, const Eigen::VectorXd& v_dot, bool central = false);

  Eigen::MatrixXd z_p, z_v, z_c, z_a, M, G, g_p, h_p;
  Eigen::VectorXd z;  ///< at the state itself
  long evaluations = 0;

 private:
  void momentum(const State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd& z);
  void difference(Eigen::VectorXd& x, double scale_floor, int j, bool central, const Eigen::VectorXd& v_dot,
                  Eigen::MatrixXd& columns);

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  State s_;
  Eigen::VectorXd z_plus_, z_minus_, g_, h_, g_plus_, h_plus_, g_minus_, h_minus_;
};

}  // namespace flexura::mbs
