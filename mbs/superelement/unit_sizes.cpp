// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <vector>

#include "mbs/superelement/checks.hpp"

namespace flexura::superelement {
namespace {

enum Unit { displacement, rotation, mode };

std::vector<Unit> units(const Superelement& se) {
  std::vector<Unit> out(static_cast<std::size_t>(se.n()), mode);
  for (const Interface& interface : se.interfaces)
    for (std::size_t i = 0; i < interface.directions.size(); ++i)
      out[static_cast<std::size_t>(interface.first_dof) + i] =
          interface.directions[i] < Direction::theta_x ? displacement : rotation;
  return out;
}

// Of the interfaces' positions and, where it is known, of the mass about its centre; 0: all in one point.
double length_of(const Superelement& se) {
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Interface& interface : se.interfaces) middle += interface.p_BoN_B;
  middle /= static_cast<double>(std::max<std::size_t>(se.interfaces.size(), 1));
  const InertiaIntegrals& I = se.inertia;
  double length = 0.0;
  if (I.mass > 0.0) {
    const double gyration2 = (I.S_xx.trace() - I.S_x.squaredNorm() / I.mass) / I.mass;
    if (gyration2 > 0.0) length = std::sqrt(gyration2);
    middle = I.S_x / I.mass;
  }
  for (const Interface& interface : se.interfaces)
    length = std::max(length, (interface.p_BoN_B - middle).norm());
  return length;
}

}  // namespace

Eigen::VectorXd unit_sizes(const Superelement& se, const Eigen::MatrixXd& A) {
  const std::vector<Unit> unit = units(se);
  double size[3] = {0.0, 0.0, 0.0}, softest_mode = 0.0;
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Unit u = unit[static_cast<std::size_t>(i)];
    const double entry = std::abs(A(i, i));
    size[u] = std::max(size[u], entry);
    if (u == mode && entry > 0.0) softest_mode = softest_mode > 0.0 ? std::min(softest_mode, entry) : entry;
  }
  const double L2 = std::pow(length_of(se), 2);
  if (se.inertia.mass > 0.0)
    size[displacement] = std::max(size[displacement], softest_mode * se.inertia.mass);
  if (L2 > 0.0) {
    size[displacement] = std::max(size[displacement], size[rotation] / L2);
    size[rotation] = std::max(size[rotation], size[displacement] * L2);
  }
  Eigen::VectorXd out(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) out[i] = size[unit[static_cast<std::size_t>(i)]];
  return out;
}

}  // namespace flexura::superelement
