// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/linearise.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/linear/perturbation.hpp"
#include "mbs/solver/position/independent.hpp"

namespace flexura::mbs {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// A sum of terms that is no more than this part of their sizes is none.
constexpr double kCancelled = 1e-12;

// X Y, and zero where only round-off of the terms is left.
MatrixXd product(const MatrixXd& X, const MatrixXd& Y) {
  MatrixXd out = X * Y;
  const MatrixXd size = X.cwiseAbs() * Y.cwiseAbs();
  return (out.array().abs() <= kCancelled * size.array()).select(0.0, out);
}

MatrixXd sum(const MatrixXd& X, const MatrixXd& Y) {
  const MatrixXd out = X + Y;
  return (out.array().abs() <= kCancelled * (X.array().abs() + Y.array().abs())).select(0.0, out);
}

class Lineariser {
 public:
  Lineariser(const Equations& eq, const State& given, const LineariseOptions& options)
      : eq_(eq),
        options_(options),
        n_(eq.sizes()),
        s_(consistent(eq, given, v_dot_)),
        d_(eq, s_, v_dot_, options.signals) {
    choose_coordinates();
  }

  LinearSystem system();

 private:
  /// Changes as columns for (z, w, c), a, u, u', u'' and forces.
  struct Columns {
    MatrixXd q, v, v_dot, lambda, a, c_rate;
  };

  static State consistent(const Equations& eq, State s, VectorXd& v_dot) {
    AccelerationSolver(eq).solve(s, v_dot);
    return s;
  }
  void choose_coordinates();
  void motions();
  void accelerations();
  void eliminate_algebraic();
  void drop_round_off_of_motion(MatrixXd& rates) const;
  void set_names(LinearSystem& out) const;
  void set_outputs(LinearSystem& out) const;

  Index n_z() const { return static_cast<Index>(positions_.size()); }
  Index n_w() const { return static_cast<Index>(independent_.size()); }
  Index n_c() const { return static_cast<Index>(dynamic_.size()); }
  Index n_x() const { return n_z() + n_w() + n_c(); }
  Index n_s() const { return static_cast<Index>(options_.signals.size()); }
  Index n_f() const { return static_cast<Index>(options_.inputs.size() + options_.along.size()); }
  Index at_u(int order) const { return n_x() + n_.n_alg + order * n_s(); }
  Index at_forces() const { return at_u(3); }

  const Equations& eq_;
  const LineariseOptions& options_;
  const Sizes n_;
  VectorXd v_dot_;
  const State s_;
  Perturbation d_;
  std::vector<int> positions_, independent_, dynamic_;
  MatrixXd P_, Y_g_;  ///< dq = P z - Y_g (g_c c + g_u u)
  MatrixXd N_, Y_;    ///< dv = N w - Y (...)
  Columns of_;
};

}  // namespace

MatrixXd forces_of_inputs(const LineariseOptions& options, Eigen::Index n_v) {
  const std::size_t n = options.inputs.size();
  MatrixXd forces = MatrixXd::Zero(n_v, static_cast<Eigen::Index>(n + options.along.size()));
  for (std::size_t k = 0; k < n; ++k) forces(options.inputs[k], static_cast<Eigen::Index>(k)) = 1.0;
  for (std::size_t k = 0; k < options.along.size(); ++k)
    forces.col(static_cast<Eigen::Index>(n + k)) = options.along[k].on_rows;
  return forces;
}

namespace {

void Lineariser::choose_coordinates() {
  IndependentCoordinates w = independent_coordinates(d_.t.M, d_.t.G);
  independent_ = std::move(w.independent);
  N_ = std::move(w.N);
  Y_ = dependent_by_rows(d_.t.M, d_.t.G, independent_);
  MatrixXd G = d_.t.G;
  bool all = true;
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!eq_.is_holonomic(k)) {
      G.row(k).setZero();
      all = false;
    }
  if (all) {
    positions_ = independent_;
    P_ = N_;
    Y_g_ = Y_;
  } else {
    IndependentCoordinates z = independent_coordinates_beside(d_.t.M, G, independent_);
    positions_ = std::move(z.independent);
    P_ = std::move(z.N);
    Y_g_ = dependent_by_rows(d_.t.M, G, positions_);
  }
  const std::vector<bool> held = held_states(eq_, s_, v_dot_);
  for (int j = 0; j < n_.n_dyn; ++j)
    if (!held[static_cast<std::size_t>(j)]) dynamic_.push_back(j);
}

