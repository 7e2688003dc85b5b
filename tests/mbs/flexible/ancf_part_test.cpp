// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/beams/ancf_part.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/quasi_static_start.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/statics/statics.hpp"
#include "tests/mbs/model/checks.hpp"

/// ANCF beams as bodies of mechanisms.  Reference values: tests/mbs/flexible/data/README.md.
namespace flexura::mbs {
namespace {

using Eigen::VectorXd;
using std::numbers::pi;

/// The beam along x on a shaft along z, its root on the axis, turned by a formula of t.
MechanismDescription on_driven_shaft(std::shared_ptr<const FlexibleBody> beam, const std::string& angle,
                                     const std::map<std::string, double>& parameters) {
  MechanismDescription d;
  const int body = d.add_body({.name = "beam", .flexible = std::move(beam)});
  const int hub = d.add_joint("hub", "revolute", d.add_marker(0, "shaft"), d.add_marker(body, "root", {}, 0));
  d.joints[hub].drives[0] = std::make_shared<Expression>("hub.drive", angle, SignalNames(), parameters);
  return d;
}

Vector3d tip_displacement(const Mechanism& mechanism, const State& s) {
  const FlexibleBody& body = *mechanism.description().bodies[1].flexible;
  return body.node_pose(1, s.p.data() + mechanism.modal_position(1)).p - body.nodes()[1].p_BoN_B;
}

TEST(AncfPart, SpunUpBeamBendsBackAndStretches) {
  const double rho_I = 6e-4;
  const auto beam = straight_ancf_part(
      beam::ancf::uncoupled_section(2.8e7, 1e7, 1e7, 1e6, 1.4e6, 1.4e4, 1.2, 100 * rho_I, rho_I), {0, 0, 0},
      {10, 0, 0}, {0, 1, 0}, 12);
  Mechanism mechanism(
      on_driven_shaft(beam, "t < T ? W/T * (t^2/2 + (T/(2*pi))^2 * (cos(2*pi*t/T) - 1)) : W * (t - T/2)",
                      {{"W", 6.0}, {"T", 15.0}}));
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  SolverOptions solver;
  solver.method = "radau";
  solver.end_time = 20.0;
  solver.output_step = 0.02;
  solver.tolerance = 1e-4;
  double peak = 0.0, peak_time = 0.0, extension = 0.0;
  RunCallbacks callbacks;
  int rows = 0;
  callbacks.row = [&](const State& row, const VectorXd&, const EnergyAccount&) {
    const Vector3d u = tip_displacement(mechanism, row);
    if (u.y() < peak) {
      peak = u.y();
      peak_time = row.t;
    }
    if (row.t > 16.0) {
      extension += u.x();
      ++rows;
    }
  };
  const RunResult result = run(mechanism, s, v_dot, solver, callbacks);
  ASSERT_TRUE(result.complete) << result.stopped_because;
  // The reference is linear in the deflection, good to (w/L)^2 = 0.4 %; 12 elements of constant curvature: 1
  // %.
  EXPECT_NEAR(peak, -0.57437, 0.01 * 0.57437);
  EXPECT_NEAR(peak_time, 6.762, 0.05);
  EXPECT_NEAR(extension / rows, 5.142857e-4, 0.01 * 5.142857e-4);
}

TEST(AncfPart, RotatingCantileverStiffens) {
  // S. M. Hamza-Cherif, M. S. A. Houmat, ICAS 2004: L = m = EI = 1, slenderness 70.
  const double table[][3] = {
      {2, 4.1373, 3.6195}, {4, 5.5850, 3.888}, {6, 7.3603, 4.2393}, {8, 9.2568, 4.6105}, {10, 11.2023, 4.97}};
  const double EA = 4900, GA = EA * 5 / 6 / 2.6;
  const auto beam =
      straight_ancf_part(beam::ancf::uncoupled_section(EA, GA, GA, 0.8, 1, 1, 1, 1 / EA, 1 / EA), {0, 0, 0},
                         {1, 0, 0}, {0, 1, 0}, 12);
  for (const auto& [mu, flap, chord] : table) {
    SCOPED_TRACE(mu);
    Mechanism mechanism(on_driven_shaft(beam, "mu * t", {{"mu", mu}}));
    State s = mechanism.initial_state();
    VectorXd v_dot;
    assemble(mechanism, s, v_dot);
    start_quasi_static(mechanism, s, v_dot);
    double found_flap = 0.0, found_chord = 0.0;
    const int m = beam->m();
    NodeMotion tip = beam->make_node_motion();
    beam->node_motion(1, s.p.data() + mechanism.modal_position(1), nullptr, nullptr, tip);
    for (const NaturalMode& mode : natural_modes(linearise(mechanism, s))) {
      const Eigen::VectorXcd u = tip.map.bottomRows<3>() * mode.shape.tail(m);
      if (u.tail<2>().norm() < std::abs(u(0))) continue;
      double& frequency = std::abs(u(2)) > std::abs(u(1)) ? found_flap : found_chord;
      if (frequency == 0.0) frequency = 2 * pi * mode.frequency_hz;
    }
    // 1 %: linear theory against finite axial strain, mu^2/(2 EA) = 1 % at mu = 10.
    EXPECT_NEAR(found_flap, flap, 0.01 * flap);
    EXPECT_NEAR(found_chord, chord, 0.01 * chord);
  }
}

BeamPart cantilever(int elements) {
  BeamPart part;  // L = EI = 1 along x
  part.elements = elements;
  part.C = Vector6d(1e5, 1e5, 1e5, 1.0, 1.0, 1.0).asDiagonal();
  part.mass_per_length = 1e-4;
  part.rho_I_y = part.rho_I_z = 1e-8;
  return part;
}

/// Where the tip goes under a weight P EI / L^2 at it.
Vector3d tip_under_weight(MechanismDescription d, int root_body, int tip_marker, int tip_body, double P) {
  d.gravity = {0.0, 0.0, -P};
  d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), d.add_marker(root_body, "at_root"));
  const int weight =
      d.add_body({.name = "weight",
                  .inertia = RigidInertia::from_center(1.0, Vector3d::Zero(), 1e-6 * Matrix3d::Identity())});
  d.add_joint("hold", "fixed", tip_marker, d.add_marker(weight, "in"));
  (void)tip_body;
  Mechanism mechanism(d);
  State s = mechanism.initial_state();
  solve_statics(mechanism, s);
  std::vector<Pose> poses;
  const auto scratch = mechanism.make_scratch();
  mechanism.body_poses(s, *scratch, poses);
  return poses[weight].p;
}

