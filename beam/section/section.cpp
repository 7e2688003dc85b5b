// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/section.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <stdexcept>

namespace flexura::beam {
namespace {

constexpr std::array<const char*, 6> kNames = {"N", "V_y", "V_z", "T", "M_y", "M_z"};

// Smallest eigenvalue of a scaled (unit-diagonal) matrix below which it counts as singular: round-off of the
// entries moves eigenvalues of a unit-diagonal 6x6 by at most 6 eps, and Cholesky by a small multiple of
// that.
constexpr double kSingular = 64.0 * std::numeric_limits<double>::epsilon();

void require_positive(const std::string& section, const char* symbol, double value, const char* remedy = "") {
  if (!(value > 0.0) || std::isnan(value))
    throw std::invalid_argument(
        fmt::format("section \"{}\": {} = {:g} must be positive{}", section, symbol, value, remedy));
}

void require_finite(const std::string& section, const char* symbol, double value) {
  if (!std::isfinite(value))
    throw std::invalid_argument(
        fmt::format("section \"{}\": {} = {} must be a finite number", section, symbol, value));
}

// Of any size: one instance of Eigen's decompositions serves all.
Eigen::MatrixXd scaled_inverse(const Eigen::MatrixXd& matrix, const std::string& what) {
  for (int k = 0; k < matrix.rows(); ++k)
    if (!(matrix(k, k) > 0.0) || !std::isfinite(matrix(k, k)))
      throw std::invalid_argument(fmt::format("{} is not positive definite: its diagonal entry {} is {:g}",
                                              what, k + 1, matrix(k, k)));
  const Eigen::VectorXd scale = matrix.diagonal().cwiseSqrt().cwiseInverse();
  Eigen::MatrixXd unit = scale.asDiagonal() * matrix * scale.asDiagonal();
  unit.diagonal().setOnes();
  const double smallest =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(unit, Eigen::EigenvaluesOnly).eigenvalues()(0);
  if (!(smallest > kSingular))
    throw std::invalid_argument(
        fmt::format("{} is not positive definite: scaled to unit diagonal its smallest eigenvalue is {:.3g}, "
                    "its off-diagonal "
                    "terms are too large for its diagonal",
                    what, smallest));
  Eigen::MatrixXd inverse = unit.llt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.rows()));
  inverse = (0.5 * (inverse + inverse.transpose())).eval();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

// f of the constants for given shear areas; `axial` is the inverse of the 3x3 block of (N, M_y, M_z).
Matrix6d flexibility_of(const Constants& c, double G, const Eigen::Matrix3d& axial, double f_sy,
                        double f_sz) {
  Matrix6d f = Matrix6d::Zero();
  constexpr std::array<int, 3> at = {N, M_y, M_z};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) f(at[i], at[j]) = axial(i, j);
  // Complementary energy of the shear centre: V_y^2 f_sy + V_z^2 f_sz + (T + V_y z_cs - V_z y_cs)^2 / (G
  // I_t).
  const Eigen::Vector3d lever(c.z_cs, -c.y_cs, 1.0);
  Eigen::Matrix3d shear = lever * lever.transpose() / (G * c.I_t);
  shear(0, 0) += f_sy;
  shear(1, 1) += f_sz;
  f.block<3, 3>(V_y, V_y) = shear;
  return f;
}

void require_nonnegative_inertia(const std::string& name, const SectionInertia& inertia) {
  if (inertia.m == 0.0) return;
  // Central second moments must be a real distribution: positive semi-definite.
  const double yy = inertia.m_yy - inertia.m_y * inertia.m_y / inertia.m;
  const double zz = inertia.m_zz - inertia.m_z * inertia.m_z / inertia.m;
  const double yz = inertia.m_yz - inertia.m_y * inertia.m_z / inertia.m;
  const double size = inertia.m_yy + inertia.m_zz;
  if (yy < -1e-12 * size || zz < -1e-12 * size || yz * yz > yy * zz + 1e-12 * size * size)
    throw std::invalid_argument(
        fmt::format("section \"{}\": its mass is not that of any real distribution: about the centre of "
                    "gravity int y^2 dm = "
                    "{:g}, int z^2 dm = {:g}, int y z dm = {:g}; give moments of inertia about the section's "
                    "origin, not about "
                    "the centre of gravity",
                    name, yy, zz, yz));
}

}  // namespace

