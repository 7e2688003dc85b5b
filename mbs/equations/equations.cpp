// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/equations/equations.hpp"

namespace flexura::mbs {

void Equations::residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, Scratch& scratch,
                          VectorRef r, VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g,
                          VectorRef GT_mu) const {
  if (mu.size() > 0) {
    apply_GT(s, s.p, mu, scratch, GT_mu);
    velocity_constraints(s, s.p, s.v, scratch, g_dot);
    position_constraints(s, s.p, scratch, g);
  }
  momentum(s, v_dot, scratch, r, c_rate, b);
}

void Equations::constraints(When when, ConstVectorRef p, ConstVectorRef v, Scratch& scratch, VectorRef g,
                            VectorRef g_dot) const {
  position_constraints(when, p, scratch, g);
  velocity_constraints(when, p, v, scratch, g_dot);
}

ConstraintSizes Equations::constraint_sizes(When when, ConstVectorRef p, Scratch& scratch) const {
  const Sizes n = sizes();
  Eigen::MatrixXd G(n.n_lambda, n.n_v);
  constraint_matrix(when, p, scratch, G);
  Eigen::VectorXd scale(n.n_v);
  for (int i = 0; i < n.n_v; ++i) scale(i) = velocity_scale(i);
  ConstraintSizes out{G.cwiseAbs() * scale, {}, std::vector<bool>(n.n_lambda, false)};
  const double largest = n.n_lambda > 0 ? out.size.maxCoeff() : 0.0;
  for (double& size : out.size)
    if (!(size > 1e-8 * largest)) size = largest > 0.0 ? largest : 1.0;
  out.round_off = 4e-16 * out.size;
  return out;
}

}  // namespace flexura::mbs
