// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/reference.hpp"

/// Rotating beams: where a linear flexible body without geometric stiffening goes wrong.
/// Reference values: tests/mbs/flexible/data/README.md.
namespace flexura::mbs {
namespace {

using beams::beam_superelement;
using beams::StraightBeam;
using Eigen::VectorXd;
using std::numbers::pi;

/// The beam on a shaft along z, its root on the axis, turned by a formula of t.
MechanismDescription on_driven_shaft(const superelement::Superelement& se, const BasisOptions& options,
                                     const std::string& angle,
                                     const std::map<std::string, double>& parameters) {
  MechanismDescription d;
  const int beam =
      d.add_body({.name = "beam", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  const int hub = d.add_joint("hub", "revolute", d.add_marker(0, "shaft"), d.add_marker(beam, "root", {}, 0));
  d.joints[hub].drives[0] = std::make_shared<Expression>("hub.drive", angle, SignalNames(), parameters);
  return d;
}

/// Tip relative to the root's own frame.
Vector3d tip_displacement(const Mechanism& mechanism, const State& s) {
  const FlexibleBody& body = *mechanism.description().bodies[1].flexible;
  const double* modal = s.p.data() + mechanism.modal_position(1);
  const Pose root = body.node_pose(0, modal), tip = body.node_pose(1, modal);
  return (root.inverse() * tip).p - (body.nodes()[1].p_BoN_B - body.nodes()[0].p_BoN_B);
}

// ---- spin-up --------------------------------------------------------------------------------------------

StraightBeam simo_vu_quoc() {
  StraightBeam b;
  b.length = 10.0;
  b.elements = 16;
  b.EA = 2.8e7;
  b.EI_z = 1.4e4;
  b.EI_y = b.GI_t = 1e9;  // the motion is planar: nothing else may vibrate
  b.mass_per_length = 1.2;
  b.rho_I_y = b.rho_I_z = 6e-4;
  return b;
}

BasisOptions clamped_at_root(const superelement::Superelement& se, double max_frequency) {
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.max_frequency = max_frequency;
  options.loads = interface_loads(se, std::vector<int>{0, 1});
  options.damping = 0.0;
  options.damping_law.critical_above = 60.0;  // the axial modes follow the spin without ringing
  options.stiffening = true;
  return options;
}

const char* spin_up_angle = "t < T ? W/T * (t^2/2 + (T/(2*pi))^2 * (cos(2*pi*t/T) - 1)) : W * (t - T/2)";

struct SpinUp {
  double peak = 0.0, peak_time = 0.0, final_extension = 0.0, largest = 0.0;
  bool complete = false;
};

SpinUp spin_up(const BasisOptions& options, const superelement::Superelement& se, double end_time) {
  Mechanism mechanism(on_driven_shaft(se, options, spin_up_angle, {{"W", 6.0}, {"T", 15.0}}));
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  SolverOptions solver;
  solver.end_time = end_time;
  solver.output_step = 0.02;
  solver.tolerance = 1e-6;
  solver.max_order = 2;
  SpinUp out;
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const VectorXd&, const EnergyAccount&) {
    const Vector3d u = tip_displacement(mechanism, row);
    if (u.y() < out.peak) {
      out.peak = u.y();
      out.peak_time = row.t;
    }
    out.largest = std::max(out.largest, std::abs(u.y()));
    out.final_extension = u.x();
  };
  const RunResult result = run(mechanism, s, v_dot, solver, callbacks);
  out.complete = result.complete;
  return out;
}

TEST(SimoVuQuocSpinUp, PeakDeflectionAndSteadyExtensionWithStiffening) {
  const superelement::Superelement se = beam_superelement(simo_vu_quoc());
  BasisOptions options = clamped_at_root(se, 40.0);
  for (const int fixed_interface : {0, -1}) {
    SCOPED_TRACE(fixed_interface);
    options.fixed_interface = fixed_interface;
    const SpinUp out = spin_up(options, se, 20.0);
    ASSERT_TRUE(out.complete);
    // The reference is linear in the deflection, good to (w/L)^2 = 0.4 %: 1 %.
    const flexura::test::Reference kane = {"spin-up of Kane, Simo and Vu-Quoc: linear theory with stiffening",
                                           "the reference is good to (w/L)^2 = 0.4 %"};
    flexura::test::expect_reference("largest deflection of the tip", "m", out.peak, -0.57437, 0.01 * 0.57437,
                                    kane);
    flexura::test::expect_reference("its time", "s", out.peak_time, 6.762, 0.05, kane);
    // rho A W^2 L^3 / (3 EA), less the shortening of the vibration that is left, (w'^2 / 2) L ~ 1e-6.
    flexura::test::expect_reference("steady extension", "m", out.final_extension, 5.142857e-4,
                                    0.01 * 5.142857e-4, {"rho A W^2 L^3 / (3 EA)", "1 %"});
  }
}

TEST(SimoVuQuocSpinUp, GoesWrongWithoutStiffening) {
  // At W = 6 the linear body has passed its first clamped frequency, 3.516 sqrt(EI / rho A L^4) = 3.80 1/s,
  // and softens by W^2: it runs away, where the real beam comes to rest.
  const superelement::Superelement se = beam_superelement(simo_vu_quoc());
  BasisOptions options = clamped_at_root(se, 40.0);
  options.fixed_interface = 0;
  options.stiffening = false;
  const SpinUp out = spin_up(options, se, 11.0);
  EXPECT_GT(out.largest, 2.0 * 0.57437);
}

// ---- frequencies ----------------------------------------------------------------------------------------

/// L = m = EI = 1, so that frequencies are the dimensionless ones; slenderness L sqrt(A/I) = 70.
StraightBeam slender() {
  StraightBeam b;
  b.EA = 4900.0;
  b.GI_t = 100.0;
  b.elements = 20;
  b.rho_I_y = b.rho_I_z = 1.0 / 4900.0;
  return b;
}

struct Frequencies {
  double flap = 0.0, chord = 0.0;
};

Frequencies rotating_frequencies(const superelement::Superelement& se, const BasisOptions& options,
                                 double mu) {
  Mechanism mechanism(on_driven_shaft(se, options, "mu * t", {{"mu", mu}}));
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  Frequencies out;
  const FlexibleBody& body = *mechanism.description().bodies[1].flexible;
  for (const NaturalMode& mode : natural_modes(linearise(mechanism, s))) {
    const Eigen::VectorXcd tip = body.modal()->nodes[1].Phi_t * mode.shape.tail(body.m());
    const bool flaps = std::abs(tip(2)) > std::abs(tip(1));
    double& frequency = flaps ? out.flap : out.chord;
    if (frequency == 0.0 && tip.tail<2>().norm() > std::abs(tip(0))) frequency = 2 * pi * mode.frequency_hz;
  }
  return out;
}

TEST(RotatingCantilever, FlapAndChordFrequenciesWithCoriolis) {
  const superelement::Superelement se = beam_superelement(slender());
  BasisOptions options;
  options.held = interface_loads(se, 0);
  // Some twenty bending modes in each plane and all axial ones: the chord frequency at mu = 50 is a small
  // difference of stiffening and softening.
  options.max_frequency = 4000.0 / (2 * pi);
  options.fixed_interface = 0;
  options.damping = 0.0;
  options.stiffening = true;
  const double reference[6][3] = {{2, 4.1373, 3.6195}, {4, 5.5850, 3.888},  {6, 7.3603, 4.2393},
                                  {8, 9.2568, 4.6105}, {10, 11.2023, 4.97}, {50, 51.0805, 7.3362}};
  for (const auto& [mu, flap, chord] : reference) {
    SCOPED_TRACE(mu);
    const Frequencies out = rotating_frequencies(se, options, mu);
    const flexura::test::Reference published = {
        "rotating cantilever, dimensionless frequencies over the spin, published",
        "1 %: slenderness 70 in place of a thin beam's"};
    flexura::test::expect_reference("flap at spin " + std::to_string(static_cast<int>(mu)), "", out.flap,
                                    flap, 0.01 * flap, published);
    flexura::test::expect_reference("chord at spin " + std::to_string(static_cast<int>(mu)), "", out.chord,
                                    chord, 0.01 * chord, published);
  }
  // Without stiffening the flap frequency stays where it is at rest and the chord one falls with mu.
  options.stiffening = false;
  EXPECT_NEAR(rotating_frequencies(se, options, 2.0).flap, 3.516, 0.01 * 3.516);
  EXPECT_LT(rotating_frequencies(se, options, 3.0).chord, 2.0);
}

}  // namespace
}  // namespace flexura::mbs
