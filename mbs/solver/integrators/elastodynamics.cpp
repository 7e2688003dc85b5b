// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/elastodynamics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/remembered.hpp"
#include "mbs/solver/algebra/saddle.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/independent.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// The motion of the undeformed mechanism at one time, with v_dot and, of its state, lambda.
struct Nominal {
  State s;
  VectorXd v_dot;
};

// Deviations at one time; `a` is the auxiliary acceleration of generalised-alpha.
struct Deviation {
  VectorXd d, rate, acceleration, a, lambda;
  double at_rest = 0.0;  // how far the loads of this time would deform at rest, in scales of the coordinates
};

class Elastodynamics final : public Integrator {
 public:
  Elastodynamics(const Equations& eq, const SolverOptions& options)
      : eq_(eq), options_(options), n_(eq.sizes()), scratch_(eq.make_scratch()), tangents_(eq) {
    const auto stop_at = [](const std::string& what, const std::string& name) {
      throw std::invalid_argument(
          fmt::format("ked {}, and \"{}\" is one; use method = \"radau\"", what, name));
    };
    if (n_.n_dyn > 0) stop_at("knows no dynamic states", eq.name_of_dynamic(0));
    if (n_.n_alg > 0) stop_at("knows no algebraic states", eq.name_of_algebraic(0));
    for (int k = 0; k < n_.n_root; ++k)
      if (!eq.is_condition(k)) stop_at("does not locate switches", eq.name_of_root(k));
    for (int k = 0; k < n_.n_lambda; ++k)
      if (!eq.is_holonomic(k)) stop_at("takes drives of positions, not of speeds", eq.name_of_constraint(k));
    for (int i = 0; i < n_.n_p; ++i)
      if (eq.name_of_position(i).ends_with(".qw"))
        stop_at("takes coordinates that are angles and lengths, no quaternions", eq.name_of_position(i));
    hold_.keep_position.assign(static_cast<std::size_t>(n_.n_v), false);
    for (int i = 0; i < n_.n_v; ++i) {
      int i_p = -1;
      double stiffness = 0.0, damping = 0.0;
      if (!eq.elastic_coordinate(i, i_p, stiffness, damping)) continue;
      hold_.keep_position[static_cast<std::size_t>(i)] = true;
      elastic_.emplace_back(i, i_p);
    }
    hold_.keep_velocity = hold_.keep_position;
    is_rigid_ = hold_.keep_position;
    is_rigid_.flip();
    const double rho = options.rho_inf;
    alpha_m_ = (2.0 * rho - 1.0) / (rho + 1.0);
    alpha_f_ = rho / (rho + 1.0);
    gamma_ = 0.5 + alpha_f_ - alpha_m_;
    beta_ = 0.25 * (gamma_ + 0.5) * (gamma_ + 0.5);
  }

  void start(const State& s, const VectorXd& v_dot) override {
    State given = s;
    for (int& root : given.root) root = 0;  // formulas are as they are there
    require_driven(given);
    nominal_ = nominal_at(given, s.t);
    T_ = kinematic_map(nominal_.s.p);
    now_.d = T_.transpose() * (s.p - nominal_.s.p);
    now_.rate = s.v - nominal_.s.v;
    now_.acceleration = now_.a = v_dot - nominal_.v_dot;
    now_.lambda = s.lambda - nominal_.s.lambda;
    begin_ = now_;
    nominal_begin_ = nominal_;
    see_size(now_.d);
    h_ = options_.first_step > 0.0 ? options_.first_step : 1e-3 * options_.output_step;
    ++counts_.restarts;
  }