// Positions and speeds that the rows leave.
void Lineariser::motions() {
  const Index n = at_forces() + n_f();
  MatrixXd g = MatrixXd::Zero(n_.n_lambda, n), h = g;
  of_.q.setZero(n_.n_v, n);
  of_.q.leftCols(n_z()) = P_;
  g.middleCols(n_z() + n_w(), n_c()) = d_.g_c(Eigen::all, dynamic_);
  g.middleCols(at_u(0), n_s()) = d_.g_u;
  for (int k = 0; k < n_.n_lambda; ++k)
    if (!eq_.is_holonomic(k)) g.row(k).setZero();
  of_.q -= product(Y_g_, g);
  h.middleCols(n_z() + n_w(), n_c()) = d_.h_c(Eigen::all, dynamic_);
  for (int order = 0; order < 2; ++order) h.middleCols(at_u(order), n_s()) = d_.h_u[order];
  h = sum(h, product(d_.h_q, of_.q));
  of_.v = -product(Y_, h);
  of_.v.middleCols(n_z(), n_w()) += N_;
}

// Accelerations and multipliers where a is held.
void Lineariser::accelerations() {
  const Index n = of_.q.cols(), n_v = n_.n_v;
  const Perturbation& d = d_;
  MatrixXd direct = MatrixXd::Zero(d.t.z_p.rows(), n), gamma = MatrixXd::Zero(n_.n_lambda, n);
  direct.middleCols(n_z() + n_w(), n_c()) = d.t.z_c(Eigen::all, dynamic_);
  direct.middleCols(n_x(), n_.n_alg) = d.t.z_a;
  direct.middleCols(at_u(0), n_s()) = d.z_u;
  direct.block(0, at_forces(), n_v, n_f()) = -forces_of_inputs(options_, n_v);
  gamma.middleCols(n_z() + n_w(), n_c()) = d.a_c(Eigen::all, dynamic_);
  gamma.middleCols(n_x(), n_.n_alg) = d.a_a;
  for (int order = 0; order < 3; ++order) gamma.middleCols(at_u(order), n_s()) = d.a_u[order];
  const MatrixXd z = sum(sum(direct, product(d.z_q, of_.q)), product(d.t.z_v, of_.v));
  gamma = sum(sum(gamma, product(d.a_q, of_.q)), product(d.a_v, of_.v));
  const MatrixXd follows = -product(Y_, gamma);
  const MatrixXd r = sum(z.topRows(n_v), product(d.t.M, follows));
  // Of one size, so that small masses are not lost beside large ones.
  const MatrixXd M_w = N_.transpose() * d.t.M * N_;
  const VectorXd unit = M_w.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<MatrixXd> llt(unit.asDiagonal() * M_w * unit.asDiagonal());
  if (n_w() > 0 && llt.info() != Eigen::Success)
    throw std::runtime_error(
        "the mass matrix of the free motions is not positive definite: give the bodies that they move a "
        "positive mass or inertia of their own");
  of_.v_dot = follows;
  if (n_w() > 0)
    of_.v_dot -= N_ * (unit.asDiagonal() * llt.solve(unit.asDiagonal() * product(N_.transpose(), r)));
  of_.lambda = -Y_.transpose() * (z.topRows(n_v) + d.t.M * of_.v_dot);
  of_.c_rate = z.middleRows(n_v, n_.n_dyn);
  if (d.t.c_v_dot.size() > 0) of_.c_rate += d.t.c_v_dot * of_.v_dot + d.t.c_lambda * of_.lambda;
  of_.a = z.bottomRows(n_.n_alg);
  if (d.t.b_v_dot.size() > 0) of_.a += d.t.b_v_dot * of_.v_dot + d.t.b_lambda * of_.lambda;
}

// 0 = b: so far `a` holds what the equations lack; then what a answers, with all that follows from it.
void Lineariser::eliminate_algebraic() {
  if (n_.n_alg == 0) return;
  const Eigen::FullPivLU<MatrixXd> by_a(of_.a.middleCols(n_x(), n_.n_alg));
  if (!by_a.isInvertible())
    throw std::runtime_error(fmt::format(
        "the algebraic equation of \"{}\" does not determine it at this state: there is no linear system; "
        "take a state beside it",
        eq_.name_of_algebraic(static_cast<int>(by_a.permutationQ().indices()(by_a.rank())))));
  const MatrixXd a = -by_a.solve(of_.a);
  for (MatrixXd* of : {&of_.v_dot, &of_.lambda, &of_.c_rate}) {
    const MatrixXd by = of->middleCols(n_x(), n_.n_alg);
    *of = sum(*of, product(by, a));
  }
  of_.a = a;
}

