// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/algebra/accelerations.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/finite.hpp"

namespace flexura::mbs {

State make_state(const Equations& eq) {
  const Sizes n = eq.sizes();
  State s;
  s.p = Eigen::VectorXd::Zero(n.n_p);
  s.v = Eigen::VectorXd::Zero(n.n_v);
  s.c = Eigen::VectorXd::Zero(n.n_dyn);
  s.lambda = Eigen::VectorXd::Zero(n.n_lambda);
  s.a = Eigen::VectorXd::Zero(n.n_alg);
  s.root.assign(n.n_root, 0);
  return s;
}

struct AccelerationSolver::Factor : Eigen::PartialPivLU<Eigen::MatrixXd> {};

AccelerationSolver::~AccelerationSolver() = default;

AccelerationSolver::AccelerationSolver(const Equations& eq)
    : eq_(eq),
      n_(eq.sizes()),
      scratch_(eq.make_scratch()),
      mass_scratch_(eq.make_scratch()),
      lu_(std::make_unique<Factor>()) {
  r_.setZero(n_.n_v);
  c_rate_.setZero(n_.n_dyn);
  b_.setZero(n_.n_alg);
  g_ddot_.setZero(n_.n_lambda);
}

void AccelerationSolver::solve_algebraic(State& s) {
  if (n_.n_alg == 0) return;
  rest_.setZero(n_.n_v);
  J_.resize(n_.n_alg, n_.n_alg);
  b_step_.resize(n_.n_alg);
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 50; ++iteration) {
    eq_.momentum(s, rest_, *scratch_, r_, c_rate_, b_);
    require_finite_forces(eq_, s.t, r_, c_rate_, b_);
    const double now = b_.norm();
    if (now == 0.0 || (iteration > 2 && now >= 0.5 * before && now < 1e-9 * (1.0 + s.a.norm()))) return;
    before = now;
    trial_ = s;
    for (int j = 0; j < n_.n_alg; ++j) {
      const double h = 1.5e-8 * std::max(1.0, std::abs(s.a(j)));
      trial_.a(j) = s.a(j) + h;
      eq_.momentum(trial_, rest_, *scratch_, r_, c_rate_, b_step_);
      J_.col(j) = (b_step_ - b_) / h;
      trial_.a(j) = s.a(j);
    }
    b_step_ = -b_;
    lu_->compute(J_);
    step_ = lu_->solve(b_step_);
    if (!step_.allFinite()) step_ = J_.fullPivLu().solve(b_step_);  // at a singular point
    double alpha = 1.0;
    for (; alpha > 1e-4; alpha *= 0.5) {
      trial_.a = s.a + alpha * step_;
      eq_.momentum(trial_, rest_, *scratch_, r_, c_rate_, b_step_);
      if (b_step_.norm() < now) break;
    }
    if (alpha <= 1e-4) {
      if (step_.norm() <= 1e-9 * (1.0 + s.a.norm())) return;  // at the round-off of b
      break;
    }
    s.a = trial_.a;
    if (alpha * step_.norm() <= 1e-15 * (1.0 + s.a.norm())) return;
  }
  int worst = 0;
  b_.cwiseAbs().maxCoeff(&worst);
  throw std::runtime_error(
      fmt::format("the algebraic equation of \"{}\" has no solution near the present state at t = {:.9g} s "
                  "(residual {:.3g}): give a better start value or make the loop's gain such that the "
                  "equation can be solved for it",
                  eq_.name_of_algebraic(worst), s.t, b_(worst)));
}

bool AccelerationSolver::solve_recursively(State& s, Eigen::VectorXd& v_dot) {
  if (n_.n_lambda > 0 || !eq_.factor_mass(s.p, *mass_scratch_)) return false;
  v_dot.setZero(n_.n_v);
  // The second pass refines what the factors lost to round-off.
  for (int pass = 0; pass < 2; ++pass) {
    eq_.momentum(s, v_dot, *scratch_, r_, c_rate_, b_);
    require_finite_forces(eq_, s.t, r_, c_rate_, b_);
    eq_.solve_mass(*mass_scratch_, r_);
    v_dot -= r_;
    if (r_.lpNorm<Eigen::Infinity>() <= 1e-13 * v_dot.lpNorm<Eigen::Infinity>()) break;
  }
  return true;
}

void AccelerationSolver::solve(State& s, Eigen::VectorXd& v_dot) {
  const bool is_coupled = eq_.algebraic_is_coupled();
  if (!is_coupled) solve_algebraic(s);
  if (!is_coupled && solve_recursively(s, v_dot)) return;
  M_.setZero(n_.n_v, n_.n_v);
  G_.setZero(n_.n_lambda, n_.n_v);
  eq_.mass_matrix(s.p, *scratch_, M_);
  eq_.constraint_matrix(s, s.p, *scratch_, G_);
  saddle_.factor(eq_, M_, G_);
  v_dot = Eigen::VectorXd::Zero(n_.n_v);
  if (is_coupled)
    solve_coupled(saddle_, s, v_dot);
  else
    solve_linear(saddle_, s, v_dot);
}