Material isotropic(std::string name, double E, double nu, double rho) {
  if (!(E > 0.0) || !std::isfinite(E))
    throw std::invalid_argument(fmt::format("material \"{}\": E = {:g} must be positive", name, E));
  if (!(nu > -1.0 && nu < 0.5))
    throw std::invalid_argument(
        fmt::format("material \"{}\": nu = {:g} must lie between -1 and 0.5; steel has 0.3", name, nu));
  if (!(rho >= 0.0) || !std::isfinite(rho))
    throw std::invalid_argument(fmt::format("material \"{}\": rho = {:g} must not be negative", name, rho));
  return {std::move(name), E, E / (2.0 * (1.0 + nu)), rho};
}

Matrix6d SectionInertia::matrix() const {
  // u = (u + z theta_y - y theta_z, v - z theta_x, w + y theta_x)
  Matrix6d M = Matrix6d::Zero();
  M(0, 0) = M(1, 1) = M(2, 2) = m;
  M(0, 4) = M(4, 0) = m_z;
  M(0, 5) = M(5, 0) = -m_y;
  M(1, 3) = M(3, 1) = -m_z;
  M(2, 3) = M(3, 2) = m_y;
  M(3, 3) = m_yy + m_zz;
  M(4, 4) = m_zz;
  M(5, 5) = m_yy;
  M(4, 5) = M(5, 4) = -m_yz;
  return M;
}

Matrix6d inverse_spd(const Matrix6d& matrix, const std::string& what) {
  return scaled_inverse(matrix, what);
}

Matrix6d without_shear_flexibility(const Matrix6d& f) {
  constexpr std::array<int, 4> others = {N, T, M_y, M_z};
  Eigen::Matrix4d f_oo;
  Eigen::Matrix<double, 4, 2> f_oV;
  for (int i = 0; i < 4; ++i) {
    for (int j = 0; j < 4; ++j) f_oo(i, j) = f(others[i], others[j]);
    for (int j = 0; j < 2; ++j) f_oV(i, j) = f(others[i], V_y + j);
  }
  Matrix6d rigid = f;
  rigid.block<2, 2>(V_y, V_y) = f_oV.transpose() * scaled_inverse(f_oo, "the section's flexibility") * f_oV;
  return rigid;
}

Matrix6d Section::stiffness() const {
  if (!(f(V_y, V_y) > 0.0) || !(f(V_z, V_z) > 0.0) ||
      (constants && !std::isfinite(constants->A_sy + constants->A_sz)))
    throw std::invalid_argument(fmt::format(
        "section \"{}\" is rigid in shear and has no finite stiffness matrix; give A_sy and A_sz", name));
  return inverse_spd(f, fmt::format("section \"{}\": the flexibility", name));
}

