// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/ancf_statics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::beam::ancf {

namespace {

constexpr int kMixedIterations = 15;
// A slope that turns by more than a radian in one iteration has left the solution's neighbourhood.
constexpr double kLargestStep = 2.0;

class Newton {
 public:
  Newton(const Problem& problem, const StaticOptions& options)
      : problem_(problem),
        options_(options),
        scratch_(problem),
        solver_(problem.free_coordinates(), problem.n_lambda()) {}

  /// Solves at factor t from a neighbouring solution; false when neither iteration converges.
  bool solve(double t, Eigen::VectorXd& q, Eigen::VectorXd& lambda) {
    Eigen::VectorXd q_mixed = q, lambda_mixed = lambda;
    for (Eigen::VectorXd* start : {&q, &q_mixed})
      for (const Drive& drive : problem_.drives) (*start)[drive.coordinate] = drive.motion(t)[0];
    if (iterate_mixed(t, q_mixed, lambda_mixed)) {
      q = q_mixed;
      lambda = lambda_mixed;
      return true;
    }
    return iterate_damped(t, q, lambda);
  }

  int iterations = 0;

 private:
  bool iterate_mixed(double t, Eigen::VectorXd& q, Eigen::VectorXd& lambda) {
    Eigen::VectorXd q_before = q;
    double previous = INFINITY;
    for (int i = 0; i < kMixedIterations; ++i) {
      ++iterations;
      evaluate(problem_, t, q, nullptr, lambda, scratch_, at_, &q_before);
      if (!at_.r.allFinite() || !solver_.factor(at_.K, at_.G)) return false;
      solver_.solve(-at_.r, -at_.g, dq_, dlambda_);
      const double size = norm(dq_);
      if (!std::isfinite(size) || size > kLargestStep) return false;
      q_before = q;
      q += dq_;
      lambda += dlambda_;
      if (is_small(size, previous)) return true;
      previous = size;
    }
    return false;
  }

  bool iterate_damped(double t, Eigen::VectorXd& q, Eigen::VectorXd& lambda) {
    double previous = INFINITY;
    evaluate(problem_, t, q, nullptr, lambda, scratch_, at_);
    for (int i = 0; i < options_.max_iterations; ++i) {
      ++iterations;
      if (!solver_.factor(at_.K, at_.G)) return false;
      solver_.solve(-at_.r, -at_.g, dq_, dlambda_);
      const double size = norm(dq_);
      if (!std::isfinite(size)) return false;
      if (is_small(size, previous)) {
        q += dq_;
        lambda += dlambda_;
        return true;
      }
      previous = size;
      if (!step(t, size, q, lambda)) return false;
    }
    return false;
  }

  // At the round-off floor corrections stop shrinking: there is nothing left to gain.
  bool is_small(double size, double previous) const {
    return size < options_.tolerance || (size < 1e-6 && size > 0.5 * previous);
  }

  // Takes the longest of the steps 1, 1/2, ... 1/64 that the simplified correction approves of.
  bool step(double t, double size, Eigen::VectorXd& q, Eigen::VectorXd& lambda) {
    for (double s = 1.0; s > 0.01; s *= 0.5) {
      const Eigen::VectorXd q_trial = q + s * dq_, lambda_trial = lambda + s * dlambda_;
      evaluate(problem_, t, q_trial, nullptr, lambda_trial, scratch_, trial_);
      if (!trial_.r.allFinite()) continue;
      solver_.solve(-trial_.r, -trial_.g, dq_bar_, dlambda_bar_);
      if (norm(dq_bar_) <= (1 - 0.25 * s) * size || size < 1e-6) {
        q = q_trial;
        lambda = lambda_trial;
        std::swap(at_, trial_);
        return true;
      }
    }
    return false;
  }

  double norm(const Eigen::VectorXd& dq) const {
    const AncfBody& body = *problem_.body;
    double largest = 0.0;
    for (int i = 0; i < dq.size(); ++i) {
      const bool is_position = i % body.node_coordinates() < body.dim();
      const double value = std::abs(dq[i]) / (is_position ? body.length() : 1.0);
      if (!(value <= largest)) largest = value;  // lets NaN through
    }
    return largest;
  }

  const Problem& problem_;
  const StaticOptions& options_;
  ProblemScratch scratch_;
  SaddleSolver solver_;
  Evaluation at_, trial_;
  Eigen::VectorXd dq_, dlambda_, dq_bar_, dlambda_bar_;
};

}  // namespace

StaticResult solve_static(const Problem& problem, const Eigen::VectorXd& q_start,
                          const StaticOptions& options) {
  if (q_start.size() != problem.body->n_q())
    throw std::invalid_argument(
        fmt::format("the start configuration has {} coordinates, but the body has {}.", q_start.size(),
                    problem.body->n_q()));
  if (options.steps < 1)
    throw std::invalid_argument(fmt::format("{} load steps asked for; at least one.", options.steps));
  Newton newton(problem, options);
  StaticResult result{q_start, Eigen::VectorXd::Zero(problem.n_lambda()), 0, 0};
  Eigen::VectorXd q_before = q_start;
  double t = 0.0, step = 1.0 / options.steps, step_before = 0.0;
  while (t < 1.0) {
    // The last step may be a little longer: no sliver of round-off is left over.
    const double t_next = t + step > 1.0 - 1e-9 ? 1.0 : t + step;
    Eigen::VectorXd q = result.q, lambda = result.lambda;
    if (step_before > 0.0) q += (t_next - t) / step_before * (result.q - q_before);
    const int before = newton.iterations;
    if (newton.solve(t_next, q, lambda)) {
      q_before = result.q;
      step_before = t_next - t;
      result.q = q;
      result.lambda = lambda;
      t = t_next;
      ++result.steps;
      if (newton.iterations - before < 8) step *= 1.5;
    } else {
      step *= 0.5;
      if (step < options.smallest_step)
        throw std::runtime_error(fmt::format(
            "the static solution was lost at load factor {:.6g} after {} Newton iterations: the structure "
            "may buckle or move freely there; check supports, or start nearer to the solution.",
            t, newton.iterations));
    }
  }
  result.iterations = newton.iterations;
  return result;
}

}  // namespace flexura::beam::ancf
