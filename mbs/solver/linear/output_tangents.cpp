// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>

#include "mbs/solver/linear/linearise.hpp"

namespace flexura::mbs {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

OutputTangents differentiate_outputs(const Equations& eq, const State& s, const VectorXd& v_dot,
                                     const LineariseOptions& options) {
  const Sizes n = eq.sizes();
  const Index n_y = options.outputs(s, v_dot).size();
  constexpr double kStep = 1e-5;  // eps^(1/3) of the typical size
  const auto size_of = [](double x) { return std::max(1.0, std::abs(x)); };
  const auto columns = [&](int count, const auto& size, const auto& move) {
    MatrixXd out(n_y, count);
    for (int j = 0; j < count; ++j) {
      const double h = kStep * size(j);
      State up = s, down = s;
      VectorXd v_dot_up = v_dot, v_dot_down = v_dot;
      move(up, v_dot_up, j, h);
      move(down, v_dot_down, j, -h);
      out.col(j) = (options.outputs(up, v_dot_up) - options.outputs(down, v_dot_down)) / (2.0 * h);
    }
    return out;
  };
  const auto speed = [&](int j) { return eq.velocity_scale(j); };
  OutputTangents out;
  out.q = columns(n.n_v, speed, [&](State& to, VectorXd&, int j, double h) {
    eq.retract(s.p, h * VectorXd::Unit(n.n_v, j), to.p);
  });
  out.v = columns(n.n_v, speed, [](State& to, VectorXd&, int j, double h) { to.v(j) += h; });
  out.c = columns(
      n.n_dyn, [&](int j) { return size_of(s.c(j)); },
      [](State& to, VectorXd&, int j, double h) { to.c(j) += h; });
  out.a = columns(
      n.n_alg, [&](int j) { return size_of(s.a(j)); },
      [](State& to, VectorXd&, int j, double h) { to.a(j) += h; });
  out.lambda = columns(
      n.n_lambda, [&](int j) { return size_of(s.lambda(j)); },
      [](State& to, VectorXd&, int j, double h) { to.lambda(j) += h; });
  out.v_dot = columns(
      n.n_v, [&](int j) { return std::max(eq.velocity_scale(j), std::abs(v_dot(j))); },
      [](State&, VectorXd& to, int j, double h) { to(j) += h; });
  for (int order = 0; order < 3; ++order)
    out.u[order] = columns(
        static_cast<int>(options.signals.size()),
        [&](int j) { return size_of(eq.input_value(options.signals[static_cast<std::size_t>(j)], s.t)); },
        [&](State& to, VectorXd&, int j, double h) {
          to.u = h * VectorXd::Unit(3 * eq.n_inputs(),
                                    order * eq.n_inputs() + options.signals[static_cast<std::size_t>(j)]);
        });
  return out;
}

}  // namespace flexura::mbs
