// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

/// Strain measures z(x) of the ANCF elements at one quadrature point.
///
/// x stacks n_x vectors of dimension dim that depend linearly on the nodal coordinates (slopes and their
/// derivatives).  With the stress law sigma = C (z - z_0) + C_d z_dot and g = dz/dx, H_k = d2 z_k/dx2
/// everything an element needs follows by the chain rule (point_set.hpp):
///
///     f_x = g^T sigma,   df_x/dx = sum_k sigma_k H_k + g^T (C g + C_d g_dot),   df_x/dx_dot = g^T C_d g,
///     (g_dot)_k = x_dot^T H_k.
///
/// A strain measure is a struct of static functions: evaluate (z and g), add_hessian (sum_k sigma_k H_k) and
/// gradient_rate (g_dot).  All measures are objective: unchanged when every vector in x turns alike
/// (CableStrain: its norm is).
namespace flexura::beam::ancf {

/// Bilinear strains z_k = sum over terms of factor * x_i . x_j, so H is constant and g_dot(x_dot) = g(x =
/// x_dot). Definition gives dim, n_x, n_z and the array `terms`.
struct BilinearTerm {
  int strain;
  int i, j;
  double factor;
};

template <class Definition>
struct BilinearStrain {
  static constexpr int dim = Definition::dim, n_x = Definition::n_x, n_z = Definition::n_z;
  static constexpr bool projects_rates = false;
  using X = Eigen::Matrix<double, dim, n_x>;
  using Z = Eigen::Matrix<double, n_z, 1>;
  using Gradient = Eigen::Matrix<double, n_z, dim * n_x>;
  using Hessian = Eigen::Matrix<double, dim * n_x, dim * n_x>;

  static void evaluate(const X& x, Z& z, Gradient& g) {
    z.setZero();
    for (const auto& t : Definition::terms) z[t.strain] += t.factor * x.col(t.i).dot(x.col(t.j));
    gradient(x, g);
  }

  static void add_hessian(const X&, const Z& sigma, Hessian& H) {
    for (const auto& t : Definition::terms) {
      const double value = sigma[t.strain] * t.factor;
      for (int c = 0; c < dim; ++c) {
        H(dim * t.i + c, dim * t.j + c) += value;
        H(dim * t.j + c, dim * t.i + c) += value;
      }
    }
  }

  static void gradient_rate(const X&, const X& x_dot, Gradient& g_dot) { gradient(x_dot, g_dot); }

 private:
  static void gradient(const X& x, Gradient& g) {
    g.setZero();
    for (const auto& t : Definition::terms) {
      g.template block<1, dim>(t.strain, dim * t.i) += t.factor * x.col(t.j).transpose();
      g.template block<1, dim>(t.strain, dim * t.j) += t.factor * x.col(t.i).transpose();
    }
  }
};

/// In-plane deformation of a section, x = (r_y, r_z): z = (r_y.r_y/2, r_z.r_z/2, r_y.r_z).
struct SectionStrainDefinition {
  static constexpr int dim = 3, n_x = 2, n_z = 3;
  static constexpr std::array<BilinearTerm, 3> terms{{{0, 0, 0, 0.5}, {1, 1, 1, 0.5}, {2, 0, 1, 1.0}}};
};
using SectionStrain = BilinearStrain<SectionStrainDefinition>;

/// Green-Lagrange strains of a point, x = (F_1, F_2, F_3) the columns of the deformation gradient, in Voigt's
/// order (E_xx, E_yy, E_zz, 2E_yz, 2E_xz, 2E_xy); the constant -1/2 is part of z_0.
struct GreenStrainDefinition {
  static constexpr int dim = 3, n_x = 3, n_z = 6;
  static constexpr std::array<BilinearTerm, 6> terms{
      {{0, 0, 0, 0.5}, {1, 1, 1, 0.5}, {2, 2, 2, 0.5}, {3, 1, 2, 1.0}, {4, 0, 2, 1.0}, {5, 0, 1, 1.0}}};
};
using GreenStrain = BilinearStrain<GreenStrainDefinition>;

/// g_dot from Hessians taken one strain at a time; for measures with few strains.
template <class Strain>
void gradient_rate_from_hessian(const typename Strain::X& x, const typename Strain::X& x_dot,
                                typename Strain::Gradient& g_dot) {
  for (int k = 0; k < Strain::n_z; ++k) {
    typename Strain::Hessian H = Strain::Hessian::Zero();
    Strain::add_hessian(x, Strain::Z::Unit(k), H);
    g_dot.row(k) = x_dot.reshaped().transpose() * H;
  }
}

/// Stretch and curvature of a plane elastic line, x = (a, b) = (r_x, r_xx), p = a.a:
///
///     eps = |a| - 1,   K = theta_x = (a x b) / p
///
/// K is the rate of the tangent's angle over the *unstretched* length, so that bending moment and axial force
/// are work-conjugate to it and eps without spurious coupling (J. Gerstmayr, H. Irschik, J. Sound Vib. 318
/// (2008) 461).
struct PlanarStrain {
  static constexpr int dim = 2, n_x = 2, n_z = 2;
  static constexpr bool projects_rates = false;
  using X = Eigen::Matrix2d;
  using Z = Eigen::Vector2d;
  using Gradient = Eigen::Matrix<double, 2, 4>;
  using Hessian = Eigen::Matrix4d;

