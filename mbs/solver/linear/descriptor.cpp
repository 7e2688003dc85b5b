// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/descriptor.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <stdexcept>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/linear/perturbation.hpp"

namespace flexura::mbs {

using Eigen::MatrixXd;
using Eigen::VectorXd;

DescriptorSystem linearise_as_descriptor(const Equations& eq, const State& given,
                                         const LineariseOptions& options) {
  const Sizes n = eq.sizes();
  const int n_v = n.n_v, n_c = n.n_dyn, n_a = n.n_alg, n_l = n.n_lambda;
  const int at_c = 2 * n_v, at_a = at_c + n_c, at_l = at_a + n_a, n_x = at_l + n_l;
  State s = given;
  VectorXd v_dot;
  AccelerationSolver(eq).solve(s, v_dot);
  const Perturbation d(eq, s, v_dot, options.signals);
  const Tangents& t = d.t;
  const MatrixXd &z_q = d.z_q, &h_q = d.h_q;
  DescriptorSystem out;
  out.E.setZero(n_x, n_x);
  out.A.setZero(n_x, n_x);
  out.A.topLeftCorner(n_v, n_v) = d.W;

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
    out.A.block(at_l + k, at_c, 1, n_c) = (eq.is_holonomic(k) ? d.g_c : d.h_c).row(k);
    if (eq.is_holonomic(k)) {
      out.A.block(at_l + k, 0, 1, n_v) = t.G.row(k);
    } else {
      out.A.block(at_l + k, 0, 1, n_v) = h_q.row(k);
      out.A.block(at_l + k, n_v, 1, n_v) = t.G.row(k);
    }
  }

  const int n_f = static_cast<int>(options.inputs.size() + options.along.size()),
            n_u = n_f + static_cast<int>(options.signals.size());
  out.B.setZero(n_x, n_u);
  out.u_0.setZero(n_u);
  out.B.block(n_v, 0, n_v, n_f) = forces_of_inputs(options, n_v);
  for (const int k : options.inputs) out.inputs.push_back("force on " + eq.name_of_velocity(k));
  for (const ForceAlong& force : options.along) out.inputs.push_back("force on " + force.name);
  for (int k = 0; k < n_u - n_f; ++k) {
    const int input = options.signals[static_cast<std::size_t>(k)];
    out.inputs.push_back(eq.name_of_input(input));
    out.u_0(n_f + k) = eq.input_value(input, s.t);
    out.B.col(n_f + k).segment(n_v, n_v) = -d.z_u.col(k).head(n_v);
    out.B.col(n_f + k).segment(at_c, n_c + n_a) = d.z_u.col(k).tail(n_c + n_a);
    for (int row = 0; row < n_l; ++row)
      out.B(at_l + row, n_f + k) = (eq.is_holonomic(row) ? d.g_u : d.h_u[0])(row, k);
  }
  if (options.outputs) {
    out.y_0 = options.outputs(s, v_dot);
    out.outputs = options.output_names;
    const auto n_y = out.y_0.size();
    const OutputTangents y = differentiate_outputs(eq, s, v_dot, options);
    for (int order = 1; order < 3; ++order)
      for (Eigen::Index i = 0; i < n_y; ++i)
        if (!y.u[order].row(i).isZero(0.0))
          throw std::invalid_argument(fmt::format(
              "output \"{}\" reads the rate of an input, which a descriptor system does not have: leave it "
              "out, or --descriptor",
              out.outputs[static_cast<std::size_t>(i)]));
    out.C.resize(n_y, n_x);
    out.C << y.q, y.v, y.c, y.a, y.lambda;
    out.D.setZero(n_y, n_u);
    out.D.rightCols(n_u - n_f) = y.u[0];
    // v' is not among the states: it follows from the momentum rows.
    const Eigen::PartialPivLU<MatrixXd> M(t.M);
    out.C += y.v_dot * M.solve(out.A.middleRows(n_v, n_v));
    out.D += y.v_dot * M.solve(out.B.middleRows(n_v, n_v));
  } else {
    out.C.setZero(0, n_x);
    out.D.setZero(0, n_u);
  }

  out.x_0.setZero(n_x);
  out.states.resize(n_x);
  out.x_0.head(n_v) = d.T_inverse * s.p;
  for (int j = 0; j < n_v; ++j) out.states[j] = d.names[static_cast<std::size_t>(j)];
  for (int j = 0; j < n_v; ++j) out.states[n_v + j] = eq.name_of_velocity(j);
  for (int j = 0; j < n_c; ++j) out.states[at_c + j] = eq.name_of_dynamic(j);
  for (int j = 0; j < n_a; ++j) out.states[at_a + j] = eq.name_of_algebraic(j);
  for (int j = 0; j < n_l; ++j) out.states[at_l + j] = "reaction of " + eq.name_of_constraint(j);
  out.x_0.segment(n_v, n_v) = s.v;
  out.x_0.segment(at_c, n_c) = s.c;
  out.x_0.segment(at_a, n_a) = s.a;
  out.x_0.tail(n_l) = s.lambda;
  const std::vector<bool> held = held_states(eq, s, v_dot);
  std::vector<int> kept;
  for (int i = 0; i < n_x; ++i)
    if (i < at_c || i >= at_a || !held[static_cast<std::size_t>(i - at_c)]) kept.push_back(i);
  if (static_cast<int>(kept.size()) == n_x) return out;
  for (MatrixXd* X : {&out.E, &out.A}) *X = MatrixXd((*X)(kept, kept));
  out.B = MatrixXd(out.B(kept, Eigen::all));
  out.C = MatrixXd(out.C(Eigen::all, kept));
  out.x_0 = VectorXd(out.x_0(kept));
  std::vector<std::string> states;
  for (const int i : kept) states.push_back(out.states[static_cast<std::size_t>(i)]);
  out.states = std::move(states);
  return out;
}

}  // namespace flexura::mbs