Section make_section(std::string name, const Constants& c, const Material& material) {
  require_positive(name, "A", c.A);
  require_positive(name, "I_y", c.I_y);
  require_positive(name, "I_z", c.I_z);
  require_positive(name, "I_t", c.I_t);
  require_positive(name, "A_sy", c.A_sy, "; leave it out for a section rigid in shear");
  require_positive(name, "A_sz", c.A_sz, "; leave it out for a section rigid in shear");
  require_positive(name, "E", material.E);
  require_positive(name, "G", material.G);
  if (!(material.rho >= 0.0))
    throw std::invalid_argument(
        fmt::format("section \"{}\": rho = {:g} must not be negative", name, material.rho));
  const std::pair<const char*, double> values[] = {
      {"A", c.A},       {"I_y", c.I_y},    {"I_z", c.I_z},    {"I_t", c.I_t},       {"I_yz", c.I_yz},
      {"S_y", c.S_y},   {"S_z", c.S_z},    {"y_cs", c.y_cs},  {"z_cs", c.z_cs},     {"y_cg", c.y_cg},
      {"z_cg", c.z_cg}, {"E", material.E}, {"G", material.G}, {"rho", material.rho}};
  for (const auto& [symbol, value] : values) require_finite(name, symbol, value);

  Eigen::Matrix3d stiffness;
  stiffness << c.A, c.S_y, -c.S_z, c.S_y, c.I_y, c.I_yz, -c.S_z, c.I_yz, c.I_z;
  const Eigen::Matrix3d axial = scaled_inverse(
      material.E * stiffness, fmt::format("section \"{}\": the stiffness of (N, M_y, M_z) from A, I_y, I_z, "
                                          "I_yz, S_y, S_z (moments about the "
                                          "origin)",
                                          name));

  Section section;
  section.name = std::move(name);
  const double f_sy = 1.0 / (material.G * c.A_sy), f_sz = 1.0 / (material.G * c.A_sz);
  section.f = flexibility_of(c, material.G, axial, f_sy, f_sz);
  section.f_shear_rigid = flexibility_of(c, material.G, axial, 0.0, 0.0);
  const double rho = material.rho;
  section.inertia = {rho * c.A,   rho * c.A * c.y_cg, rho * c.A * c.z_cg,
                     rho * c.I_z, rho * c.I_y,        -rho * c.I_yz};
  require_nonnegative_inertia(section.name, section.inertia);
  section.constants = c;
  section.material = material;
  return section;
}

SectionInertia inertia_of(const std::string& name, const Matrix6d& M) {
  if (!M.allFinite())
    throw std::invalid_argument(
        fmt::format("section \"{}\": the section mass has entries that are not finite", name));
  SectionInertia inertia;
  inertia.m = M(0, 0);
  inertia.m_z = M(0, 4);
  inertia.m_y = -M(0, 5);
  inertia.m_zz = M(4, 4);
  inertia.m_yy = M(5, 5);
  inertia.m_yz = -M(4, 5);
  if (!(inertia.m >= 0.0))
    throw std::invalid_argument(
        fmt::format("section \"{}\": the mass per length {:g} must not be negative", name, inertia.m));
  // Input is printed decimal numbers: nine digits is what people keep.
  const Matrix6d expected = inertia.matrix();
  const Vector6d size = M.diagonal().cwiseAbs().cwiseMax(expected.diagonal().cwiseAbs()).cwiseSqrt();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      if (std::abs(M(i, j) - expected(i, j)) > 1e-9 * size(i) * size(j))
        throw std::invalid_argument(
            fmt::format("section \"{}\": entry ({}, {}) of the section mass is {:g}, a section that moves "
                        "rigidly has {:g} there (M_11 = M_22 = M_33 = mass per length, M_44 = M_55 + M_66, "
                        "M_15 = -M_24, M_16 = -M_34)",
                        name, i + 1, j + 1, M(i, j), expected(i, j)));
  require_nonnegative_inertia(name, inertia);
  return inertia;
}

Section matrix_section(std::string name, const Matrix6d& C, const Matrix6d& mass) {
  if (!C.allFinite())
    throw std::invalid_argument(
        fmt::format("section \"{}\": the section stiffness has entries that are not finite", name));
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j)
      if (std::abs(C(i, j) - C(j, i)) > 1e-9 * std::sqrt(std::abs(C(i, i) * C(j, j))))
        throw std::invalid_argument(fmt::format(
            "section \"{}\": the section stiffness is not symmetric: C({}, {}) = {:g}, C({}, {}) = {:g}",
            name, kNames[i], kNames[j], C(i, j), kNames[j], kNames[i], C(j, i)));
  Section section;
  const Matrix6d symmetric = 0.5 * (C + C.transpose());
  section.f = inverse_spd(
      symmetric, fmt::format("section \"{}\": the 6x6 stiffness (order N, V_y, V_z, T, M_y, M_z)", name));
  section.f_shear_rigid = without_shear_flexibility(section.f);
  section.inertia = inertia_of(name, mass);
  section.name = std::move(name);
  return section;
}

}  // namespace flexura::beam
