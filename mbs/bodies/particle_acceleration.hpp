// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "mbs/bodies/modal_data.hpp"

namespace flexura::mbs {

/// How a body of m modal coordinates moves and what acts on its nodes, all in B.
struct BodyMotion {
  const double *s = nullptr, *s_dot = nullptr, *s_ddot = nullptr;
  Vector3d w = Vector3d::Zero(), alpha = Vector3d::Zero();  ///< of B [rad/s, rad/s^2]
  Vector3d a = Vector3d::Zero();                            ///< of Bo, less gravity [m/s^2]
  Eigen::VectorXd on_nodes = {};  ///< force and moment on each; empty where nobody asks
};

/// The acceleration less gravity, in B, of the particle that undeformed is at x, Phi its displacements by the modes:
///
///     a(x) = a + A (x + Phi s) + 2 w x Phi s' + Phi s'',     A = [alpha]x + [w]x [w]x
///          = sum_b c_b e_b + sum_ab c_(3 + 3 a + b) x_a e_b + sum_k,ab B_(9 k + 3 a + b) Phi_k,a e_b
///
/// `coupling` below full leaves out what a body's equations with it leave out.
struct ParticleAcceleration {
  Eigen::Matrix<double, 12, 1> c;
  Eigen::VectorXd B;  ///< 9 m

  ParticleAcceleration(const BodyMotion& motion, int m, Coupling coupling = Coupling::full) : B(9 * m) {
    const auto cross = [](const Vector3d& v) {
      Matrix3d out;
      out << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
      return out;
    };
    Matrix3d A = cross(motion.alpha);
    if (coupling != Coupling::constant) A += cross(motion.w) * cross(motion.w);
    c << motion.a, A.reshaped();
    const Matrix3d coriolis = 2.0 * cross(motion.w);
    for (int k = 0; k < m; ++k) {
      Matrix3d B_k = motion.s_ddot[k] * Matrix3d::Identity();
      if (coupling == Coupling::full) B_k += motion.s[k] * A + motion.s_dot[k] * coriolis;
      B.segment<9>(9 * k) = B_k.reshaped();
    }
  }
};

}  // namespace flexura::mbs
