// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/settle.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mbs/model/mechanism.hpp"
#include "mbs/model/modal_basis.hpp"
#include "mbs/solver/run.hpp"
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

TEST(Settle, CantileverUnderItsWeightHangsStill) {
  const superelement::Superelement se = unit_beam();
  MechanismDescription d;
  d.gravity = {0.0, -0.1, 0.0};
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<FlexibleBody>(modal_data(se, clamped(se)))});
  d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), d.add_marker(body, "root", {}, 0));
  const Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  const double undeformed = largest_ripple(m, s, v_dot, 4.0);
  settle(m, s, v_dot);
  const double tip = d.bodies[1].flexible->node_pose(1, s.p.data() + m.modal_position(1)).p.y();
  // g m L^4 / (8 EI); cubic elements with consistent loads are exact at their nodes.
  EXPECT_NEAR(tip, -0.0125, 1e-8);
  EXPECT_LT(largest_ripple(m, s, v_dot, 4.0), 1e-6 * undeformed);
  EXPECT_NEAR(undeformed, 2 * 0.0125, 0.1 * 2 * 0.0125);  // rings between zero and twice the sag
}

TEST(Settle, SwingingBeamStartsAlongItsMotion) {
  // A beam on a hinge in a gravity field, released with a speed: forces and rates of the deformation change
  // with the angle, slowly against its vibration.
  const superelement::Superelement se = unit_beam();
  BasisOptions options = clamped(se);
  MechanismDescription d;
  d.gravity = {0.0, -0.1, 0.0};
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<FlexibleBody>(modal_data(se, options))});
  const int hinge =
      d.add_joint("hinge", "revolute", d.add_marker(0, "wall"), d.add_marker(body, "root", {}, 0));
  d.joints[hinge].initial_speeds[0] = 0.3;
  const Mechanism m(d);
  const auto ripple = [&](bool settled) {
    State s = m.initial_state();
    VectorXd v_dot;
    assemble(m, s, v_dot);
    AssembleOptions keep;
    keep.keep_velocity = m.given_velocities();
    if (settled) settle(m, s, v_dot, keep);
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

TEST(Settle, LoopThatClosesByDeformationAloneIsRefused) {
  const superelement::Superelement se = unit_beam();
  MechanismDescription d;
  BasisOptions options;
  options.damping = 0.0;
  const int body =
      d.add_body({.name = "beam", .flexible = std::make_shared<FlexibleBody>(modal_data(se, options))});
  d.add_joint("left", "fixed", d.add_marker(0, "left"), d.add_marker(body, "root", {}, 0));
  d.add_joint("right", "fixed", d.add_marker(0, "right", {Matrix3d::Identity(), {1, 0, 0}}),
              d.add_marker(body, "tip", {}, 1));
  Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  try {
    settle(m, s, v_dot);
    FAIL() << "settled";
  } catch (const AssemblyError& error) {
    EXPECT_NE(std::string(error.what()).find("initial_deformation = \"none\""), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace flexura::mbs