  StepEnd step(double t_stop) override {
    const double t = nominal_.s.t, left = t_stop - t,
                 least = options_.min_step > 0.0 ? options_.min_step
                                                 : 1e-12 * (options_.end_time - options_.start_time),
                 most = std::min(options_.longest_step(), options_.output_step);
    for (;;) {
      double h = std::min({options_.fixed_step > 0.0 ? options_.fixed_step : h_, most, left});
      if (left - h < 1e-3 * h) h = left;  // no rest that is round-off
      const double t_end = h == left ? t_stop : t + h;
      Nominal next;
      Deviation tried;
      try {
        next = nominal_at(moved(nominal_, h), t_end);
        tried = solved(next, h);
      } catch (const std::runtime_error& e) {
        ++counts_.newton_failures;
        h_ = 0.25 * h;
        if (h_ < least)
          throw IntegrationError(fmt::format("ked cannot go on beyond t = {:.9g} s: {}", t, e.what()));
        continue;
      }
      const double error = options_.fixed_step > 0.0 ? 0.0 : error_of(tried, h);
      // Of third order: what it will be at another length.
      const double factor = std::clamp(0.9 / std::cbrt(std::max(error, 1e-9)), 0.2, 2.0);
      if (error > 1.0) {
        ++counts_.error_failures;
        h_ = factor * h;
        if (h_ < least)
          throw IntegrationError(fmt::format("ked needs steps below {:.3g} s at t = {:.9g} s", least, t));
        continue;
      }
      if (h == std::min(h_, most) || factor < 1.0) h_ = factor * h;
      begin_ = std::move(now_);
      nominal_begin_ = std::move(nominal_);
      now_ = std::move(tried);
      nominal_ = std::move(next);
      see_size(now_.d);
      size_ = std::max(size_, now_.at_rest);
      ++counts_.steps;
      return {.t_begin = t, .t_end = t_end};
    }
  }

  void interpolate(double t, State& s, VectorXd& v_dot) override {
    if (t == nominal_.s.t) return put_together(nominal_, now_, s, v_dot);
    if (t == nominal_begin_.s.t) return put_together(nominal_begin_, begin_, s, v_dot);
    const double h = nominal_.s.t - nominal_begin_.s.t, x = (t - nominal_begin_.s.t) / h;
    const Nominal there = nominal_at(moved(nominal_begin_, x * h), t);
    // Hermite's cubic of d and d'.
    const double h_3 = x * x * (3.0 - 2.0 * x), h_2 = h * x * (1.0 - x) * (1.0 - x),
                 h_4 = -h * x * x * (1.0 - x), g_3 = 6.0 * x * (1.0 - x) / h,
                 g_2 = (1.0 - x) * (1.0 - 3.0 * x), g_4 = x * (3.0 * x - 2.0);
    Deviation between;
    between.d = (1.0 - h_3) * begin_.d + h_3 * now_.d + h_2 * begin_.rate + h_4 * now_.rate;
    between.rate = g_3 * (now_.d - begin_.d) + g_2 * begin_.rate + g_4 * now_.rate;
    between.acceleration = (1.0 - x) * begin_.acceleration + x * now_.acceleration;
    between.lambda = (1.0 - x) * begin_.lambda + x * now_.lambda;
    put_together(there, between, s, v_dot);
  }

  StepCounts counts() const override { return counts_; }

  void remember(History& history) override {
    for (Nominal* nominal : {&nominal_begin_, &nominal_}) {
      mbs::remember(history, nominal->s, n_);
      mbs::remember(history, nominal->v_dot, n_.n_v);
    }
    for (Deviation* deviation : {&begin_, &now_}) {
      for (VectorXd* x : {&deviation->d, &deviation->rate, &deviation->acceleration, &deviation->a})
        mbs::remember(history, *x, n_.n_v);
      mbs::remember(history, deviation->lambda, n_.n_lambda);
    }
    history(h_);
    history(size_);
    if (history.reads()) T_ = kinematic_map(nominal_.s.p);
  }

 private:
  // p' = T v; of angles and lengths each position is one velocity.
  MatrixXd kinematic_map(const VectorXd& p) const {
    MatrixXd T(n_.n_p, n_.n_v);
    VectorXd rate(n_.n_p);
    for (int i = 0; i < n_.n_v; ++i) {
      eq_.kinematic(p, VectorXd::Unit(n_.n_v, i), rate);
      T.col(i) = rate;
    }
    return T;
  }

  State moved(const Nominal& from, double h) const {
    State s = from.s;
    VectorXd p(n_.n_p);
    const VectorXd d = h * s.v + 0.5 * h * h * from.v_dot;
    eq_.retract(from.s.p, d, p);
    s.p = p;
    s.v += h * from.v_dot;
    return s;
  }

