// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "mbs/equations/equations.hpp"

/// Small systems with exact solutions, for tests of the solvers.
namespace flexura::mbs::test {

/// Everything without constraints, dynamic states, switches: what a small system overrides less.
class SimpleEquations : public Equations {
 public:
  std::unique_ptr<Scratch> make_scratch() const override { return std::make_unique<Scratch>(); }
  void kinematic(ConstVectorRef, ConstVectorRef w, VectorRef p_dot) const override { p_dot = w; }
  void retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const override { p_out = p + d; }
  void position_constraints(When, ConstVectorRef, Scratch&, VectorRef) const override {}
  void velocity_constraints(When, ConstVectorRef, ConstVectorRef, Scratch&, VectorRef) const override {}
  void acceleration_constraints(When, ConstVectorRef, ConstVectorRef, ConstVectorRef, Scratch&,
                                VectorRef) const override {}
  void apply_GT(When, ConstVectorRef, ConstVectorRef, Scratch&, VectorRef f_c) const override {
    f_c.setZero();
  }
  void constraint_matrix(When, ConstVectorRef, Scratch&, MatrixRef) const override {}
  EnergyReport energy(const State&, ConstVectorRef, Scratch&) const override { return {}; }
  void roots(const State&, Scratch&, VectorRef) const override {}
  bool on_root(int, State&, Scratch&) const override { return false; }
  std::string name_of_position(int i) const override { return "p" + std::to_string(i); }
  std::string name_of_velocity(int i) const override { return "v" + std::to_string(i); }
  std::string name_of_dynamic(int i) const override { return "c" + std::to_string(i); }
  std::string name_of_constraint(int i) const override { return "g" + std::to_string(i); }
  std::string name_of_algebraic(int i) const override { return "a" + std::to_string(i); }
};

/// IFToMM A01: a point mass of 1 kg on a massless rod of 1 m in Cartesian coordinates, g = (x^2 + y^2 - 1)
/// / 2.
class CartesianPendulum : public SimpleEquations {
 public:
  Sizes sizes() const override { return {.n_p = 2, .n_v = 2, .n_lambda = 1}; }
  void momentum(const State& s, ConstVectorRef v_dot, Scratch&, VectorRef r, VectorRef,
                VectorRef) const override {
    r = v_dot + s.p * s.lambda(0);
    r(1) += 9.81;
  }
  void position_constraints(When, ConstVectorRef p, Scratch&, VectorRef g) const override {
    g(0) = 0.5 * (p.squaredNorm() - 1.0);
  }
  void velocity_constraints(When, ConstVectorRef p, ConstVectorRef v, Scratch&, VectorRef g) const override {
    g(0) = p.dot(v);
  }
  void acceleration_constraints(When, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot, Scratch&,
                                VectorRef g) const override {
    g(0) = p.dot(v_dot) + v.squaredNorm();
  }
  void apply_GT(When, ConstVectorRef p, ConstVectorRef x, Scratch&, VectorRef f_c) const override {
    f_c = p * x(0);
  }
  void constraint_matrix(When, ConstVectorRef p, Scratch&, MatrixRef G) const override { G = p.transpose(); }
  void mass_matrix(ConstVectorRef, Scratch&, MatrixRef M) const override { M.setIdentity(); }
  EnergyReport energy(const State& s, ConstVectorRef, Scratch&) const override {
    return {.kinetic = 0.5 * s.v.squaredNorm(), .potential = 9.81 * s.p(1)};
  }
};

/// A rigid body free in space: p = (position in W, quaternion w x y z of R_WB), v = (velocity in W, w_WB_B).
class FreeBody : public SimpleEquations {
 public:
  double mass = 2.0;
  Eigen::Vector3d inertia{0.1, 0.25, 0.3};

