// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/quasi_static_start.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// Starts without ringing.
namespace flexura::mbs {
namespace {

using Eigen::VectorXd;

superelement::Superelement unit_beam() {
  beams::StraightBeam b;  // L = m = EI = 1
  b.EA = 1e4;
  b.GI_t = 10.0;
  b.elements = 8;
  return beams::beam_superelement(b);
}

BasisOptions clamped(const superelement::Superelement& se) {
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  options.damping = 0.0;
  return options;
}

double largest_ripple(const Mechanism& m, const State& s, const VectorXd& v_dot, double end_time) {
  SolverOptions options;
  options.method = "radau";
  options.end_time = end_time;
  options.output_step = end_time / 200;
  options.tolerance = 1e-8;
  const FlexibleBody& body = *m.description().bodies[1].flexible;
  double low = 1e300, high = -1e300;
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const VectorXd&, const EnergyAccount&) {
    const double y = body.node_pose(1, row.p.data() + m.modal_position(1)).p.y();
    low = std::min(low, y);
    high = std::max(high, y);
  };
  EXPECT_TRUE(run(m, s, v_dot, options, callbacks).complete);
  return high - low;
}

TEST(QuasiStaticStart, CantileverUnderItsWeightHangsStill) {
  const superelement::Superelement se = unit_beam();
  MechanismDescription d;
  d.gravity = {0.0, -0.1, 0.0};
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, clamped(se)))});
  d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), d.add_marker(body, "root", {}, 0));
  const Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  const double undeformed = largest_ripple(m, s, v_dot, 4.0);
  start_quasi_static(m, s, v_dot);
  const double tip = d.bodies[1].flexible->node_pose(1, s.p.data() + m.modal_position(1)).p.y();
  // g m L^4 / (8 EI); cubic elements with consistent loads are exact at their nodes.
  EXPECT_NEAR(tip, -0.0125, 1e-8);
  EXPECT_LT(largest_ripple(m, s, v_dot, 4.0), 1e-6 * undeformed);
  EXPECT_NEAR(undeformed, 2 * 0.0125, 0.1 * 2 * 0.0125);  // rings between zero and twice the sag
}

TEST(QuasiStaticStart, SwingingBeamStartsAlongItsMotion) {
  // A beam on a hinge in a gravity field, released with a speed: forces and rates of the deformation change
  // with the angle, slowly against its vibration.
  const superelement::Superelement se = unit_beam();
  BasisOptions options = clamped(se);
  MechanismDescription d;
  d.gravity = {0.0, -0.1, 0.0};
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  const int hinge =
      d.add_joint("hinge", "revolute", d.add_marker(0, "wall"), d.add_marker(body, "root", {}, 0));
  d.joints[hinge].initial_speeds[0] = 0.3;
  const Mechanism m(d);
  const auto ripple = [&](bool quasi_static) {
    State s = m.initial_state();
    VectorXd v_dot;
    assemble(m, s, v_dot);
    AssembleOptions keep;
    keep.keep_velocity = m.given_velocities();
    if (quasi_static) start_quasi_static(m, s, v_dot, keep);
    EXPECT_NEAR(s.v(0), 0.3, 1e-12);
    // Acceleration of the lowest mode against omega^2 times its size.
    const FlexibleBody& beam = *d.bodies[1].flexible;
    double largest = 0.0;
    for (int k = 0; k < beam.m(); ++k)
      largest = std::max(largest, std::abs(v_dot(m.sizes().n_v - beam.m() + k)) / beam.amplitude(k));
    return largest;
  };
  const double before = ripple(false);
  // s'' of the quasi-static motion is (rate / omega)^2 of omega^2 s: (1 / 15)^2 for a first frequency of 15
  // 1/s.
  EXPECT_LT(ripple(true), 0.02 * before);
}

// Faster than its first clamped frequency the pull resists more than bending does: the body's own stiffness
// alone would let a rounding error grow fourfold in each iteration.
TEST(QuasiStaticStart, FastTurningBeamStretches) {
  const superelement::Superelement se = unit_beam();
  BasisOptions options = clamped(se);
  options.stiffening = true;
  MechanismDescription d;
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  const int hub = d.add_joint("hub", "revolute", d.add_marker(0, "shaft"), d.add_marker(body, "root", {}, 0));
  d.joints[hub].drives[0] =
      std::make_shared<Expression>("hub.drive", "8 * t", SignalNames(), std::map<std::string, double>());
  const Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  start_quasi_static(m, s, v_dot);
  const Vector3d tip = d.bodies[1].flexible->node_pose(1, s.p.data() + m.modal_position(1)).p;
  // u'' + k^2 (x + u) = 0, u(0) = u'(1) = 0, k^2 = W^2 m / EA: u(1) = tan k / k - 1.  Eight linear elements:
  // (k/8)^2 / 12 of k^2 / 3.
  const double k = std::sqrt(64.0 / 1e4), exact = std::tan(k) / k - 1.0;
  EXPECT_NEAR(tip.x() - 1.0, exact, 1e-4 * exact);
  EXPECT_LT(tip.tail<2>().norm(), 1e-9);
  EXPECT_LT(v_dot.cwiseAbs().maxCoeff(), 1e-6);
}

