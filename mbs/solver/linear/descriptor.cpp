// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/descriptor.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"

namespace flexura::mbs {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// T^+ (d(Tv)/dp T - dT/dt): how the moving coordinates q turn with the motion; zero at rest.
MatrixXd transport_of(const Equations& eq, KinematicBlocks& kinematics, const State& s) {
  const Sizes n = eq.sizes();
  MatrixXd W = MatrixXd::Zero(n.n_v, n.n_v);
  if (s.v.isZero(0.0)) return W;
  VectorXd p_dot(n.n_p);
  eq.kinematic(s.p, s.v, p_dot);
  const double dt =
      1e-5;  // T is linear in the quaternions: the central difference is exact but for round-off
  std::vector<MatrixXd> T_dot;
  kinematics.update(s.p + dt * p_dot, s.v);
  for (const auto& b : kinematics.blocks()) T_dot.push_back(b.T / (2 * dt));
  kinematics.update(s.p - dt * p_dot, s.v);
  for (std::size_t k = 0; k < T_dot.size(); ++k) T_dot[k] -= kinematics.blocks()[k].T / (2 * dt);
  kinematics.update(s.p, s.v);
  for (std::size_t k = 0; k < T_dot.size(); ++k) {
    const auto& b = kinematics.blocks()[k];
    const MatrixXd w = b.T_inverse * (b.A * b.T - T_dot[k]);
    for (std::size_t i = 0; i < b.v.size(); ++i)
      for (std::size_t j = 0; j < b.v.size(); ++j) W(b.v[i], b.v[j]) = w(i, j);
  }
  return W;
}

// Derivatives of the outputs by x at fixed v', then by v'.
void differentiate_outputs(const Equations& eq, const State& s, const VectorXd& v_dot,
                           const LineariseOptions& options, MatrixXd& by_x, MatrixXd& by_v_dot) {
  const Sizes n = eq.sizes();
  int column = 0;
  const auto difference = [&](double size, const std::function<void(State&, VectorXd&, double)>& move) {
    const double h = 1e-5 * size;  // eps^(1/3) of the typical size
    State up = s, down = s;
    VectorXd v_dot_up = v_dot, v_dot_down = v_dot;
    move(up, v_dot_up, h);
    move(down, v_dot_down, -h);
    return VectorXd((options.outputs(up, v_dot_up) - options.outputs(down, v_dot_down)) / (2.0 * h));
  };
  for (int j = 0; j < n.n_v; ++j)
    by_x.col(column++) = difference(eq.velocity_scale(j), [&](State& to, VectorXd&, double h) {
      eq.retract(s.p, h * VectorXd::Unit(n.n_v, j), to.p);
    });
  for (int j = 0; j < n.n_v; ++j)
    by_x.col(column++) =
        difference(eq.velocity_scale(j), [j](State& to, VectorXd&, double h) { to.v(j) += h; });
  for (int j = 0; j < n.n_dyn; ++j)
    by_x.col(column++) =
        difference(std::max(1.0, std::abs(s.c(j))), [j](State& to, VectorXd&, double h) { to.c(j) += h; });
  for (int j = 0; j < n.n_alg; ++j)
    by_x.col(column++) =
        difference(std::max(1.0, std::abs(s.a(j))), [j](State& to, VectorXd&, double h) { to.a(j) += h; });
  for (int j = 0; j < n.n_lambda; ++j)
    by_x.col(column++) = difference(std::max(1.0, std::abs(s.lambda(j))),
                                    [j](State& to, VectorXd&, double h) { to.lambda(j) += h; });
  for (int j = 0; j < n.n_v; ++j)
    by_v_dot.col(j) = difference(std::max(eq.velocity_scale(j), std::abs(v_dot(j))),
                                 [j](State&, VectorXd& to, double h) { to(j) += h; });
}

}  // namespace