  static Eigen::Quaterniond attitude(ConstVectorRef p) {
    return Eigen::Quaterniond(p(3), p(4), p(5), p(6)).normalized();
  }
  Eigen::Vector3d angular_momentum(const State& s) const {
    return attitude(s.p) * inertia.cwiseProduct(s.v.tail<3>());
  }
  Sizes sizes() const override { return {.n_p = 7, .n_v = 6}; }
  void kinematic(ConstVectorRef p, ConstVectorRef w, VectorRef p_dot) const override {
    p_dot.head<3>() = w.head<3>();
    const double q0 = p(3), q1 = p(4), q2 = p(5), q3 = p(6), a = w(3), b = w(4), c = w(5);
    p_dot(3) = 0.5 * (-q1 * a - q2 * b - q3 * c);
    p_dot(4) = 0.5 * (q0 * a + q2 * c - q3 * b);
    p_dot(5) = 0.5 * (q0 * b + q3 * a - q1 * c);
    p_dot(6) = 0.5 * (q0 * c + q1 * b - q2 * a);
  }
  void retract(ConstVectorRef p, ConstVectorRef d, VectorRef p_out) const override {
    const Eigen::Vector3d w = d.tail<3>();
    const double angle = w.norm();
    const double factor = angle > 1e-8 ? std::sin(0.5 * angle) / angle : 0.5;
    Eigen::Quaterniond turn(std::cos(0.5 * angle), factor * w.x(), factor * w.y(), factor * w.z());
    const Eigen::Quaterniond q = (attitude(p) * turn).normalized();
    p_out.head<3>() = p.head<3>() + d.head<3>();
    p_out(3) = q.w();
    p_out.tail<3>() = q.vec();
  }
  void momentum(const State& s, ConstVectorRef v_dot, Scratch&, VectorRef r, VectorRef,
                VectorRef) const override {
    const Eigen::Vector3d w = s.v.tail<3>();
    r.head<3>() = mass * v_dot.head<3>();
    r.tail<3>() = inertia.cwiseProduct(v_dot.tail<3>()) + w.cross(inertia.cwiseProduct(w));
  }
  void mass_matrix(ConstVectorRef, Scratch&, MatrixRef M) const override {
    M.setZero();
    M.diagonal().head<3>().setConstant(mass);
    M.diagonal().tail<3>() = inertia;
  }
  EnergyReport energy(const State& s, ConstVectorRef, Scratch&) const override {
    return {.kinetic = 0.5 * mass * s.v.head<3>().squaredNorm() +
                       0.5 * s.v.tail<3>().dot(inertia.cwiseProduct(s.v.tail<3>()))};
  }
};

/// A ball of mass m over a floor.  compliant: spring and damper while z < 0 (root state 1), force k z + d z'.
/// Otherwise an impact with restitution e.
class BouncingBall : public SimpleEquations {
 public:
  bool compliant = true;
  double mass = 0.5, stiffness = 2e4, damping = 5.0, restitution = 0.8, g = 9.81;

  Sizes sizes() const override { return {.n_p = 1, .n_v = 1, .n_root = 1}; }
  void momentum(const State& s, ConstVectorRef v_dot, Scratch&, VectorRef r, VectorRef,
                VectorRef) const override {
    r(0) = mass * (v_dot(0) + g);
    if (s.root[0] == 1) r(0) += stiffness * s.p(0) + damping * s.v(0);
  }
  void mass_matrix(ConstVectorRef, Scratch&, MatrixRef M) const override { M(0, 0) = mass; }
  EnergyReport energy(const State& s, ConstVectorRef, Scratch&) const override {
    EnergyReport e{.kinetic = 0.5 * mass * s.v(0) * s.v(0), .potential = mass * g * s.p(0)};
    if (s.root[0] == 1) {
      e.potential += 0.5 * stiffness * s.p(0) * s.p(0);
      e.dissipated_power = damping * s.v(0) * s.v(0);
    }
    return e;
  }
  void roots(const State& s, Scratch&, VectorRef values) const override {
    values(0) = s.root[0] == 1 ? -s.p(0) : s.p(0);
  }
  bool on_root(int, State& s, Scratch&) const override {
    if (compliant) {
      s.root[0] = 1 - s.root[0];
      return false;
    }
    if (s.v(0) < 0.0) s.v(0) *= -restitution;
    s.p(0) = 0.0;
    return true;
  }
  std::string name_of_root(int) const override { return "floor.contact"; }
};

/// n masses in a row between walls, joined by n + 1 equal springs: omega_k = 2 sqrt(k/m) sin(k pi / (2 (n +
/// 1))).
class SpringChain : public SimpleEquations {
 public:
  explicit SpringChain(int n) : n_(n) {}
  double mass = 0.7, stiffness = 300.0, damping = 0.0;

  double omega(int k) const {
    return 2.0 * std::sqrt(stiffness / mass) * std::sin(k * M_PI / (2.0 * (n_ + 1)));
  }
  Sizes sizes() const override { return {.n_p = n_, .n_v = n_}; }
  void momentum(const State& s, ConstVectorRef v_dot, Scratch&, VectorRef r, VectorRef,
                VectorRef) const override {
    for (int i = 0; i < n_; ++i)
      r(i) = mass * v_dot(i) + stiffness * (2.0 * s.p(i) - at(s.p, i - 1) - at(s.p, i + 1)) +
             damping * (2.0 * s.v(i) - at(s.v, i - 1) - at(s.v, i + 1));
  }
  void mass_matrix(ConstVectorRef, Scratch&, MatrixRef M) const override {
    M.setZero();
    M.diagonal().setConstant(mass);
  }
  EnergyReport energy(const State& s, ConstVectorRef, Scratch&) const override {
    EnergyReport e{.kinetic = 0.5 * mass * s.v.squaredNorm()};
    for (int i = 0; i <= n_; ++i) {
      e.potential += 0.5 * stiffness * std::pow(at(s.p, i) - at(s.p, i - 1), 2);
      e.dissipated_power += damping * std::pow(at(s.v, i) - at(s.v, i - 1), 2);
    }
    return e;
  }

 private:
  double at(ConstVectorRef x, int i) const { return i < 0 || i >= n_ ? 0.0 : x(i); }
  int n_;
};

}  // namespace flexura::mbs::test