void Lineariser::set_names(LinearSystem& out) const {
  const VectorXd q_0 = d_.T_inverse * s_.p;
  out.x_0.resize(n_x());
  Index i = 0;
  for (const int k : positions_) {
    out.states.push_back(d_.names[static_cast<std::size_t>(k)]);
    out.x_0(i++) = q_0(k);
  }
  for (const int k : independent_) {
    out.states.push_back(eq_.name_of_velocity(k));
    out.x_0(i++) = s_.v(k);
  }
  for (const int k : dynamic_) {
    out.states.push_back(eq_.name_of_dynamic(k));
    out.x_0(i++) = s_.c(k);
  }
  out.u_0.setZero(n_f() + n_s());
  for (const int k : options_.inputs) out.inputs.push_back("force on " + eq_.name_of_velocity(k));
  for (const ForceAlong& force : options_.along) out.inputs.push_back("force on " + force.name);
  for (Index k = 0; k < n_s(); ++k) {
    const int input = options_.signals[static_cast<std::size_t>(k)];
    out.inputs.push_back(eq_.name_of_input(input));
    out.u_0(n_f() + k) = eq_.input_value(input, s_.t);
  }
}

void Lineariser::set_outputs(LinearSystem& out) const {
  out.C.setZero(0, n_x());
  for (MatrixXd& y : out.by_inputs.y) y.setZero(0, n_f() + n_s());
  if (!options_.outputs) return;
  const OutputTangents y = differentiate_outputs(eq_, s_, v_dot_, options_);
  out.y_0 = options_.outputs(s_, v_dot_);
  out.outputs = options_.output_names;
  MatrixXd of = MatrixXd::Zero(out.y_0.size(), of_.q.cols());
  of.middleCols(n_z() + n_w(), n_c()) = y.c(Eigen::all, dynamic_);
  for (int order = 0; order < 3; ++order) of.middleCols(at_u(order), n_s()) = y.u[order];
  MatrixXd size = of.cwiseAbs();
  const auto add = [&](const MatrixXd& by, const MatrixXd& change) {
    of += by * change;
    size += by.cwiseAbs() * change.cwiseAbs();
  };
  add(y.q, of_.q);
  add(y.v, of_.v);
  add(y.a, of_.a);
  add(y.lambda, of_.lambda);
  add(y.v_dot, of_.v_dot);
  // Derivatives of outputs are differences: they leave 1e-11 of the terms.
  of = (of.array().abs() <= 1e-11 * size.array()).select(0.0, of).eval();
  out.C = of.leftCols(n_x());
  for (int order = 0; order < 3; ++order) {
    MatrixXd& by = out.by_inputs.y[order];
    by.setZero(out.y_0.size(), n_f() + n_s());
    by.rightCols(n_s()) = of.middleCols(at_u(order), n_s());
    if (order == 0) by.leftCols(n_f()) = of.rightCols(n_f());
  }
}

// States counted from what inputs alone make of them, see the header.
void settle_inputs(LinearSystem& system) {
  const auto& [rates, q, v, y] = system.by_inputs;
  const MatrixXd &T_1 = rates[2], T_0 = sum(rates[1], product(system.A, T_1));
  system.B = sum(rates[0], product(system.A, T_0));
  system.D = sum(y[0], product(system.C, T_0));
  system.D_1 = sum(y[1], product(system.C, T_1));
  system.D_2 = y[2];
  if (system.D_2.isZero(0.0)) system.D_2.resize(0, 0);
  if (system.D_1.isZero(0.0) && system.D_2.size() == 0) system.D_1.resize(0, 0);
  system.T_0 = T_0.isZero(0.0) && T_1.isZero(0.0) ? MatrixXd() : T_0;
  system.T_1 = T_1.isZero(0.0) ? MatrixXd() : T_1;
}

// Along a motion accelerations are differences of terms in its square: what is no more than their last digits would be a slow
// growth beside free motions.
void Lineariser::drop_round_off_of_motion(MatrixXd& rates) const {
  double rate = 0.0;
  for (int i = 0; i < n_.n_v; ++i) rate = std::max(rate, std::abs(s_.v(i)) / eq_.velocity_scale(i));
  const double last_digits = 16.0 * std::numeric_limits<double>::epsilon();
  for (Index i = 0; i < n_w(); ++i)
    for (Index j = 0; j < n_z() + n_w(); ++j) {
      const int by = j < n_z() ? positions_[static_cast<std::size_t>(j)]
                               : independent_[static_cast<std::size_t>(j - n_z())];
      const double of_terms = (j < n_z() ? rate * rate : rate) *
                              eq_.velocity_scale(independent_[static_cast<std::size_t>(i)]) /
                              eq_.velocity_scale(by);
      if (std::abs(rates(n_z() + i, j)) <= last_digits * of_terms) rates(n_z() + i, j) = 0.0;
    }
}