// A beam between two walls, sagging under its weight: no rigid motion closes that loop.
TEST(QuasiStaticStart, BeamBetweenWallsHangsStill) {
  const superelement::Superelement se = unit_beam();
  MechanismDescription d;
  d.gravity = {0.0, -0.1, 0.0};
  BasisOptions options;
  options.damping = 0.0;
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  d.add_joint("left", "fixed", d.add_marker(0, "left"), d.add_marker(body, "root", {}, 0));
  d.add_joint("right", "fixed", d.add_marker(0, "right", {Matrix3d::Identity(), {1, 0, 0}}),
              d.add_marker(body, "tip", {}, 1));
  const Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  const double before = v_dot.cwiseAbs().maxCoeff();
  start_quasi_static(m, s, v_dot);
  EXPECT_LT(v_dot.cwiseAbs().maxCoeff(), 1e-9 * before);
  // The work of the load 0.1 on the deflection q x^2 (L - x)^2 / (24 EI): q^2 L^5 / (1440 EI), exact at the
  // nodes of cubic elements; between n of them the energy of each clamped piece, 1 / n^4 of the whole, is
  // missing.  Rotary inertia takes no part in rest.
  const double exact = 0.01 / 1440.0;
  const FlexibleBody& beam = *d.bodies[1].flexible;
  EXPECT_NEAR(beam.strain_energy(s.p.data() + m.modal_position(body)), exact * (1.0 - std::pow(8.0, -4.0)),
              1e-6 * exact);
}

// A crank that turns a rod in its plane, the rod's other end on a slide: three of the loop's five rows lie
// out of the plane, where only the rod's modes move.
TEST(QuasiStaticStart, PlanarLoopWithRowsOutOfItsPlane) {
  const superelement::Superelement se = unit_beam();
  BasisOptions options;
  options.damping = 0.0;
  MechanismDescription d;
  d.gravity = {0.0, -0.1, 0.0};
  const auto rigid = RigidInertia::from_center(1.0, {0, 0, 0}, Vector3d(0.1, 0.1, 0.1).asDiagonal());
  const int crank = d.add_body({.name = "crank", .inertia = rigid});
  const int slide = d.add_body({.name = "slide", .inertia = rigid});
  const int rod =
      d.add_body({.name = "rod", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  const int main = d.add_joint("main", "revolute", d.add_marker(0, "shaft"), d.add_marker(crank, "shaft"));
  d.joints[main].initial_coordinates[0] = 1.0;
  d.joints[main].initial_speeds[0] = 0.3;
  const Matrix3d z_to_x = rotation_exp({0.0, 0.5 * M_PI, 0.0});
  const int guide = d.add_joint("guide", "prismatic", d.add_marker(0, "guide", {z_to_x, {0, 0, 0}}),
                                d.add_marker(slide, "slide", {z_to_x, {0, 0, 0}}));
  d.joints[guide].initial_coordinates[0] = 1.1;
  d.add_joint("big_end", "revolute", d.add_marker(crank, "pin", {Matrix3d::Identity(), {0.25, 0, 0}}),
              d.add_marker(rod, "big_end", {}, 0));
  const int pin =
      d.add_joint("small_end", "revolute", d.add_marker(rod, "small_end", {}, 1), d.add_marker(slide, "pin"));
  d.joints[pin].cut = true;
  const Mechanism m(d);
  const auto start = [&](bool quasi_static) {
    State s = m.initial_state();
    VectorXd v_dot;
    AssembleOptions keep;
    keep.keep_velocity = m.given_velocities();
    keep.keep_position.assign(m.sizes().n_v, false);
    keep.keep_position[0] = true;
    assemble(m, s, v_dot, keep);
    if (quasi_static) start_quasi_static(m, s, v_dot, keep);
    EXPECT_NEAR(s.p(0), 1.0, 1e-12);
    EXPECT_NEAR(s.v(0), 0.3, 1e-9);
    VectorXd g(m.sizes().n_lambda), g_dot(m.sizes().n_lambda);
    m.constraints(s.t, s.p, s.v, *m.make_scratch(), g, g_dot);
    EXPECT_LT(g.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(g_dot.cwiseAbs().maxCoeff(), 1e-9);
    const FlexibleBody& beam = *d.bodies[rod].flexible;
    double largest = 0.0;
    for (int k = 0; k < beam.m(); ++k)
      largest = std::max(largest, std::abs(v_dot(m.modal_position(rod) + k)) / beam.amplitude(k));
    return largest;
  };
  // As for the swinging beam: what is left is of second order in the motion's rate over the frequencies, here
  // (1 / 22)^2 for a first frequency of the free beam of 22 1/s.
  EXPECT_LT(start(true), 0.02 * start(false));
}

}  // namespace
}  // namespace flexura::mbs
