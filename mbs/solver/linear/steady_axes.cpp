// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/steady_axes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// exp(A) of a small matrix, by its series after halving.
MatrixXd exponential(const MatrixXd& A) {
  const double size = A.cwiseAbs().rowwise().sum().maxCoeff();
  const int halvings = size > 0.1 ? static_cast<int>(std::ceil(std::log2(size / 0.1))) : 0;
  const MatrixXd B = std::ldexp(1.0, -halvings) * A;
  MatrixXd term = MatrixXd::Identity(A.rows(), A.cols()), sum = term;
  for (int k = 1; k <= 12; ++k) {
    term = term * B / k;
    sum += term;
  }
  for (int k = 0; k < halvings; ++k) sum = sum * sum;
  return sum;
}

}  // namespace

MatrixXd turned(const MatrixXd& W, double t) {
  std::vector<int> some;
  for (int i = 0; i < W.rows(); ++i)
    if (!W.row(i).isZero(0.0) || !W.col(i).isZero(0.0)) some.push_back(i);
  MatrixXd B = MatrixXd::Identity(W.rows(), W.cols());
  if (!some.empty()) B(some, some) = exponential(t * W(some, some).eval());
  return B;
}

// Commutator-free steps of order 4: S. Blanes, P. C. Moan, Appl. Numer. Math. 56 (2006) 1519-1537.
State along(const Mechanism& m, const MovingState& from, const TurningAxes& axes, double tau) {
  constexpr int kSteps = 100;
  State out = from.s;
  const double h = tau / kSteps, root = std::sqrt(3.0) / 6.0;
  const auto v_at = [&](double t) -> VectorXd {
    if (axes.accelerated) return from.s.v + t * from.v_dot;
    return axes.W.isZero(0.0) ? from.s.v : VectorXd(turned(axes.W, t) * from.s.v);
  };
  VectorXd p(out.p.size());
  for (int k = 0; k < kSteps; ++k) {
    const VectorXd v_1 = v_at((k + 0.5 - root) * h), v_2 = v_at((k + 0.5 + root) * h);
    m.retract(out.p, h * ((0.25 + root) * v_1 + (0.25 - root) * v_2), p);
    m.retract(p, h * ((0.25 - root) * v_1 + (0.25 + root) * v_2), out.p);
  }
  out.v = v_at(tau);
  if (axes.accelerated && out.c.size() > 0) out.c += tau * from.c_rate;
  return out;
}

std::vector<TurningAxes> candidate_axes(const Mechanism& m, const State& s, const VectorXd& v_dot,
                                        AccelerationSolver& accelerations, Equations::Scratch& scratch) {
  std::vector<TurningAxes> out = {{MatrixXd::Zero(s.v.size(), s.v.size()), "", false}};
  const auto add = [&](MatrixXd W, const std::string& name) {
    for (const TurningAxes& known : out)
      if ((known.W - W).isZero(1e-9 * (1.0 + W.cwiseAbs().maxCoeff()))) return;
    out.push_back({std::move(W), name, false});
  };
  add(m.turning_with_bodies(s, scratch), "axes that turn with the bodies");
  std::vector<MarkerState> bodies, soon;
  m.body_motions(s, v_dot, scratch, bodies);
  // w'' from the accelerations a little later, where |w'| is a turning of w.
  double rate = 0.0, quickest = 0.0;
  for (const MarkerState& body : bodies) {
    rate = std::max(rate, body.V.angular.norm());
    quickest = std::max({quickest, rate, std::sqrt(body.A.angular.norm())});
  }
  for (std::size_t b = 1; b < bodies.size(); ++b) {
    const std::string& name = m.description().bodies[b].name;
    const Vector3d w = bodies[b].V.angular, alpha = bodies[b].A.angular;
    if (w.norm() > 1e-9 * rate)
      add(m.turning_axes(s, w, scratch), fmt::format("axes that turn with \"{}\"", name));
    // What does not turn has no precession, however it gathers speed.
    if (!(w.norm() > 1e-9 * quickest) || !(alpha.norm() > 1e-9 * w.squaredNorm()) || out.size() > 8) continue;
    const double h = 1e-4 / quickest;
    Vector3d alpha_dot = Vector3d::Zero();
    for (const double side : {1.0, -1.0}) {
      State near = s;
      m.retract(s.p, side * h * s.v + 0.5 * h * h * v_dot, near.p);
      near.v += side * h * v_dot;
      VectorXd v_dot_near;
      accelerations.solve(near, v_dot_near);
      m.body_motions(near, v_dot_near, scratch, soon);
      alpha_dot += side / (2.0 * h) * soon[b].A.angular;
    }
    const Vector3d n = w.cross(alpha);
    if (!(n.squaredNorm() > 1e-18 * std::pow(w.norm(), 6))) continue;
    const Vector3d Omega = n / w.squaredNorm() + alpha_dot.dot(n) / n.squaredNorm() * w;
    add(m.turning_axes(s, Omega, scratch), fmt::format("axes that turn with the precession of \"{}\"", name));
  }
  return out;
}

}  // namespace flexura::mbs