LinearSystem Lineariser::system() {
  motions();
  accelerations();
  eliminate_algebraic();
  // z' = (W q + v), w' = v', c'.
  MatrixXd rates(n_x(), of_.q.cols());
  rates.topRows(n_z()) = sum(product(d_.W, of_.q), of_.v)(positions_, Eigen::all);
  rates.middleRows(n_z(), n_w()) = of_.v_dot(independent_, Eigen::all);
  rates.bottomRows(n_c()) = of_.c_rate(dynamic_, Eigen::all);
  drop_round_off_of_motion(rates);
  LinearSystem out;
  out.A = rates.leftCols(n_x());
  out.positions = positions_;
  out.independent = independent_;
  out.dynamic = dynamic_;
  out.N = N_;
  out.Q = of_.q.leftCols(n_x());
  out.V = of_.v.leftCols(n_x());
  const auto by_order = [&](const MatrixXd& X, int order) {
    MatrixXd by = MatrixXd::Zero(X.rows(), n_f() + n_s());
    by.rightCols(n_s()) = X.middleCols(at_u(order), n_s());
    if (order == 0) by.leftCols(n_f()) = X.rightCols(n_f());
    return by;
  };
  for (int order = 0; order < 3; ++order) {
    out.by_inputs.rates[order] = by_order(rates, order);
    out.by_inputs.q[order] = by_order(of_.q, order);
    out.by_inputs.v[order] = by_order(of_.v, order);
  }
  set_names(out);
  set_outputs(out);
  settle_inputs(out);
  // Rows of constraints along a motion are differences.
  if (n_.n_lambda > 0 && !s_.v.isZero(0.0)) out.relative_error = 1e-12;
  return out;
}

}  // namespace

LinearSystem linearise(const Equations& eq, const State& s, const LineariseOptions& options) {
  LinearSystem out = Lineariser(eq, s, options).system();
  return options.all_positions ? out : without_unread(std::move(out));
}

LinearSystem in_turning_axes(LinearSystem system, const Eigen::MatrixXd& W) {
  // dq = exp(t W) dq_K, so that dq_K' = dq' - W dq at t = 0, and dv likewise.
  const auto n_z = static_cast<Index>(system.positions.size()),
             n_w = static_cast<Index>(system.independent.size());
  const auto turn = [&](MatrixXd& rates, const MatrixXd& q, const MatrixXd& v) {
    rates.topRows(n_z) = sum(rates.topRows(n_z), -product(W, q)(system.positions, Eigen::all));
    rates.middleRows(n_z, n_w) =
        sum(rates.middleRows(n_z, n_w), -product(W, v)(system.independent, Eigen::all));
  };
  turn(system.A, system.Q, system.V);
  LinearSystem::ByInputs& by = system.by_inputs;
  for (int order = 0; order < 3; ++order) turn(by.rates[order], by.q[order], by.v[order]);
  settle_inputs(system);
  return system;
}

LinearSystem without_unread(LinearSystem out) {
  const auto n_z = static_cast<Index>(out.positions.size());
  std::vector<int> kept, positions;
  std::vector<std::string> states;
  for (Index i = 0; i < out.A.rows(); ++i) {
    const bool is_further =
        i < n_z && std::ranges::find(out.independent, out.positions[static_cast<std::size_t>(i)]) ==
                       out.independent.end();
    if (is_further && out.A.col(i).isZero(0.0) && out.C.col(i).isZero(0.0)) continue;
    kept.push_back(static_cast<int>(i));
    states.push_back(out.states[static_cast<std::size_t>(i)]);
    if (i < n_z) positions.push_back(out.positions[static_cast<std::size_t>(i)]);
  }
  if (static_cast<Index>(kept.size()) == out.A.rows()) return out;
  const auto pick = [&](MatrixXd& X, bool rows) {
    X = (rows ? MatrixXd(X(kept, Eigen::all)) : MatrixXd(X(Eigen::all, kept)));
  };
  pick(out.A, true);
  for (MatrixXd* X : {&out.A, &out.C, &out.Q, &out.V}) pick(*X, false);
  for (MatrixXd& B : out.by_inputs.rates) pick(B, true);
  out.x_0 = VectorXd(out.x_0(kept));
  out.states = std::move(states);
  out.positions = std::move(positions);
  settle_inputs(out);
  return out;
}

}  // namespace flexura::mbs
