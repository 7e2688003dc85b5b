// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <random>

#include "mbs/mechanism/mechanism.hpp"

/// Identities that every mechanism must satisfy at every state, consistent or not.  Scales: coordinates,
/// speeds, lengths and masses of the test mechanisms are of order one.
namespace flexura::mbs::checks {

using Eigen::MatrixXd;
using Eigen::VectorXd;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double low = -1.0, double high = 1.0) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  VectorXd vector(int n, double size = 1.0) {
    VectorXd x(n);
    for (double& value : x) value = size * (*this)();
    return x;
  }
  Vector3d vector3(double size = 1.0) { return {size * (*this)(), size * (*this)(), size * (*this)()}; }
  Pose pose(double size = 0.5) { return {rotation_exp(vector3(2.0)), vector3(size)}; }
  /// Mass, centre and inertia of four random point masses: always possible.
  RigidInertia inertia() {
    RigidInertia I;
    for (int i = 0; i < 4; ++i) {
      const Vector3d x = vector3(0.6);
      const double m = (*this)(0.2, 1.0);
      I.mass += m;
      I.mass_center += m * x;
      I.inertia += m * (x.squaredNorm() * Matrix3d::Identity() - x * x.transpose());
    }
    return I;
  }

 private:
  std::mt19937 engine_;
};

/// p moved from the initial one by a random tangent of this size; modal coordinates by as much at the nodes.
State random_state(const Mechanism& mechanism, unsigned seed, double size = 0.7);

/// State and acceleration carried forward by h: second order in h.
State carried(const Mechanism& mechanism, const State& s, const VectorXd& v_dot, double h);

VectorXd momentum(const Mechanism& mechanism, const State& s, const VectorXd& v_dot);

/// momentum(v_dot) is affine in v_dot with the slope M; M is symmetric and positive definite.
void mass_matrix_is_slope_of_momentum(const Mechanism& mechanism, const State& s);

/// T = v^T M v / 2.
void kinetic_energy_is_quadratic_form(const Mechanism& mechanism, const State& s);

/// G is the derivative of g; G v + g_t, G^T x and the second derivative agree with it.
void constraints_are_consistent(const Mechanism& mechanism, const State& s, unsigned seed);

/// (T + U + V)' = v . r + input - dissipated - lambda . (G v + g_t) for any acceleration and any multipliers.
void power_balances(const Mechanism& mechanism, const State& s, unsigned seed);

/// For coordinates with p' = v (no quaternions) and no applied forces but conservative ones and constraints:
/// r = d/dt (dT/dv) - d(T - U - V)/dp + G^T lambda, every component.
void lagrange_equations_hold(const Mechanism& mechanism, const State& s, unsigned seed);

void all_identities_hold(const Mechanism& mechanism, unsigned seed);

/// Newton's method with least-norm steps; the residual is below 1e-13 afterwards.
void assemble(const Mechanism& mechanism, State& s);

/// Three slides and two turns carry a flexible body, held at a marker on its left node; on its right node
/// (some with an offset) sit a rigid body, by `middle_joint`, and, by a reversed slide, another flexible one.
MechanismDescription chain_of(std::shared_ptr<const FlexibleBody> first_body,
                              std::shared_ptr<const FlexibleBody> second_body,
                              const std::string& middle_joint);
/// The flexible bodies' numbers in it.
inline constexpr int chain_first = 6, chain_second = 8;

}  // namespace flexura::mbs::checks
