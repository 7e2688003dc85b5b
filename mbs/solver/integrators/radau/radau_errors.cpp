// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/integrators/radau/radau_errors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace flexura::mbs {

namespace {

using Eigen::VectorXd;

// Between the last two nodes, where the polynomial through them lies furthest from what it interpolates.
constexpr double kBetweenNodes = 0.85;

double norm_of(const RadauErrors::Step& step, const VectorXd& x) {
  return std::sqrt(x.cwiseAbs2().dot(step.weights2) / step.n_norm);
}

}  // namespace

RadauErrors::RadauErrors(const Equations& eq, const RadauTableau& tableau, RadauMatrices& matrices)
    : eq_(eq),
      k_(tableau),
      matrices_(matrices),
      form_(matrices.form()),
      n_(eq.sizes()),
      scratch_(eq.make_scratch()) {
  for (VectorXd* x : {&stage_, &rate_, &step_, &rhs_, &x_, &error_}) x->setZero(form_.size());
  g_.setZero(n_.n_lambda);
}

double RadauErrors::local(const Step& step, bool again) {
  const std::array<VectorXd, 3>& Z = step.Z;
  stage_ = (k_.e[0] * Z[0] + k_.e[1] * Z[1] + k_.e[2] * Z[2]) / step.h;
  const auto estimate = [&] {
    matrices_.solve(rhs_, error_);
    error_.tail(form_.size() - form_.at_a()).setZero();
    return std::max(norm_of(step, error_), 1e-10);
  };
  rate_ = stage_ + step.yp;
  matrices_.multiply_rates(rate_, rhs_);
  double size = estimate();
  if (again && size >= 1.0) {
    // A second pass through the matrix damps what belongs to stiff components.
    x_ = step.y + error_;
    matrices_.multiply_rates(rate_, rhs_);
    if (form_.residual(step.t, x_, step.yp, step_)) {
      rhs_ -= step_;
      size = estimate();
    }
  }
  if (step.is_narrow) {
    // The matrix takes out of the error what is stiff in it, which may have ended within the step.
    x_ = step.h / k_.gamma * rate_;
    error_.segment(form_.at_v(), n_.n_v) = x_.segment(form_.at_v(), n_.n_v);
    size = std::max(size, norm_of(step, error_));
  }
  return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
}

// How far the step's polynomial lies from the constraints between its nodes, in units of the error allowed.
// The local error passes through Newton's matrix, which takes out of it what constraints prescribe: a driven
// loop has none at the nodes, however many turns a step takes, but positions, accelerations and forces
// between them would be nonsense.  Both are of order h^4.
double RadauErrors::between_nodes(const Step& step) {
  const std::array<VectorXd, 3>& Z = step.Z;
  if (n_.n_lambda == 0) return 0.0;
  stage_ = step.y;
  for (int j = 0; j < 3; ++j) stage_ += k_.basis(j, kBetweenNodes) * Z[j];
  form_.unpack(step.t + kBetweenNodes * step.h, stage_, between_);
  eq_.position_constraints(between_, between_.p, *scratch_, g_);
  rhs_.setZero();
  rhs_.tail(n_.n_lambda) = g_;
  matrices_.solve(rhs_, x_);
  x_.tail(x_.size() - n_.n_p).setZero();
  const double size = norm_of(step, x_);
  return std::isfinite(size) ? size : std::numeric_limits<double>::infinity();
}

}  // namespace flexura::mbs