  static void evaluate(const X& x, Z& z, Gradient& g) {
    const Eigen::Vector2d a = x.col(0), b = x.col(1);
    const double p = a.squaredNorm(), length = std::sqrt(p), K = (a[0] * b[1] - a[1] * b[0]) / p;
    z << length - 1, K;
    g.row(0) << a.transpose() / length, 0, 0;
    g.row(1) << (turned(b) - 2 * K * a).transpose() / p, -turned(a).transpose() / p;
  }

  static void add_hessian(const X& x, const Z& sigma, Hessian& H) {
    const Eigen::Vector2d a = x.col(0), b = x.col(1);
    const double p = a.squaredNorm(), length = std::sqrt(p), K = (a[0] * b[1] - a[1] * b[0]) / p;
    const Eigen::Matrix2d I = Eigen::Matrix2d::Identity(), aa = a * a.transpose();
    H.topLeftCorner<2, 2>() += sigma[0] / length * (I - aa / p);
    const Eigen::Matrix2d ba = turned(b) * a.transpose();
    H.topLeftCorner<2, 2>() += sigma[1] / p * (-2 / p * (ba + ba.transpose()) - 2 * K * I + 8 * K / p * aa);
    Eigen::Matrix2d J;
    J << 0, 1, -1, 0;
    const Eigen::Matrix2d H_ab = sigma[1] / p * (J + 2 / p * a * turned(a).transpose());
    H.topRightCorner<2, 2>() += H_ab;
    H.bottomLeftCorner<2, 2>() += H_ab.transpose();
  }

  static void gradient_rate(const X& x, const X& x_dot, Gradient& g_dot) {
    gradient_rate_from_hessian<PlanarStrain>(x, x_dot, g_dot);
  }

 private:
  // a x b = a . turned(b)
  static Eigen::Vector2d turned(const Eigen::Vector2d& v) { return {v[1], -v[0]}; }
};

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
  return m;
}

/// Stretch and curvature vector of a spatial elastic line without torsion, x = (a, b) = (r_x, r_xx), p = a.a:
///
///     eps = |a| - 1,   K = (a x b) / p   (components in the world)
///
/// The energy EI K.K / 2 is objective; K itself turns with the line.  Its rate relative to a frame that
/// follows the tangent t without spin about it is (1 - t t^T) dK/dt, and that is what damping sees
/// (projects_rates).  A line has no section to spin with: a bent cable that spins about its own tangent is
/// damped like a flexible shaft between ends that do not turn.
struct CableStrain {
  static constexpr int dim = 3, n_x = 2, n_z = 4;
  static constexpr bool projects_rates = true;
  using X = Eigen::Matrix<double, 3, 2>;
  using Z = Eigen::Vector4d;
  using Gradient = Eigen::Matrix<double, 4, 6>;
  using Hessian = Eigen::Matrix<double, 6, 6>;

  static void evaluate(const X& x, Z& z, Gradient& g) {
    const Eigen::Vector3d a = x.col(0), b = x.col(1);
    const double p = a.squaredNorm(), length = std::sqrt(p);
    const Eigen::Vector3d K = a.cross(b) / p;
    z << length - 1, K;
    g.row(0) << a.transpose() / length, 0, 0, 0;
    g.bottomLeftCorner<3, 3>() = (-cross_matrix(b) - 2 * K * a.transpose()) / p;
    g.bottomRightCorner<3, 3>() = cross_matrix(a) / p;
  }

  static void add_hessian(const X& x, const Z& sigma, Hessian& H) {
    const Eigen::Vector3d a = x.col(0), b = x.col(1), m = sigma.tail<3>();
    const double p = a.squaredNorm(), length = std::sqrt(p), mK = m.dot(a.cross(b)) / p;
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), aa = a * a.transpose();
    H.topLeftCorner<3, 3>() += sigma[0] / length * (I - aa / p);
    const Eigen::Matrix3d ba = b.cross(m) * a.transpose();
    H.topLeftCorner<3, 3>() += (-2 / p * (ba + ba.transpose()) - 2 * mK * I + 8 * mK / p * aa) / p;
    const Eigen::Matrix3d H_ab = (-cross_matrix(m) - 2 / p * a * m.cross(a).transpose()) / p;
    H.topRightCorner<3, 3>() += H_ab;
    H.bottomLeftCorner<3, 3>() += H_ab.transpose();
  }

  static void gradient_rate(const X& x, const X& x_dot, Gradient& g_dot) {
    gradient_rate_from_hessian<CableStrain>(x, x_dot, g_dot);
  }

  /// z_dot without its component of dK/dt along the tangent.
  static Z project(const X& x, const Z& z_dot) {
    Z out = z_dot;
    const Eigen::Vector3d t = x.col(0).normalized();
    out.tail<3>() -= t * t.dot(z_dot.tail<3>());
    return out;
  }

  /// d project(x, z_dot) / dx at fixed z_dot.
  static Gradient project_gradient(const X& x, const Z& z_dot) {
    Gradient out = Gradient::Zero();
    const double length = x.col(0).norm();
    const Eigen::Vector3d t = x.col(0) / length, rate = z_dot.tail<3>();
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    out.bottomLeftCorner<3, 3>() =
        -(t.dot(rate) * I + t * rate.transpose()) * (I - t * t.transpose()) / length;
    return out;
  }
};

}  // namespace flexura::beam::ancf
