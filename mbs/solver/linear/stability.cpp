// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/stability.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/linear/static_stiffness.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Verdict = Stability::Verdict;

// Damping in parts of the largest: what differences leave of elements without derivatives of their own (1e-8).
constexpr double kNoDampingForce = 1e-7;
// In parts of its noise, beyond which an unsymmetric part of the stiffness is one.
constexpr double kUnsymmetric = 10.0;
// A damping ratio that the errors of A's differences (1e-9) do not make.
constexpr double kNoDamping = 1e-6;
// Two zero eigenvalues are found apart by the square root of these errors, times what the motion's own rate
// makes of them.
constexpr double kNoGrowth = 1e-4;

int largest_of(const VectorXd& d) {
  Eigen::Index k = 0;
  if (d.size() > 0) d.cwiseAbs().maxCoeff(&k);
  return static_cast<int>(k);
}

}  // namespace

Stability stability_of(const Equations& eq, const LinearSystem& system, double rate) {
  Stability out;
  if (system.A.rows() == 0) {
    out.verdict = Verdict::stable;  // nothing moves
    return out;
  }
  bool all_decay = true;
  for (const NaturalMode& mode : natural_modes(system)) {
    const double real = mode.eigenvalue.real(), size = std::abs(mode.eigenvalue);
    // The errors of two zeros make any pair this small.
    if (size <= kNoGrowth * std::max(rate, 1.0)) {
      all_decay = false;
      continue;
    }
    const double bound = std::max(kNoDamping * size, mode.noise);
    if (real > bound && real > out.growth) {
      out.growth = real;
      VectorXd d = mode.shape.cwiseAbs();
      for (Eigen::Index i = 0; i < d.size(); ++i) d(i) /= eq.velocity_scale(static_cast<int>(i));
      out.coordinate = largest_of(d);
      out.verdict = Verdict::unstable;
    }
    all_decay = all_decay && real < -bound;
  }
  if (out.verdict != Verdict::unstable && all_decay) out.verdict = Verdict::stable;
  return out;
}

Stability stability_at_rest(const Equations& eq, const State& s) {
  const Sizes n = eq.sizes();
  Stability out;
  if (n.n_v == 0 && n.n_dyn == 0) {
    out.verdict = Verdict::stable;
    return out;
  }
  for (int k = 0; k < n.n_lambda; ++k)
    if (!eq.is_holonomic(k)) return stability_of(eq, linearise(eq, s), 0.0);
  if (n.n_dyn > 0 || n.n_alg > 0) return stability_of(eq, linearise(eq, s), 0.0);
  const StaticStiffness z = static_stiffness(eq, s);
  const auto n_z = static_cast<Eigen::Index>(z.independent.size());
  if (n_z == 0) {
    out.verdict = Verdict::stable;
    return out;
  }
  Tangents tangents(eq);
  tangents.evaluate(s, VectorXd::Zero(n.n_v));
  // Each coordinate as stiff as the others.
  VectorXd unit(n_z);
  for (Eigen::Index i = 0; i < n_z; ++i)
    unit(i) = z.K(i, i) != 0.0 ? 1.0 / std::sqrt(std::abs(z.K(i, i))) : 1.0;
  const auto scaled = [&](const MatrixXd& X) -> MatrixXd {
    return unit.asDiagonal() * X * unit.asDiagonal();
  };
  const MatrixXd K = scaled(z.K), E = scaled(z.error),
                 D = scaled(z.N.transpose() * tangents.z_v.topRows(n.n_v) * z.N);
  const auto symmetric = [](const MatrixXd& X) { return MatrixXd(0.5 * (X + X.transpose())); };
  if (((K - K.transpose()).cwiseAbs() - kUnsymmetric * (E + E.transpose())).maxCoeff() > 0.0)
    return stability_of(eq, linearise(eq, s), 0.0);
  const double damping = D.cwiseAbs().maxCoeff();
  if (damping > 0.0) {
    const double least =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric(D), Eigen::EigenvaluesOnly).eigenvalues()(0);
    if (least < -kNoDampingForce * damping) return stability_of(eq, linearise(eq, s), 0.0);
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> stiff(symmetric(K));
  const VectorXd softest = stiff.eigenvectors().col(0);
  const double least = stiff.eigenvalues()(0), bound = kBeyondNoise * noise_of(softest, E, softest);
  if (least > bound) {
    out.verdict = Verdict::stable;
    return out;
  }
  const VectorXd d = z.N * (unit.asDiagonal() * softest);
  VectorXd relative = d;
  for (int i = 0; i < n.n_v; ++i) relative(i) /= eq.velocity_scale(i);
  out.coordinate = largest_of(relative);
  if (!(least < -bound)) return out;
  out.verdict = Verdict::unstable;
  // Growth along this direction alone, whose damping slows it: m r^2 + c r + k = 0.
  const double m = d.dot(tangents.M * d), c = d.dot(tangents.z_v.topRows(n.n_v) * d), k = least;
  out.growth = m > 0.0 ? (-c + std::sqrt(std::max(c * c - 4.0 * m * k, 0.0))) / (2.0 * m) : 0.0;
  return out;
}

std::string sentence(const Equations& eq, const Stability& stability, const std::string& what) {
  if (stability.verdict == Verdict::unstable)
    return fmt::format("{} is unstable: a disturbance grows, most in \"{}\", about as exp({:.3g} t)", what,
                       stability.coordinate >= 0 ? eq.name_of_velocity(stability.coordinate) : "",
                       stability.growth);
  if (stability.verdict == Verdict::unknown && stability.coordinate >= 0)
    return fmt::format("whether {} is stable is unknown: \"{}\" moves without stiffness", what,
                       eq.name_of_velocity(stability.coordinate));
  return {};
}

std::string name_of(Verdict verdict) {
  return verdict == Verdict::stable ? "stable" : verdict == Verdict::unstable ? "unstable" : "unknown";
}

}  // namespace flexura::mbs
