// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mbs/forces/applied.hpp"
#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/statics/statics.hpp"
#include "tests/mbs/model/checks.hpp"

/// Geometrically exact beams, rods and cables as bodies of mechanisms.
namespace flexura::mbs {
namespace {

using beam::exact::Kind;
using std::numbers::pi;

int marker_on(MechanismDescription& d, const Segments& beam, int station, const std::string& name,
              const Pose& X = {}) {
  const Segments::Seat& seat = beam.seats[static_cast<std::size_t>(station)];
  return d.add_marker(seat.body, name, {X.R, seat.p + X.p}, seat.node);
}

class OfEveryKind : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(ExactBeam, OfEveryKind, testing::Values(Kind::beam, Kind::rod, Kind::cable));

TEST_P(OfEveryKind, IdentitiesOfMechanicsHold) {
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
  part.C(0, 4) = part.C(4, 0) = 3.0;
  part.C(3, 4) = part.C(4, 3) = 1.0;
  part.mass_per_length = 1.3;
  part.rho_I_y = 0.1;
  part.rho_I_z = 0.15;
  part.curvature = {0.1, -0.2, 0.3};
  part.points = {{"middle", 0.4}};
  const int root = d.add_body({.name = "beam"});
  const Segments beam = add_exact_elements(d, root, part, GetParam());
  d.add_joint("root", "revolute", d.add_marker(carrier, "hand", random.pose()),
              marker_on(d, beam, 0, "root", random.pose()));
  const int weight = d.add_body({.name = "weight", .inertia = random.inertia()});
  d.add_joint("tip", "prismatic", marker_on(d, beam, 1, "tip", random.pose()),
              d.add_marker(weight, "in", random.pose()));
  const int bob = d.add_body({.name = "bob", .inertia = random.inertia()});
  d.add_joint("middle", "cylindrical", marker_on(d, beam, 2, "middle", random.pose()),
              d.add_marker(bob, "in", random.pose()));
  const Mechanism mechanism(d);
  checks::all_identities_hold(mechanism, 7);
  checks::lagrange_equations_hold(mechanism, checks::random_state(mechanism, 9, 0.3), 11);
}

BeamPart cantilever(int elements) {
  BeamPart part;  // L = EI = 1 along x
  part.elements = elements;
  part.C = Vector6d(1e5, 1e5, 1e5, 1.0, 1.0, 1.0).asDiagonal();
  part.mass_per_length = 1.0;
  part.rho_I_y = part.rho_I_z = 1e-4;
  return part;
}

/// Where the tip of a clamped beam goes under a dead force at it.
Vector3d tip_under_force(const BeamPart& part, Kind kind, const Vector3d& force) {
  MechanismDescription d;
  d.gravity.setZero();
  const int root = d.add_body({.name = "beam"});
  const Segments beam = add_exact_elements(d, root, part, kind);
  const int wall = d.add_marker(0, "wall");
  d.add_joint("clamp", "fixed", wall, d.add_marker(root, "at_root"));
  Applied::Components components;
  for (const int i : {0, 1, 2})
    components[static_cast<std::size_t>(i)] = std::make_shared<Expression>(
        "force", "F", SignalNames(), std::map<std::string, double>{{"F", force(i)}});
  d.forces.push_back(
      std::make_shared<Applied>("pull", false, marker_on(d, beam, 1, "tip"), wall, -1, components));
  const Mechanism mechanism(d);
  State s = mechanism.initial_state();
  solve_statics(mechanism, s);
  Pose X;
  for (const int piece : beam.bodies)
    X = X * mechanism.description().bodies[static_cast<std::size_t>(piece)].flexible->node_pose(
                0, s.p.data() + mechanism.modal_position(piece));
  return X.p;
}

// K. Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145: elliptic integrals for P L^2 / EI = 2 and 10, printed to
// 1e-5.  Stretch and shear are P / EA = 1e-4 at most, of a rod none.
TEST(ExactBeam, CantileverFollowsTheElastica) {
  struct {
    double P, along, down;
  } constexpr kElastica[] = {{2.0, 0.16064, 0.49346}, {10.0, 0.55500, 0.81061}};
  for (const auto& [P, along, down] : kElastica)
    for (const Kind kind : {Kind::beam, Kind::rod}) {
      SCOPED_TRACE(P);
      BeamPart part = cantilever(8);
      const Vector3d at = tip_under_force(part, kind, {0, 0, -P});
      EXPECT_NEAR(1.0 - at.x(), along, 2e-4);
      EXPECT_NEAR(-at.z(), down, 2e-4);
    }
}

// P L^3 / 3 EI + P L / GA for any number of elements.
TEST(ExactBeam, SmallDeflectionIsThatOfTheBeamWithShear) {
  for (const int elements : {1, 3}) {
    BeamPart part = cantilever(elements);
    part.C(2, 2) = 20.0;  // soft in shear
    const double P = 1e-5;
    const Vector3d at = tip_under_force(part, Kind::beam, {0, 0, -P});
    EXPECT_NEAR(-at.z(), P * (1.0 / 3.0 + 1.0 / 20.0), 1e-7 * P);  // rotations of 5e-6 enter squared
  }
}

// K.-J. Bathe, S. Bolourchi, Int. J. Numer. Meth. Eng. 14 (1979) 961: an arc of 45 degrees and radius 100 in the x-y plane,
// a unit square with E = 1e7, nu = 0, loaded at its tip along z.  Authors differ by what their elements leave: for 300 the
// tip's z is 39.5 (Bathe, Bolourchi), 40.08 (J. C. Simo, L. Vu-Quoc, Comput. Methods Appl. Mech. Eng. 58 (1986) 79, whose
// numbers stand below) and 40.35 (A. Cardona, M. Geradin, Int. J. Numer. Meth. Eng. 26 (1988) 2403): 0.45 to either side.
TEST(ExactBeam, BendsOutOfThePlaneOfItsArc) {
  struct {
    double F;
    Vector3d tip;
  } const published[] = {{300.0, {22.33, 58.84, 40.08}}, {600.0, {15.79, 47.23, 53.37}}};
  for (const auto& [F, tip] : published) {
    BeamPart part;
    part.elements = 8;
    // From the origin along y, curved towards x: about the section's z, which is -z of B.
    part.to_B = {0.0, 100.0 * pi / 4.0, 0.0};
    part.y_axis_B = {1.0, 0.0, 0.0};
    part.curvature = {0.0, 0.0, 0.01};
    part.C = Vector6d(1e7, 5e6, 5e6, 5e6 * 0.1406, 1e7 / 12.0, 1e7 / 12.0).asDiagonal();
    part.rho_I_y = part.rho_I_z = 0.1;
    const Vector3d at = tip_under_force(part, Kind::beam, {0, 0, F});
    EXPECT_NEAR(at.x(), tip.x(), 0.45);
    EXPECT_NEAR(at.y(), tip.y(), 0.45);
    EXPECT_NEAR(at.z(), tip.z(), 0.45);
  }
}

// A clamped beam's frequencies: beta^2 sqrt(EI / m L^4), errors of order 4 in the length of the elements.
TEST(ExactBeam, FrequenciesOfACantileverConvergeWithOrderFour) {
  const double beta[] = {1.8751040687, 4.6940911330};
  double error[2][2];
  for (const int i : {0, 1}) {
    MechanismDescription d;
    d.gravity.setZero();
    const int root = d.add_body({.name = "beam"});
    BeamPart part = cantilever(i == 0 ? 3 : 6);
    part.C = Vector6d(1e6, 1e6, 1e6, 1.0, 1.0, 1e4).asDiagonal();
    part.mass_per_length = 1.0;
    part.rho_I_y = part.rho_I_z = 1e-7;
    add_exact_elements(d, root, part, Kind::beam);
    d.add_joint("clamp", "fixed", d.add_marker(0, "wall"), d.add_marker(root, "at_root"));
    const Mechanism mechanism(d);
    const auto modes = natural_modes(linearise(mechanism, mechanism.initial_state()));
    for (const int k : {0, 1}) {
      const double exact = beta[k] * beta[k];
      double nearest = 1e300;
      for (const NaturalMode& mode : modes)
        nearest = std::min(nearest, std::abs(2 * pi * mode.frequency_hz - exact) / exact);
      error[i][k] = nearest;
    }
  }
  for (const int k : {0, 1}) {
    EXPECT_LT(error[1][k], k == 0 ? 1e-4 : 1e-3);
    EXPECT_GT(error[0][k] / error[1][k], 10.0);  // 16 in the limit
  }
}

}  // namespace
}  // namespace flexura::mbs