  // The undeformed mechanism at t, from a guess.
  Nominal nominal_at(State s, double t) {
    s.t = t;
    for (const auto& [i_v, i_p] : elastic_) s.p(i_p) = s.v(i_v) = 0.0;
    AssembleReport report = assemble_positions(eq_, s, hold_);
    if (report.positions_kept) assemble_velocities(eq_, s, hold_, report);
    if (!report.positions_kept || !report.velocities_kept)
      throw std::runtime_error(
          "the loops do not close without deformation, which the nominal motion has none of; use method = "
          "\"radau\"");
    Nominal out{.s = std::move(s), .v_dot = VectorXd::Zero(n_.n_v)};
    M_.setZero(n_.n_v, n_.n_v);
    G_.setZero(n_.n_lambda, n_.n_v);
    eq_.mass_matrix(out.s.p, *scratch_, M_);
    eq_.constraint_matrix(out.s, out.s.p, *scratch_, G_);
    // Rows that only deformation changes say nothing here.
    MatrixXd G_rigid = G_;
    for (const auto& [i_v, i_p] : elastic_) G_rigid.col(i_v).setZero();
    for (int k = 0; k < n_.n_lambda; ++k)
      if (G_rigid.row(k).norm() < 1e-9 * G_.row(k).norm()) G_rigid.row(k).setZero();
    saddle_.factor(eq_, M_, G_rigid, is_rigid_);
    VectorXd r(n_.n_v), c(n_.n_dyn), b(n_.n_alg), g(n_.n_lambda), dv, dlambda;
    for (int pass = 0; pass < 2; ++pass) {  // the second refines
      eq_.momentum(out.s, out.v_dot, *scratch_, r, c, b);
      eq_.acceleration_constraints(out.s, out.s.p, out.s.v, out.v_dot, *scratch_, g);
      for (int k = 0; k < n_.n_lambda; ++k)
        if (G_rigid.row(k).isZero(0.0)) g(k) = 0.0;
      const VectorXd right = -r, h = -g;
      saddle_.solve(right, h, dv, dlambda);
      out.v_dot += dv;
      out.s.lambda += dlambda;
      ++counts_.evaluations;
    }
    return out;
  }

  // The linear system of the step that ends at `next`.
  Deviation solved(const Nominal& next, double h) {
    VectorXd r(n_.n_v), c(n_.n_dyn), b(n_.n_alg), g(n_.n_lambda);
    eq_.momentum(next.s, next.v_dot, *scratch_, r, c, b);
    eq_.position_constraints(next.s, next.s.p, *scratch_, g);
    tangents_.evaluate(next.s, next.v_dot);
    ++counts_.jacobians;
    const MatrixXd &M = tangents_.M, &G = tangents_.G;
    const MatrixXd C = tangents_.z_v.topRows(n_.n_v), K = tangents_.z_p.topRows(n_.n_v) * T_;

    Deviation out;
    for (const auto& [i_v, i_p] : elastic_)
      if (K(i_v, i_v) > 0.0)
        out.at_rest = std::max(out.at_rest, std::abs(r(i_v)) / K(i_v, i_v) / eq_.position_scale(i_p));
    const double share = (1.0 - alpha_m_) / (1.0 - alpha_f_);
    const VectorXd before = (alpha_m_ * now_.a - alpha_f_ * now_.acceleration) / (1.0 - alpha_f_),
                   d = now_.d + h * now_.rate + h * h * (0.5 - beta_) * now_.a,
                   rate = now_.rate + h * (1.0 - gamma_) * now_.a;
    // Unknowns h^2 a_1 and dlambda, in units of inertia and of the rows.
    const VectorXd unit = M.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    VectorXd row = (G * unit.asDiagonal()).rowwise().norm();
    for (double& x : row) x = x > 0.0 ? 1.0 / x : 1.0;
    const Eigen::Index n = n_.n_v + n_.n_lambda;
    MatrixXd A = MatrixXd::Zero(n, n);
    A.topLeftCorner(n_.n_v, n_.n_v) =
        unit.asDiagonal() * (share * M + gamma_ * h * C + beta_ * h * h * K) * unit.asDiagonal();
    A.topRightCorner(n_.n_v, n_.n_lambda) = unit.asDiagonal() * G.transpose() * row.asDiagonal();
    A.bottomLeftCorner(n_.n_lambda, n_.n_v) = A.topRightCorner(n_.n_v, n_.n_lambda).transpose();
    VectorXd right(n);
    right.head(n_.n_v) = unit.cwiseProduct(-r - M * before - C * rate - K * d);
    right.tail(n_.n_lambda) = row.cwiseProduct(-g - G * d) / (beta_ * h * h);
    const Eigen::FullPivLU<MatrixXd> lu(A);
    const VectorXd x = lu.solve(right);
    if (!x.allFinite() || (A * x - right).norm() > 1e-6 * right.norm() + 1e-300)
      throw std::runtime_error("its constraints contradict each other to first order; take one of them away");
    out.a = unit.cwiseProduct(x.head(n_.n_v));
    out.lambda = row.cwiseProduct(x.tail(n_.n_lambda));
    out.d = d + h * h * beta_ * out.a;
    out.rate = rate + h * gamma_ * out.a;
    out.acceleration = share * out.a + before;
    return out;
  }

