// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/stability.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

#include "mbs/solver/kinematic_blocks.hpp"
#include "mbs/solver/tangents.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Verdict = Stability::Verdict;

// Of the stiffest direction, in units of stiffness: below it lies what differences leave of elements without
// derivatives of their own (1e-8).
constexpr double kNoStiffness = 1e-7;
// A damping ratio that the errors of A's differences (1e-9) do not make.
constexpr double kNoDamping = 1e-6;
// Two zero eigenvalues are found apart by the square root of these errors, times what the motion's own rate
// makes of them.
constexpr double kNoGrowth = 1e-4;

// Columns span what G lets free, as lengths of `unit`.
MatrixXd free_directions(const MatrixXd& G, const VectorXd& unit) {
  const Eigen::Index n = unit.size();
  if (G.rows() == 0) return MatrixXd::Identity(n, n);
  MatrixXd rows = (G * unit.asDiagonal()).transpose();
  for (Eigen::Index k = 0; k < rows.cols(); ++k)
    if (const double norm = rows.col(k).norm(); norm > 0.0) rows.col(k) /= norm;
  Eigen::ColPivHouseholderQR<MatrixXd> qr(rows);
  qr.setThreshold(1e-10);
  return (qr.householderQ() * MatrixXd::Identity(n, n)).rightCols(n - qr.rank());
}

// Each coordinate as stiff as the others; those without stiffness as 1e-10 of the stiffest for their mass.
VectorXd stiffness_units(const MatrixXd& K, const MatrixXd& M) {
  const VectorXd m = M.diagonal().cwiseMax(1e-300), k = K.diagonal().cwiseAbs();
  const double stiffest = k.cwiseQuotient(m).maxCoeff();
  return k.cwiseMax(std::max(1e-10 * stiffest, 1e-300) * m).cwiseSqrt().cwiseInverse();
}

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
    const double bound = kNoDamping * size;
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
  Tangents tangents(eq);
  tangents.evaluate(s, VectorXd::Zero(n.n_v));
  KinematicBlocks kinematics(eq, s.p);
  kinematics.update(s.p, s.v);
  MatrixXd K;
  kinematics.multiply_T(tangents.z_p.topRows(n.n_v), K);
  const VectorXd unit = stiffness_units(K, tangents.M);
  const MatrixXd N = unit.asDiagonal() * free_directions(tangents.G, unit);
  if (N.cols() == 0) {
    out.verdict = Verdict::stable;
    return out;
  }
  const MatrixXd K_N = N.transpose() * K * N, D_N = N.transpose() * tangents.z_v.topRows(n.n_v) * N;
  const auto symmetric = [](const MatrixXd& X) { return MatrixXd(0.5 * (X + X.transpose())); };
  const double size = K_N.cwiseAbs().maxCoeff();
  if ((K_N - K_N.transpose()).cwiseAbs().maxCoeff() > kNoStiffness * size)
    return stability_of(eq, linearise(eq, s), 0.0);
  const double damping = D_N.cwiseAbs().maxCoeff();
  if (damping > 0.0) {
    const double least =
        Eigen::SelfAdjointEigenSolver<MatrixXd>(symmetric(D_N), Eigen::EigenvaluesOnly).eigenvalues()(0);
    if (least < -kNoStiffness * damping) return stability_of(eq, linearise(eq, s), 0.0);
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> stiff(symmetric(K_N));
  const double least = stiff.eigenvalues()(0),
               bound = kNoStiffness * stiff.eigenvalues().cwiseAbs().maxCoeff();
  if (least > bound) {
    out.verdict = Verdict::stable;
    return out;
  }
  const VectorXd d = N * stiff.eigenvectors().col(0);
  VectorXd relative = d;
  for (int i = 0; i < n.n_v; ++i) relative(i) /= eq.velocity_scale(i);
  out.coordinate = largest_of(relative);
  if (!(least < -bound)) return out;
  out.verdict = Verdict::unstable;
  // Growth along this direction alone, whose damping slows it: m r^2 + c r + k = 0.
  const double m = d.dot(tangents.M * d), c = d.dot(tangents.z_v.topRows(n.n_v) * d), k = d.dot(K * d);
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
