// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/static_stiffness.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/algebra/tangents.hpp"
#include "mbs/solver/position/independent.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// An entry is a sum of some twenty products for each of the two elements beside a node.
constexpr double kRoundOff = 1e-14;

constexpr const char* kNoStaticValue =
    "the dynamic states of controls and actuators have no static values, so that nothing can be said of "
    "buckling; hold them constant";

// The states that dq = N z brings with it, as columns for each z: X = -(d states)/dz.
MatrixXd answers(const Equations& eq, const Tangents& t, const MatrixXd& KN, const MatrixXd& N,
                 const std::vector<int>& independent) {
  const Sizes n = eq.sizes();
  const int n_c = n.n_dyn, n_a = n.n_alg, n_x = n_c + n_a;
  if (t.b_lambda.size() > 0)
    throw std::runtime_error(
        "a force reads a reaction or an acceleration, so that nothing can be said of buckling; give it the "
        "value that it "
        "has in the equilibrium");
  MatrixXd inner(n_x, n_x), outer = KN.bottomRows(n_x);
  inner << t.z_c.bottomRows(n_x), t.z_a.bottomRows(n_x);
  if (t.c_lambda.size() > 0) {
    // Reactions that balance the dependent coordinates.
    std::vector<int> dependent;
    for (int i = 0, k = 0; i < n.n_v; ++i)
      if (k < static_cast<int>(independent.size()) && independent[static_cast<std::size_t>(k)] == i)
        ++k;
      else
        dependent.push_back(i);
    const MatrixXd G_d = t.G(Eigen::all, dependent).transpose();
    const auto reactions = G_d.completeOrthogonalDecomposition();
    MatrixXd by_x(n.n_v, n_x);
    by_x << t.z_c.topRows(n.n_v), t.z_a.topRows(n.n_v);
    outer.topRows(n_c) -= t.c_lambda * reactions.solve(KN(dependent, Eigen::all));
    inner.topRows(n_c) -= t.c_lambda * reactions.solve(by_x(dependent, Eigen::all));
  }
  for (int i = 0; i < n_x; ++i) {
    double size = inner.row(i).cwiseAbs().maxCoeff();
    // A state that only motion changes, as of a friction that sticks, follows the displacements.
    if (!(size > 0.0) && i < n_c && outer.row(i).isZero(0.0) && !t.z_v.row(n.n_v + i).isZero(0.0)) {
      outer.row(i) = -t.z_v.row(n.n_v + i) * N;
      inner(i, i) = size = 1.0;
    }
    if (!(size > 0.0) && i < n_c)
      throw std::runtime_error(fmt::format(
          "the dynamic state \"{}\" has no static value: it integrates, so that nothing can be said of "
          "buckling; hold it constant",
          eq.name_of_dynamic(i)));
    if (!(size > 0.0)) throw std::runtime_error(kNoStaticValue);
    inner.row(i) /= size;
    outer.row(i) /= size;
  }
  const Eigen::PartialPivLU<MatrixXd> lu(inner);
  // Derivatives of formulas are exact: what lies below is no answer.
  if (!(lu.rcond() > 1e-12)) throw std::runtime_error(kNoStaticValue);
  return lu.solve(outer);
}

// Rows of joints are sums of all that hangs on them, which round off at the size of the stiffest: K_ii / M_ii is what
// their sizes have in common.  Elastic coordinates have their own rows.
MatrixXd by_inertia(const Equations& eq, const MatrixXd& K, const MatrixXd& M) {
  const Eigen::Index n = K.rows();
  VectorXd m = VectorXd::Zero(n);
  double stiffest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(M(i, i) > 0.0)) continue;
    stiffest = std::max(stiffest, std::abs(K(i, i)) / M(i, i));
    int i_p = 0;
    double k = 0.0, d = 0.0;
    if (!eq.elastic_coordinate(static_cast<int>(i), i_p, k, d)) m(i) = std::sqrt(M(i, i));
  }
  return 1e-16 * stiffest * m * m.transpose();
}

}  // namespace

double noise_of(const VectorXd& l, const MatrixXd& E, const VectorXd& x) {
  return std::sqrt(l.cwiseAbs2().dot(E.cwiseAbs2() * x.cwiseAbs2()));
}

StaticStiffness static_stiffness(const Equations& eq, const State& s, const std::vector<int>* independent) {
  const Sizes n = eq.sizes();
  const VectorXd rest = VectorXd::Zero(n.n_v);
  Tangents tangents(eq);
  KinematicBlocks kinematics(eq, s.p);
  const auto full_stiffness = [&](const State& at) {
    tangents.evaluate(at, rest);
    kinematics.update(at.p, rest);
    MatrixXd K;
    kinematics.multiply_T(tangents.z_p, K);
    return K;
  };
  // A few last digits away, where the round-off of differences is another.
  State moved = s;
  VectorXd d(n.n_v);
  for (int i = 0; i < n.n_v; ++i) d(i) = (i % 2 == 0 ? 1e-14 : -1e-14) * eq.velocity_scale(i);
  eq.retract(s.p, d, moved.p);
  const MatrixXd beside = full_stiffness(moved).topRows(n.n_v);
  const MatrixXd K = full_stiffness(s), K_v = K.topRows(n.n_v);
  StaticStiffness out;
  const IndependentCoordinates z = independent ? independent_coordinates(tangents.M, tangents.G, *independent)
                                               : independent_coordinates(tangents.M, tangents.G);
  out.independent = z.independent;
  out.N = z.N;
  for (const int i : z.independent) out.names.push_back(eq.name_of_velocity(i));
  const MatrixXd KN = K * z.N;
  MatrixXd held = KN.topRows(n.n_v);
  if (n.n_dyn + n.n_alg > 0) {
    const MatrixXd X = answers(eq, tangents, KN, z.N, z.independent);
    if (tangents.g_c.size() > 0 && !(tangents.g_c * X.topRows(n.n_dyn)).isZero(0.0))
      throw std::runtime_error(
          "a drive follows a control that answers to the deformation, so that nothing can be said of "
          "buckling; hold the "
          "control constant");
    held -= tangents.z_c.topRows(n.n_v) * X.topRows(n.n_dyn) +
            tangents.z_a.topRows(n.n_v) * X.bottomRows(n.n_alg);
  }
  out.K = z.N.transpose() * held;
  const VectorXd unit = K_v.diagonal().cwiseAbs().cwiseSqrt();
  MatrixXd variance = (kRoundOff * (unit * unit.transpose()).cwiseMax(K_v.cwiseAbs())).cwiseAbs2();
  variance += (K_v - beside).cwiseAbs2();
  variance += by_inertia(eq, K_v, tangents.M).cwiseAbs2();
  const MatrixXd N_2 = z.N.cwiseAbs2();
  out.error = (N_2.transpose() * variance * N_2).cwiseSqrt();
  return out;
}

}  // namespace flexura::mbs