// The second pass is one step of iterative refinement; more only where forces depend on the multipliers.
void AccelerationSolver::solve_linear(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot) {
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 20; ++pass) {
    const double change = improve(factors, s, v_dot);
    if (pass > 0 && (change < 1e-12 || change > 0.5 * before)) break;
    before = change;
  }
}

// For each a the accelerations and multipliers are those of the linear system, and b is what is left of the equation.
void AccelerationSolver::solve_coupled(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot) {
  const auto residual = [&](State& at, Eigen::VectorXd& at_v_dot, Eigen::VectorXd& b) {
    solve_linear(factors, at, at_v_dot);
    eq_.momentum(at, at_v_dot, *scratch_, r_, c_rate_, b_);
    require_finite_forces(eq_, at.t, r_, c_rate_, b_);
    b = b_;
  };
  J_.resize(n_.n_alg, n_.n_alg);
  b_step_.resize(n_.n_alg);
  residual(s, v_dot, b_now_);
  const auto enough = [&](const Eigen::VectorXd& b, const Eigen::VectorXd& a) {
    // Readings that are 0, as of a body that hangs at rest, have no size of their own: what is left then is far below
    // the round-off of any force.
    return b.lpNorm<Eigen::Infinity>() <= 1e-12 * a.lpNorm<Eigen::Infinity>() + 1e-30;
  };
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration < 50; ++iteration) {
    const double now = b_now_.norm();
    // Round-off of the linear system ends the descent.
    if (now == 0.0 || enough(b_now_, s.a) ||
        (iteration > 2 && now >= 0.5 * before && now < 1e-9 * (1.0 + s.a.norm())))
      return;
    before = now;
    for (int j = 0; j < n_.n_alg; ++j) {
      const double h = 1e-6 * std::max(1.0, std::abs(s.a(j)));
      trial_ = s;
      v_dot_trial_ = v_dot;
      trial_.a(j) += h;
      residual(trial_, v_dot_trial_, b_step_);
      J_.col(j) = (b_step_ - b_now_) / h;
    }
    step_ = J_.fullPivLu().solve(-b_now_);
    double alpha = 1.0;
    for (; alpha > 1e-4; alpha *= 0.5) {
      trial_ = s;
      v_dot_trial_ = v_dot;
      trial_.a += alpha * step_;
      residual(trial_, v_dot_trial_, b_step_);
      if (b_step_.norm() < (1.0 - 1e-3 * alpha) * now) break;
    }
    if (alpha <= 1e-4) {
      if (now < 1e-9 * (1.0 + s.a.norm())) return;
      break;
    }
    s = trial_;
    v_dot = v_dot_trial_;
    b_now_ = b_step_;
  }
  int worst = 0;
  b_now_.cwiseAbs().maxCoeff(&worst);
  throw std::runtime_error(fmt::format(
      "what reads \"{}\" changes it in turn so that accelerations and reactions cannot be solved at t = "
      "{:.9g} s ({:.3g} is left): where friction follows a load that it makes itself, a coefficient this "
      "large "
      "locks or has no solution; make it smaller, or let a control of type filter pass the reading on",
      eq_.name_of_algebraic(worst), s.t, b_now_(worst)));
}

// One pass; returns how much it changed, relative to what there is now, in the norm of the kinetic energy:
// v_dot / D and lambda / E (see SaddleSolver) are forces over roots of masses, both of them.
double AccelerationSolver::improve(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot) {
  eq_.momentum(s, v_dot, *scratch_, r_, c_rate_, b_);
  require_finite_forces(eq_, s.t, r_, c_rate_, b_);
  eq_.acceleration_constraints(s, s.p, s.v, v_dot, *scratch_, g_ddot_);
  r_ = -r_;
  g_ddot_ = -g_ddot_;
  factors.solve(r_, g_ddot_, dv_, dlambda_);
  v_dot += dv_;
  s.lambda += dlambda_;
  const auto size = [&](const Eigen::VectorXd& x, const Eigen::VectorXd& y) {
    double sum = x.cwiseQuotient(factors.column_scale()).squaredNorm();
    for (int k = 0; k < n_.n_lambda; ++k)
      if (const double scale = factors.row_scale()(k); scale > 0.0) sum += (y(k) / scale) * (y(k) / scale);
    return std::sqrt(sum);
  };
  return size(dv_, dlambda_) / (1e-300 + size(v_dot, s.lambda));
}

double AccelerationSolver::refine(SaddleSolver& factors, State& s, Eigen::VectorXd& v_dot, double enough) {
  // A pass costs O(n), new factors of a large mechanism far more: old ones serve while they take away most of
  // what is left.
  constexpr double slowest = 0.3;
  double before = improve(factors, s, v_dot), left = before;
  for (int pass = 0; pass < 20 && left > enough; ++pass) {
    const double change = improve(factors, s, v_dot);
    const double ratio = change / before;
    left = change;
    if (!(ratio < slowest)) break;
    left *= ratio / (1.0 - ratio);  // the sum of the passes to come
    before = change;
  }
  return left;
}

}  // namespace flexura::mbs