// K. Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145: elliptic integrals for P L^2 / EI = 2 and 10,
// printed to 1e-5.
struct Elastica {
  double P, along, down;
};
constexpr Elastica kElastica[] = {{2.0, 0.16064, 0.49346}, {10.0, 0.55500, 0.81061}};

TEST(Segments, CantileverFollowsTheElastica) {
  for (const auto& [P, along, down] : kElastica) {
    SCOPED_TRACE(P);
    MechanismDescription d;
    const int beam = d.add_body({.name = "beam"});
    const Segments chain = add_segments(d, beam, cantilever(20));
    const int tip = d.add_marker(chain.bodies.back(), "tip");
    const Vector3d at = tip_under_weight(d, beam, tip, chain.bodies.back(), P);
    // A polygon for the curve: (theta / n)^2 / 8 of the length, theta = 1.4 rad, some times larger near the
    // root.
    EXPECT_NEAR(1.0 - at.x(), along, 3e-3);
    EXPECT_NEAR(-at.z(), down, 3e-3);
  }
}

TEST(Segments, SmallDeflectionIsThatOfTheBeamWithShear) {
  BeamPart part = cantilever(3);
  part.C(2, 2) = 20.0;  // soft in shear
  MechanismDescription d;
  const int beam = d.add_body({.name = "beam"});
  const Segments chain = add_segments(d, beam, part);
  const double P = 1e-5;
  const int tip = d.add_marker(chain.bodies.back(), "tip");
  const Vector3d at = tip_under_weight(d, beam, tip, chain.bodies.back(), P);
  // P L^3 / 3 EI + P L / GA for any number of segments; rotations of 5e-6 enter squared, the beam's own
  // weight is 1e-6 of P.
  EXPECT_NEAR(-at.z(), P * (1.0 / 3.0 + 1.0 / 20.0), 1e-4 * P);
}

