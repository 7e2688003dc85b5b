// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/exact/planar_field.hpp"

#include <cmath>
#include <vector>

namespace flexura::beam::exact {
namespace {

constexpr int kInPlane[] = {0, 1, 5};  // gamma_x, gamma_y, kappa_z of the six
constexpr int kAcross[] = {2, 3, 4};
// Of products of their own stiffnesses: matrices of a section solver hold round-off where symmetry has zeros.
constexpr double kNoCoupling = 1e-9;

}  // namespace

const char* why_not_planar(const Matrix6d& C, const SectionInertia& inertia) {
  for (const int i : kInPlane)
    for (const int j : kAcross)
      if (std::abs(C(i, j)) > kNoCoupling * std::sqrt(std::abs(C(i, i) * C(j, j))))
        return "its section's stiffness couples the plane with what is across it";
  const double across = kNoCoupling * std::sqrt(inertia.m * (inertia.m_yy + inertia.m_zz));
  if (std::abs(inertia.m_z) > across || std::abs(inertia.m_yz) > kNoCoupling * (inertia.m_yy + inertia.m_zz))
    return "its section's mass does not lie on both sides of the plane alike";
  return nullptr;
}

PlanarField planar_field(Kind kind, const Matrix6d& C, double l) {
  const StrainField whole = strain_field(kind, C, l);
  // Columns of what is not coupled lie in the plane, or across it.
  std::vector<int> kept;
  for (int j = 0; j < whole.n(); ++j) {
    const double in = std::hypot(whole.g_0.col(j).head<2>().norm(), whole.g_1.col(j).head<2>().norm() * l,
                                 l * std::hypot(whole.k_0(2, j), l * whole.k_1(2, j))),
                 across = std::hypot(std::hypot(whole.g_0(2, j), l * whole.g_1(2, j)),
                                     l * whole.k_0.col(j).head<2>().norm(),
                                     l * l * whole.k_1.col(j).head<2>().norm());
    if (in > across) kept.push_back(j);
  }
  PlanarField out;
  out.first.resize(3, static_cast<Eigen::Index>(kept.size()));
  out.slope = out.first;
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const auto j = static_cast<Eigen::Index>(k);
    out.first.col(j) << whole.g_0(0, kept[k]), whole.g_0(1, kept[k]), whole.k_0(2, kept[k]);
    out.slope.col(j) << whole.g_1(0, kept[k]), whole.g_1(1, kept[k]), whole.k_1(2, kept[k]);
  }
  out.K = whole.K(kept, kept);
  return out;
}

}  // namespace flexura::beam::exact