DescriptorSystem linearise_as_descriptor(const Equations& eq, const State& given,
                                         const LineariseOptions& options) {
  const Sizes n = eq.sizes();
  const int n_v = n.n_v, n_c = n.n_dyn, n_a = n.n_alg, n_l = n.n_lambda;
  const int at_c = 2 * n_v, at_a = at_c + n_c, at_l = at_a + n_a, n_x = at_l + n_l;
  State s = given;
  VectorXd v_dot;
  AccelerationSolver(eq).solve(s, v_dot);
  Tangents t(eq);
  t.evaluate(s, v_dot);
  KinematicBlocks kinematics(eq, s.p);
  DescriptorSystem out;
  out.E.setZero(n_x, n_x);
  out.A.setZero(n_x, n_x);
  out.A.topLeftCorner(n_v, n_v) = transport_of(eq, kinematics, s);
  kinematics.update(s.p, s.v);
  MatrixXd z_q, h_q;
  kinematics.multiply_T(t.z_p, z_q);
  kinematics.multiply_T(t.h_p, h_q);

  out.E.topLeftCorner(n_v, n_v).setIdentity();
  out.A.block(0, n_v, n_v, n_v).setIdentity();
  out.E.block(n_v, n_v, n_v, n_v) = t.M;
  // z = (r, f_c, b): r is what the coordinates lack, so it changes sides.
  out.A.block(n_v, 0, n_v, n_v) = -z_q.topRows(n_v);
  out.A.block(n_v, n_v, n_v, n_v) = -t.z_v.topRows(n_v);
  out.A.block(n_v, at_c, n_v, n_c) = -t.z_c.topRows(n_v);
  out.A.block(n_v, at_a, n_v, n_a) = -t.z_a.topRows(n_v);
  out.A.block(n_v, at_l, n_v, n_l) = -t.G.transpose();
  out.E.block(at_c, at_c, n_c, n_c).setIdentity();
  out.A.block(at_c, 0, n_c + n_a, n_v) = z_q.bottomRows(n_c + n_a);
  out.A.block(at_c, n_v, n_c + n_a, n_v) = t.z_v.bottomRows(n_c + n_a);
  out.A.block(at_c, at_c, n_c + n_a, n_c) = t.z_c.bottomRows(n_c + n_a);
  out.A.block(at_c, at_a, n_c + n_a, n_a) = t.z_a.bottomRows(n_c + n_a);
  if (t.c_v_dot.size() > 0) {
    out.E.block(at_c, n_v, n_c, n_v) = -t.c_v_dot;
    out.A.block(at_c, at_l, n_c, n_l) = t.c_lambda;
  }
  if (t.b_v_dot.size() > 0) {
    out.E.block(at_a, n_v, n_a, n_v) = -t.b_v_dot;
    out.A.block(at_a, at_l, n_a, n_l) = t.b_lambda;
  }
  for (int k = 0; k < n_l; ++k) {
    if (t.g_c.size() > 0) out.A.block(at_l + k, at_c, 1, n_c) = (eq.is_holonomic(k) ? t.g_c : t.h_c).row(k);
    if (eq.is_holonomic(k)) {
      out.A.block(at_l + k, 0, 1, n_v) = t.G.row(k);
    } else {
      out.A.block(at_l + k, 0, 1, n_v) = h_q.row(k);
      out.A.block(at_l + k, n_v, 1, n_v) = t.G.row(k);
    }
  }

  const int n_f = static_cast<int>(options.inputs.size()),
            n_u = n_f + static_cast<int>(options.signals.size());
  out.B.setZero(n_x, n_u);
  out.u_0.setZero(n_u);
  for (int k = 0; k < n_f; ++k) {
    out.B(n_v + options.inputs[k], k) = 1.0;
    out.inputs.push_back("force on " + eq.name_of_velocity(options.inputs[k]));
  }
  const auto scratch = eq.make_scratch();
  MatrixXd direct = MatrixXd::Zero(0, n_u);  // of outputs on inputs, at fixed v'
  if (options.outputs) direct.setZero(options.outputs(s, v_dot).size(), n_u);
  for (int k = n_f; k < n_u; ++k) {
    const int input = options.signals[k - n_f];
    out.inputs.push_back(eq.name_of_input(input));
    out.u_0(k) = eq.input_value(input, s.t);
    const double h = 1e-5 * std::max(1.0, std::abs(out.u_0(k)));
    VectorXd z[2];
    for (int side = 0; side < 2; ++side) {
      State moved = s;
      moved.u = (side == 0 ? h : -h) * VectorXd::Unit(eq.n_inputs(), input);
      z[side].setZero(n_v + n_c + n_a);
      eq.momentum(moved, v_dot, *scratch, z[side].head(n_v), z[side].segment(n_v, n_c), z[side].tail(n_a));
      if (options.outputs) direct.col(k) += (side == 0 ? 0.5 : -0.5) / h * options.outputs(moved, v_dot);
    }
    out.B.col(k).segment(n_v, n_v + n_c + n_a) = (z[0] - z[1]) / (2.0 * h);
    out.B.col(k).segment(n_v, n_v) *= -1.0;
  }
  if (options.outputs) {
    out.y_0 = options.outputs(s, v_dot);
    out.outputs = options.output_names;
    const auto n_y = out.y_0.size();
    MatrixXd by_v_dot(n_y, n_v);
    out.C.setZero(n_y, n_x);
    differentiate_outputs(eq, s, v_dot, options, out.C, by_v_dot);
    // v' is not among the states: it follows from the momentum rows.
    const Eigen::PartialPivLU<MatrixXd> M(t.M);
    out.C += by_v_dot * M.solve(out.A.middleRows(n_v, n_v));
    out.D = direct + by_v_dot * M.solve(out.B.middleRows(n_v, n_v));
  } else {
    out.C.setZero(0, n_x);
    out.D.setZero(0, n_u);
  }

  out.x_0.setZero(n_x);
  out.states.resize(n_x);
  for (const auto& b : kinematics.blocks())
    for (const int j : b.v) {
      const bool plain = b.p.size() == 1;
      out.states[j] = plain ? eq.name_of_position(b.p[0]) : "integral of " + eq.name_of_velocity(j);
      if (plain) out.x_0(j) = s.p(b.p[0]);
    }
  for (int j = 0; j < n_v; ++j) out.states[n_v + j] = eq.name_of_velocity(j);
  for (int j = 0; j < n_c; ++j) out.states[at_c + j] = eq.name_of_dynamic(j);
  for (int j = 0; j < n_a; ++j) out.states[at_a + j] = eq.name_of_algebraic(j);
  for (int j = 0; j < n_l; ++j) out.states[at_l + j] = "reaction of " + eq.name_of_constraint(j);
  out.x_0.segment(n_v, n_v) = s.v;
  out.x_0.segment(at_c, n_c) = s.c;
  out.x_0.segment(at_a, n_a) = s.a;
  out.x_0.tail(n_l) = s.lambda;
  return out;
}

}  // namespace flexura::mbs
