// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/whirl.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace flexura::mbs {

FixedAxes::FixedAxes(const Mechanism& mechanism, const State& s, const SteadyLinearisation& about)
    : m_(mechanism), s_(s), about_(about), rates_{Vector3d::Zero()} {
  std::vector<MarkerState> bodies;
  const auto scratch = m_.make_scratch();
  m_.body_motions(s_, Eigen::VectorXd::Zero(m_.sizes().n_v), *scratch, bodies);
  Vector3d fastest = Vector3d::Zero();
  for (const MarkerState& body : bodies) {
    const Vector3d w = body.V.angular;
    if (w.norm() > fastest.norm()) fastest = w;
    if (std::ranges::none_of(rates_,
                             [&](const Vector3d& one) { return (one - w).norm() <= 1e-9 * w.norm(); }))
      rates_.push_back(w);
  }
  if (about.verdict != SteadyLinearisation::Verdict::steady_motion || fastest.isZero(0.0))
    throw std::invalid_argument(
        "--fixed-axes translates the modes of a mechanism that turns steadily, and this one does not: leave "
        "it "
        "out");
  n_ = fastest.normalized();
}

// Of every body: of its origin [m], and its rotation [rad], all in W.
Eigen::VectorXcd FixedAxes::displacements(const State& s, const Eigen::VectorXcd& d) const {
  const auto scratch = m_.make_scratch();
  Eigen::VectorXcd out(6 * m_.description().bodies.size());
  std::vector<MarkerState> bodies;
  State moving = s;
  const auto twists = [&](const Eigen::VectorXd& v) {
    moving.v = v;
    m_.body_motions(moving, Eigen::VectorXd::Zero(v.size()), *scratch, bodies);
    Eigen::VectorXd all(out.size());
    for (std::size_t b = 0; b < bodies.size(); ++b)
      all.segment<6>(6 * static_cast<Eigen::Index>(b)) << bodies[b].V.linear, bodies[b].V.angular;
    return all;
  };
  out.real() = twists(d.real());
  out.imag() = twists(d.imag());
  return out;
}

std::vector<Whirl> FixedAxes::of(const NaturalMode& mode) const {
  const Eigen::VectorXcd now = displacements(s_, mode.shape),
                         then = displacements(about_.later, about_.moved * mode.shape);
  const double size = now.norm();
  if (!(size > 0.0)) return {};
  double least = 1e-4 * size;  // the map's positions are right to some 1e-8
  const Vector3d* rate = nullptr;
  for (const Vector3d& w : rates_) {
    const Matrix3d R = rotation_exp(about_.tau * w);
    double gap = 0.0;
    for (Eigen::Index k = 0; k + 3 <= now.size(); k += 3)
      gap += (then.segment<3>(k) - R.cast<std::complex<double>>() * now.segment<3>(k)).squaredNorm();
    if (std::sqrt(gap) < least) {
      least = std::sqrt(gap);
      rate = &w;
    }
  }
  if (rate == nullptr || !(rate->cross(n_).norm() <= 1e-9 * rate->norm())) return {};
  const Matrix3d frame = frame_along(n_);  // x, y, n
  double forward = 0.0, backward = 0.0, along = 0.0;
  for (Eigen::Index k = 0; k + 3 <= now.size(); k += 3) {
    const Eigen::Vector3cd u = frame.transpose().cast<std::complex<double>>() * now.segment<3>(k);
    const std::complex<double> i(0.0, 1.0);
    forward += 0.5 * std::norm(u(0) + i * u(1));
    backward += 0.5 * std::norm(u(0) - i * u(1));
    along += std::norm(u(2));
  }
  const double all = forward + backward + along, w = mode.eigenvalue.imag(), Omega = rate->dot(n_);
  const double hz = 1.0 / (2.0 * std::numbers::pi);
  std::vector<Whirl> out = {{Whirl::Kind::circular, (Omega + w) * hz, forward / all},
                            {Whirl::Kind::circular, (Omega - w) * hz, backward / all},
                            {Whirl::Kind::along, w * hz, along / all}};
  std::erase_if(out, [](const Whirl& one) { return one.share < 1e-3; });
  std::ranges::sort(out, std::greater(), &Whirl::share);
  return out;
}

}  // namespace flexura::mbs