class AncfParts : public testing::TestWithParam<bool> {};

TEST_P(AncfParts, IdentitiesOfMechanicsHold) {
  checks::Random random(5);
  MechanismDescription d;
  d.gravity = {0.3, -9.0, 1.0};
  const int carrier = d.add_body({.name = "carrier", .inertia = random.inertia()});
  d.add_joint("base", "revolute", d.add_marker(0, "o"), d.add_marker(carrier, "o", random.pose()));
  BeamPart part;
  part.from_B = {0.1, 0.2, -0.1};
  part.to_B = {1.0, 0.4, 0.3};
  part.elements = 2;
  part.C = Vector6d(50.0, 20.0, 25.0, 3.0, 4.0, 5.0).asDiagonal();
  part.mass_per_length = 1.3;
  part.rho_I_y = 0.1;
  part.rho_I_z = 0.15;
  part.points = {{"middle", 0.4}};
  part.is_planar = GetParam();
  const int beam = d.add_body({.name = "beam", .flexible = ancf_body(part)});
  d.add_joint("root", "revolute", d.add_marker(carrier, "hand", random.pose()),
              d.add_marker(beam, "root", random.pose(), 0));
  const int weight = d.add_body({.name = "weight", .inertia = random.inertia()});
  d.add_joint("tip", "prismatic", d.add_marker(beam, "tip", random.pose(), 1),
              d.add_marker(weight, "in", random.pose()));
  const int bob = d.add_body({.name = "bob", .inertia = random.inertia()});
  d.add_joint("middle", "cylindrical", d.add_marker(beam, "middle", random.pose(), 2),
              d.add_marker(bob, "in", random.pose()));
  const Mechanism mechanism(d);
  checks::all_identities_hold(mechanism, 7);
  checks::lagrange_equations_hold(mechanism, checks::random_state(mechanism, 9, 0.3), 11);
}

INSTANTIATE_TEST_SUITE_P(SpaceAndPlane, AncfParts, testing::Values(false, true));

// P L^2 / EI = 1 and 5: K. E. Bisshopp, D. C. Drucker, Quart. Appl. Math. 3 (1945) 272; tests/beam/ancf/exact/elastica.hpp.
TEST(AncfPart, PlanarCantileversBendToTheElastica) {
  for (const auto& [alpha, down, shorter] :
       {std::array{1.0, 0.30172, 0.05643}, std::array{5.0, 0.71379, 0.38763}}) {
    SCOPED_TRACE(alpha);
    MechanismDescription d;
    BeamPart part;
    checks::Random random(3);
    const Matrix3d R = random.pose().R;
    part.from_B = {0.2, -0.1, 0.4};
    part.to_B = part.from_B + R.col(0);
    part.y_axis_B = R.col(1);
    part.elements = 10;
    part.C = Vector6d(1e4, 1e4, 1e4, 1.0, 1.0, 1.0).asDiagonal();
    part.mass_per_length = 1e-5;
    part.is_planar = true;
    const int beam = d.add_body({.name = "beam", .flexible = ancf_body(part)});
    d.add_joint("root", "fixed", d.add_marker(0, "o"), d.add_marker(beam, "root"));
    const int tip = d.add_marker(beam, "tip", {}, 1), bob = d.add_body({.name = "bob", .inertia = {}});
    d.bodies[static_cast<std::size_t>(bob)].inertia.mass = alpha;
    d.bodies[static_cast<std::size_t>(bob)].inertia.inertia = Matrix3d::Identity();
    d.add_joint("hinge", "spherical", tip, d.add_marker(bob, "centre"));
    d.gravity = -R.col(1);
    const Mechanism mechanism(d);
    State s = mechanism.initial_state();
    solve_statics(mechanism, s);
    const Vector3d u = R.transpose() * tip_displacement(mechanism, s);
    // The stretch P / EA is 5e-4 at most.
    EXPECT_NEAR(-u.y(), down, 5e-4);
    EXPECT_NEAR(-u.x(), shorter, 5e-4);
    EXPECT_NEAR(u.z(), 0.0, 1e-12);
  }
}

}  // namespace
}  // namespace flexura::mbs
