// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/dynamics.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace flexura::beam::ancf {

namespace {

using Eigen::VectorXd;

class Integrator {
 public:
  Integrator(const Problem& problem, const DynamicOptions& options)
      : problem_(problem),
        options_(options),
        scratch_(problem),
        solver_(problem.free_coordinates(), problem.n_lambda()) {
    problem.body->mass().append_to(mass_);
  }

  DynamicState start(const VectorXd& q, const VectorXd& v) {
    DynamicState s{0.0, q, v, VectorXd::Zero(q.size()), VectorXd::Zero(problem_.n_lambda())};
    drive(s);
    evaluate(problem_, 0.0, s.q, &s.v, s.lambda, scratch_, at_);
    problem_.body->mass().multiply_add(1.0, s.a, at_.r);
    if (!solver_.factor(mass_, at_.G))
      throw std::runtime_error(
          "the mass matrix with its constraints is singular at the start; is a constraint redundant?");
    VectorXd a, lambda;
    solver_.solve(-at_.r, -constraint_curvature(s), a, lambda);
    s.a += a;
    s.lambda = lambda;
    w_ = s.a;
    return s;
  }

  void step(DynamicState& s) {
    const double h = options_.dt, rho = options_.rho_inf;
    const double alpha_m = (2 * rho - 1) / (rho + 1), alpha_f = rho / (rho + 1);
    const double gamma = 0.5 + alpha_f - alpha_m, beta = 0.25 * (gamma + 0.5) * (gamma + 0.5);
    const double to_a = (1 - alpha_m) / (h * h * beta * (1 - alpha_f)), to_v = gamma / (h * beta);

    // Predict with the old acceleration held.
    VectorXd w = (s.a - alpha_m * w_) / (1 - alpha_m);
    s.q += h * s.v + h * h * ((0.5 - beta) * w_ + beta * w);
    s.v += h * ((1 - gamma) * w_ + gamma * w);
    const VectorXd a_before = s.a;
    s.t += h;
    drive(s);

    VectorXd dq, dlambda;
    double previous = INFINITY;
    for (int i = 0;; ++i) {
      evaluate(problem_, s.t, s.q, &s.v, s.lambda, scratch_, at_);
      problem_.body->mass().multiply_add(1.0, s.a, at_.r);
      Triplets S = at_.K;
      for (const auto& entry : at_.D) S.emplace_back(entry.row(), entry.col(), to_v * entry.value());
      for (const auto& entry : mass_) S.emplace_back(entry.row(), entry.col(), to_a * entry.value());
      if (!solver_.factor(S, at_.G)) fail(s.t, "the iteration matrix is singular");
      solver_.solve(-at_.r, -at_.g, dq, dlambda);
      s.q += dq;
      s.v += to_v * dq;
      s.a += to_a * dq;
      s.lambda += dlambda;
      const double size = norm(dq);
      if (!std::isfinite(size)) fail(s.t, "the state is no longer finite");
      if (size < options_.tolerance || (size < 1e-7 && size > 0.5 * previous)) break;
      if (i + 1 == options_.max_iterations) fail(s.t, "Newton's iteration does not converge");
      previous = size;
    }
    // The free part of w follows a; driven coordinates have w = a.
    w += (1 - alpha_f) / (1 - alpha_m) * (s.a - a_before);
    for (const Drive& d : problem_.drives) w[d.coordinate] = s.a[d.coordinate];
    w_ = w;
  }

 private:
  void drive(DynamicState& s) const {
    for (const Drive& d : problem_.drives) {
      const Eigen::Vector3d m = d.motion(s.t);
      s.q[d.coordinate] = m[0];
      s.v[d.coordinate] = m[1];
      s.a[d.coordinate] = m[2];
    }
    for (const int c : problem_.fixed) s.v[c] = s.a[c] = 0.0;
  }

  // d2 g/dt2 along q + t v + t^2 a/2 (a: of the drives), by central differences; exact for rows quadratic in
  // time.
  VectorXd constraint_curvature(const DynamicState& s) const {
    const double h = 1e-2 * options_.dt;
    VectorXd out(problem_.n_lambda());
    int row = 0;
    for (const auto& constraint : problem_.constraints) {
      const int n = constraint->rows();
      VectorXd plus(n), centre(n), minus(n);
      constraint->evaluate(s.t + h, s.q + h * s.v + 0.5 * h * h * s.a, plus, nullptr);
      constraint->evaluate(s.t, s.q, centre, nullptr);
      constraint->evaluate(s.t - h, s.q - h * s.v + 0.5 * h * h * s.a, minus, nullptr);
      out.segment(row, n) = (plus - 2 * centre + minus) / (h * h);
      row += n;
    }
    return out;
  }

  double norm(const VectorXd& dq) const {
    const AncfBody& body = *problem_.body;
    double largest = 0.0;
    for (int i = 0; i < dq.size(); ++i) {
      const bool is_position = i % body.node_coordinates() < body.dim();
      const double value = std::abs(dq[i]) / (is_position ? body.length() : 1.0);
      if (!(value <= largest)) largest = value;
    }
    return largest;
  }

  [[noreturn]] void fail(double t, const char* what) const {
    throw std::runtime_error(
        fmt::format("{} at t = {:.6g} s with dt = {:.3g} s; a smaller step may help.", what, t, options_.dt));
  }

  const Problem& problem_;
  const DynamicOptions& options_;
  ProblemScratch scratch_;
  SaddleSolver solver_;
  Triplets mass_;
  Evaluation at_;
  VectorXd w_;
};

}  // namespace

DynamicState simulate(const Problem& problem, const VectorXd& q, const VectorXd& v, double t_end,
                      const DynamicOptions& options, const Observer& observer) {
  if (!(options.dt > 0.0))
    throw std::invalid_argument(fmt::format("dt is {:g} s, but it must be positive.", options.dt));
  if (!(options.rho_inf >= 0.0 && options.rho_inf <= 1.0))
    throw std::invalid_argument(
        fmt::format("rho_inf is {:g}, but it must lie between 0 and 1.", options.rho_inf));
  if (q.size() != problem.body->n_q() || v.size() != q.size())
    throw std::invalid_argument(fmt::format("the start state has {} and {} coordinates, but the body has {}.",
                                            q.size(), v.size(), problem.body->n_q()));
  Integrator integrator(problem, options);
  DynamicState s = integrator.start(q, v);
  if (observer) observer(s);
  const long n_steps = std::lround(std::ceil(t_end / options.dt - 1e-9));
  for (long i = 1; i <= n_steps; ++i) {
    integrator.step(s);
    s.t = static_cast<double>(i) * options.dt;  // no sum of round-offs
    if (observer) observer(s);
  }
  return s;
}

}  // namespace flexura::beam::ancf
