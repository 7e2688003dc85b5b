// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "beam/section/solver.hpp"

namespace flexura::beam {

PlyMaterial ply_of(const Material& m) {
  const double nu = m.nu();
  return {m.name, m.rho, m.E, m.E, m.E, m.G, m.G, m.G, nu, nu, nu};
}

Matrix6d stiffness_of(const Ply& ply, double extra_plane_angle) {
  const PlyMaterial& m = ply.material;
  for (const auto& [symbol, value] : {std::pair{"E_1", m.E_1},
                                      {"E_2", m.E_2},
                                      {"E_3", m.E_3},
                                      {"G_12", m.G_12},
                                      {"G_13", m.G_13},
                                      {"G_23", m.G_23}})
    if (!(value > 0.0) || !std::isfinite(value))
      throw std::invalid_argument(
          fmt::format("material \"{}\": {} = {:g} must be positive", m.name, symbol, value));
  if (!(m.rho >= 0.0))
    throw std::invalid_argument(
        fmt::format("material \"{}\": rho = {:g} must not be negative", m.name, m.rho));
  Matrix6d compliance = Matrix6d::Zero();  // order 11, 22, 33, 23, 13, 12
  compliance.diagonal() << 1 / m.E_1, 1 / m.E_2, 1 / m.E_3, 1 / m.G_23, 1 / m.G_13, 1 / m.G_12;
  compliance(0, 1) = compliance(1, 0) = -m.nu_12 / m.E_1;
  compliance(0, 2) = compliance(2, 0) = -m.nu_13 / m.E_1;
  compliance(1, 2) = compliance(2, 1) = -m.nu_23 / m.E_2;
  const Matrix6d Q = inverse_spd(
      compliance,
      fmt::format("material \"{}\": the compliance (its Poisson's ratios are too large)", m.name));

  // Material axes in the section frame.
  const double a = ply.plane_angle + extra_plane_angle, t = ply.fibre_angle;
  const Eigen::Vector3d x(1, 0, 0), along(0, std::cos(a), std::sin(a)), normal(0, -std::sin(a), std::cos(a));
  Eigen::Matrix3d axes;
  axes.col(0) = std::cos(t) * x + std::sin(t) * along;
  axes.col(1) = -std::sin(t) * x + std::cos(t) * along;
  axes.col(2) = normal;
  // Engineering strain in material axes from that in section axes: eps' = axes^T eps axes, entry by entry.
  constexpr int first[] = {0, 1, 2, 1, 0, 0}, second[] = {0, 1, 2, 2, 2, 1};
  Matrix6d turn;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const int p = first[i], q = second[i], r = first[j], s = second[j];
      // Tensor strain e_rs = e_sr = strain_j (r = s) or strain_j / 2.
      double entry = axes(r, p) * axes(s, q);
      if (r != s) entry = 0.5 * (axes(r, p) * axes(s, q) + axes(s, p) * axes(r, q));
      turn(i, j) = (p == q ? 1.0 : 2.0) * entry;
    }
  return turn.transpose() * Q * turn;
}

}  // namespace flexura::beam
