// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/elements/material.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace flexura::reduce {
namespace {

void require_positive(const std::string& material, const char* what, double value, const char* unit) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(
        fmt::format("material '{}': {} is {:g} {}, but it must be positive", material, what, value, unit));
}

}  // namespace

Material isotropic(std::string name, double E, double nu, double density) {
  require_positive(name, "Young's modulus", E, "Pa");
  require_positive(name, "the density", density, "kg/m^3");
  if (!(nu > -1.0 && nu < 0.5))
    throw std::invalid_argument(
        fmt::format("material '{}': Poisson's ratio is {:g}, but it must lie above -1 and below 0.5 (0.5 is "
                    "incompressible: for "
                    "rubber take 0.49 or less)",
                    name, nu));
  const double mu = E / (2.0 * (1.0 + nu)), lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu));
  Material material{std::move(name), {}, density};
  material.D.setZero();
  material.D.topLeftCorner<3, 3>().setConstant(lambda);
  material.D.diagonal() << lambda + 2.0 * mu, lambda + 2.0 * mu, lambda + 2.0 * mu, mu, mu, mu;
  return material;
}

Material orthotropic(std::string name, const OrthotropicConstants& c, double density) {
  require_positive(name, "the density", density, "kg/m^3");
  require_positive(name, "E_x", c.E_x, "Pa");
  require_positive(name, "E_y", c.E_y, "Pa");
  require_positive(name, "E_z", c.E_z, "Pa");
  require_positive(name, "G_xy", c.G_xy, "Pa");
  require_positive(name, "G_yz", c.G_yz, "Pa");
  require_positive(name, "G_zx", c.G_zx, "Pa");
  Eigen::Matrix3d compliance;
  const double xy = -c.nu_xy / c.E_x, yz = -c.nu_yz / c.E_y, zx = -c.nu_zx / c.E_z;
  compliance << 1.0 / c.E_x, xy, zx, xy, 1.0 / c.E_y, yz, zx, yz, 1.0 / c.E_z;
  if (Eigen::LLT<Eigen::Matrix3d>(compliance).info() != Eigen::Success)
    throw std::invalid_argument(
        fmt::format("material '{}': nu_xy = {:g}, nu_yz = {:g}, nu_zx = {:g} are too large for these moduli, "
                    "the stiffness would "
                    "not be positive definite; remember nu_ij / E_i = nu_ji / E_j",
                    name, c.nu_xy, c.nu_yz, c.nu_zx));
  Material material{std::move(name), {}, density};
  material.D.setZero();
  material.D.topLeftCorner<3, 3>() = compliance.inverse();
  material.D.diagonal().tail<3>() << c.G_xy, c.G_yz, c.G_zx;
  return material;
}

Material laminate(std::string name, std::vector<Ply> plies, const Eigen::Vector3d& axis) {
  if (plies.empty()) throw std::invalid_argument(fmt::format("material '{}' has no layers", name));
  Material material{.name = std::move(name), .plies = std::move(plies), .ply_axis = axis};
  double whole = 0.0;
  for (const Ply& ply : material.plies) {
    require_positive(material.name, "the thickness of a layer", ply.thickness, "m");
    require_positive(material.name, "the density of a layer", ply.density, "kg/m^3");
    material.D += ply.thickness * ply.D;
    material.density += ply.thickness * ply.density;
    whole += ply.thickness;
  }
  material.D /= whole, material.density /= whole;
  return material;
}

Material turned(Material material, const Eigen::Matrix3d& R) {
  constexpr int kFirst[6] = {0, 1, 2, 0, 1, 2}, kSecond[6] = {0, 1, 2, 1, 2, 0};
  Eigen::Matrix<double, 6, 6> T;  // stresses in the mesh frame from stresses in the material's axes
  for (int I = 0; I < 6; ++I)
    for (int J = 0; J < 6; ++J) {
      const int i = kFirst[I], j = kSecond[I], p = kFirst[J], q = kSecond[J];
      T(I, J) = R(i, p) * R(j, q) + (p == q ? 0.0 : R(i, q) * R(j, p));
    }
  material.D = (T * material.D * T.transpose()).eval();
  return material;
}

}  // namespace flexura::reduce