  // The local error against the tolerance, by what the run has deformed so far, or its loads would at rest.
  double error_of(const Deviation& tried, double h) const {
    double error = 0.0, size = std::max(size_, tried.at_rest);
    for (const auto& [i_v, i_p] : elastic_)
      size = std::max(size, std::abs(tried.d(i_v)) / eq_.position_scale(i_p));
    if (size == 0.0) return 0.0;
    for (const auto& [i_v, i_p] : elastic_)
      error = std::max(error, std::abs(beta_ - 1.0 / 6.0) * h * h * std::abs(tried.a(i_v) - now_.a(i_v)) /
                                  eq_.position_scale(i_p));
    return error / (options_.tolerance * size);
  }
  void see_size(const VectorXd& d) {
    for (const auto& [i_v, i_p] : elastic_)
      size_ = std::max(size_, std::abs(d(i_v)) / eq_.position_scale(i_p));
  }

  // Superposed, and the loops closed by what is rigid: they are open by the square of d.
  void put_together(const Nominal& nominal, const Deviation& deviation, State& s, VectorXd& v_dot) const {
    s = nominal.s;
    s.p += T_ * deviation.d;
    s.v += deviation.rate;
    s.lambda += deviation.lambda;
    v_dot = nominal.v_dot + deviation.acceleration;
    AssembleReport report = assemble_positions(eq_, s, hold_);
    assemble_velocities(eq_, s, hold_, report);
  }

  // Throws where a rigid freedom is left.
  void require_driven(const State& s) const {
    MatrixXd M(n_.n_v, n_.n_v), G(n_.n_lambda, n_.n_v);
    eq_.mass_matrix(s.p, *scratch_, M);
    eq_.constraint_matrix(s, s.p, *scratch_, G);
    std::vector<int> rigid;
    for (int i = 0; i < n_.n_v; ++i)
      if (is_rigid_[static_cast<std::size_t>(i)]) rigid.push_back(i);
    MatrixXd G_r = G(Eigen::all, rigid);
    for (int k = 0; k < n_.n_lambda; ++k)
      if (G_r.row(k).norm() < 1e-9 * G.row(k).norm()) G_r.row(k).setZero();
    std::vector<std::string> names;
    for (const int i : independent_coordinates(M(rigid, rigid), G_r).independent)
      names.push_back("\"" + eq_.name_of_velocity(rigid[static_cast<std::size_t>(i)]) + "\"");
    if (!names.empty())
      throw std::invalid_argument(fmt::format(
          "ked needs every freedom driven, and {} of them {} not ({} would determine the rest): drive {}, "
          "or use method = \"radau\"",
          names.size(), names.size() == 1 ? "is" : "are", fmt::join(names, ", "),
          names.size() == 1 ? "it" : "them"));
  }

  const Equations& eq_;
  SolverOptions options_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  Tangents tangents_;
  SaddleSolver saddle_;
  AssembleOptions hold_;
  std::vector<bool> is_rigid_;
  std::vector<std::pair<int, int>> elastic_;  // velocity and position
  MatrixXd T_, M_, G_;
  double alpha_m_ = 0.0, alpha_f_ = 0.0, beta_ = 0.0, gamma_ = 0.0;
  Nominal nominal_begin_, nominal_;
  Deviation begin_, now_;
  double h_ = 0.0, size_ = 0.0;
  StepCounts counts_;
};

}  // namespace

std::unique_ptr<Integrator> make_elastodynamics(const Equations& eq, const SolverOptions& options) {
  return std::make_unique<Elastodynamics>(eq, options);
}

}  // namespace flexura::mbs
