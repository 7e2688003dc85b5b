// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/buckling.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/statics/statics.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

namespace flexura::mbs {
namespace {

/// A weight on the tip of a column that stands on its root, x upwards.
Mechanism column(const superelement::Superelement& se, double gravity, double weight) {
  MechanismDescription d;
  d.gravity = {-gravity, 0.0, 0.0};
  BasisOptions options;
  options.stiffening = true;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  options.modes = 12;
  options.loads = interface_loads(se, std::vector<int>{0, 1});
  const int beam =
      d.add_body({.name = "column", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  d.add_joint("foot", "fixed", d.add_marker(0, "ground"), d.add_marker(beam, "foot", {}, 0));
  const int load =
      d.add_body({.name = "weight",
                  .inertia = RigidInertia::from_center(weight, {0, 0, 0}, 1e-6 * Matrix3d::Identity())});
  d.add_joint("top", "fixed", d.add_marker(beam, "top", {}, 1), d.add_marker(load, "in"));
  return Mechanism(d);
}

StaticStiffness at_rest(const Mechanism& mechanism) {
  State s = mechanism.initial_state();
  solve_statics(mechanism, s);
  return static_stiffness(mechanism, s);
}

TEST(Buckling, OfColumnsUnderATipLoadAndTheirOwnWeight) {
  beams::StraightBeam b;  // L = EI = 1
  b.EA = 1e7;
  b.GI_t = 10.0;
  b.EI_y = 4.0;
  b.elements = 12;
  const superelement::Superelement se = beams::beam_superelement(b);
  // Euler: P = pi^2 EI / (4 L^2), and four times it about the other axis.
  const double P = 0.05;
  const auto tip =
      buckling_modes(at_rest(column(se, 0.0, 1000.0)), at_rest(column(se, P / 1000.0, 1000.0))).modes;
  const double euler = std::numbers::pi * std::numbers::pi / 4.0;
  // Own weight P/1000 beside it: 1e-3 of the load at 0.315 of its effect; finite elements 1e-6.
  EXPECT_NEAR(tip[0].factor * P, euler, 4e-4 * euler);
  EXPECT_NEAR(tip[1].factor * P, 4.0 * euler, 4e-4 * 4.0 * euler);
  // Greenhill: q L = 7.8373 EI / L^2.
  const double q = 0.1;
  const auto own = buckling_modes(at_rest(column(se, 0.0, 1e-9)), at_rest(column(se, q, 1e-9))).modes;
  EXPECT_NEAR(own[0].factor * q, 7.83735, 2e-3 * 7.83735);  // 12 bending modes and response modes: some 1e-4
}

}  // namespace
}  // namespace flexura::mbs
