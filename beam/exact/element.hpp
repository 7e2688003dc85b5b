// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "beam/exact/strain_field.hpp"
#include "beam/section/section.hpp"

/// An element of a geometrically exact beam in the axes of the section it starts with.
///
/// Its strains are Phi(x) s (strain_field.hpp).  The section at x has the axes E(x) = exp(Theta^) and the place r(x),
///
///     Theta = x k_0 + x^2/2 k_1 + x^3/12 k_0 x k_1        (curvature k_0 + x k_1; W. Magnus, Comm. Pure Appl. Math. 7
///                                                         (1954) 649: an error of x^5; none where they are parallel)
///     r     = int_0^x E (e_1 + gamma)                     by Gauss' four points, as a polynomial through them
///
/// Everything below differentiates these two as they stand, so velocities, forces and tangents belong to each other to
/// round-off.  The mass is that of the section at the same four points: with m, S and I its mass, first moments and
/// moments of inertia per length, Omega its angular velocity in its own axes,
///
///     F = m r'' + E (Omega' x S + Omega x (Omega x S)),    T = I Omega' + Omega x I Omega + S x E^T r''.
namespace flexura::beam::exact {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;

class Element {
 public:
  static constexpr int kPoints = 4;
  static constexpr int kMost = 10;                           ///< coordinates
  using Columns = Eigen::Matrix<double, 6, Eigen::Dynamic>;  ///< 6 x n: angular, linear

  /// `rest_strain` = (gamma, kappa) of the stress-free shape, the same all along: an arc, a helix.
  Element(StrainField field, double length, const SectionInertia& inertia,
          const Vector6d& rest_strain = Vector6d::Zero());

  int n() const { return field_.n(); }
  double length() const { return length_; }
  double mass() const { return length_ * inertia_.m; }
  const Eigen::MatrixXd& stiffness() const { return field_.K; }

  /// A section of the element, by its distance from the start along the unstrained axis [m].
  struct Place {
    double x = 0.0;
    std::array<double, kPoints> weight{};  ///< int_0^x of the points' polynomials [m]
  };
  Place place(double x) const;

  /// How a section moves in the axes at the start, which are taken to be at rest.
  struct Motion {
    Matrix3d R = Matrix3d::Identity();
    Vector3d p = Vector3d::Zero();
    Vector6d V = Vector6d::Zero(), A = Vector6d::Zero();  ///< angular, linear
  };
  /// V and A only where s_dot and s_ddot are given (else nullptr).
  Motion motion(const Place& place, const double* s, const double* s_dot, const double* s_ddot) const;
  /// V = map s_dot.
  void map(const Place& place, const double* s, Columns& out) const;
  /// Both.
  void motion_and_map(const Place& place, const double* s, const double* s_dot, const double* s_ddot,
                      Motion& out, Columns& map) const;
  /// Of V by s, of A by s and by s', and of map^T wrench by s at a fixed wrench (torque, force).
  struct MotionTangents {
    Columns V_s, A_s, A_v;
    Eigen::MatrixXd map_s;
  };
  void motion_tangents(const Place& place, const double* s, const double* s_dot, const double* s_ddot,
                       const Vector6d& wrench, MotionTangents& out) const;

  /// Integrals over the mass, about the start: see mbs/bodies/flexible_body.hpp.
  struct Integrals {
    Vector3d d;
    Matrix3d J;
    Eigen::Matrix3Xd C_t, C_r;
    Eigen::MatrixXd M;
  };
  void integrate(const double* s, Integrals& out) const;

  /// The start turns with w and alpha and is accelerated by a - g, all in its own axes.
  struct Carried {
    Vector3d w = Vector3d::Zero(), alpha = Vector3d::Zero(), a = Vector3d::Zero();
  };
  /// Wrench (torque about the start, force) and generalised forces (n) that the mass needs to move so.
  Vector6d inertia_force(const double* s, const double* s_dot, const double* s_ddot, const Carried& start,
                         double* need) const;
  /// Of both by s and s' (6 x n, n x n).
  struct InertiaTangents {
    Columns wrench_s, wrench_v;
    Eigen::MatrixXd need_s, need_v;
  };
  void inertia_tangents(const double* s, const double* s_dot, const double* s_ddot, const Carried& start,
                        InertiaTangents& out) const;
  /// Of both by w (6 x 3, n x 3), at s'' = alpha = a = 0.
  void turning_tangents(const double* s, const double* s_dot, const Vector3d& w,
                        Eigen::Matrix<double, 6, 3>& wrench_w,
                        Eigen::Matrix<double, Eigen::Dynamic, 3>& need_w) const;

 private:
  template <int N>
  friend struct Kernel;
  template <int N>
  void integrate_in(const double* s, Integrals& out) const;

  StrainField field_;
  double length_;
  SectionInertia inertia_;
  Vector6d rest_;
  bool has_offset_;  ///< of the mass from the axis
  std::array<Place, kPoints> points_;
  std::array<double, kPoints> mass_weight_;  ///< [m]
};

}  // namespace flexura::beam::exact
