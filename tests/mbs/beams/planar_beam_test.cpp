// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "beam/exact/planar_chain.hpp"
#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "tests/mbs/model/checks.hpp"

/// Beams, rods and cables that bend in a plane alone: mechanics, and the spatial ones in that plane.
namespace flexura::mbs {
namespace {

using beam::exact::Element;
using beam::exact::Kind;
using beam::exact::PlanarChain;
using Eigen::MatrixXd;
using Eigen::VectorXd;

class PlanarBeams : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(OfEveryKind, PlanarBeams, testing::Values(Kind::beam, Kind::rod, Kind::cable));

BeamPart part_in_space() {
  BeamPart part;
  part.from_B = {0.1, 0.2, -0.1};
  part.to_B = {1.0, 0.4, 0.3};
  part.elements = 3;
  part.C = Vector6d(50.0, 20.0, 25.0, 3.0, 4.0, 5.0).asDiagonal();
  part.C(0, 5) = part.C(5, 0) = 3.0;
  part.C(2, 3) = part.C(3, 2) = 1.0;
  part.mass_per_length = 1.3;
  part.m_y = 0.07;
  part.rho_I_y = 0.1;
  part.rho_I_z = 0.15;
  part.curvature = {0.0, 0.0, 0.3};
  part.points = {{"middle", 0.4}};
  part.is_planar = true;
  return part;
}

MechanismDescription mechanism_of(const BeamPart& part, Kind kind, bool in_plane) {
  checks::Random random(5);
  MechanismDescription d;
  d.gravity = {0.3, -9.0, 1.0};
  const int carrier = d.add_body({.name = "carrier", .inertia = random.inertia()});
  const Pose base = random.pose(), hand = random.pose(), root_pose = random.pose(), tip = random.pose(),
             in_weight = random.pose(), middle = random.pose(), in_bob = random.pose();
  const RigidInertia of_weight = random.inertia(), of_bob = random.inertia();
  const int root = d.add_body({.name = "beam"});
  const Segments beam = add_exact_elements(d, root, part, kind);
  const auto marker_on = [&](int station, const std::string& name, const Pose& X) {
    const Segments::Seat& seat = beam.seats[static_cast<std::size_t>(station)];
    return d.add_marker(seat.body, name, {X.R, seat.p + X.p}, seat.node);
  };
  if (in_plane) {  // the plane's normal is that of the joints
    const Pose axes{part.R_BE(), Vector3d::Zero()};
    d.gravity = part.R_BE() * Vector3d(3.0, -8.0, 0.0);
    d.add_joint("base", "revolute", d.add_marker(0, "o", axes), d.add_marker(carrier, "o", axes));
    d.add_joint("root", "revolute",
                d.add_marker(carrier, "hand", axes * Pose{Matrix3d::Identity(), {0.3, 0.2, 0.0}}),
                marker_on(0, "root", axes));
    const int weight = d.add_body({.name = "weight", .inertia = of_weight});
    d.add_joint("tip", "revolute", marker_on(1, "tip", axes), d.add_marker(weight, "in", axes));
    return d;
  }
  d.add_joint("base", "universal", d.add_marker(0, "o"), d.add_marker(carrier, "o", base));
  d.add_joint("root", "revolute", d.add_marker(carrier, "hand", hand), marker_on(0, "root", root_pose));
  const int weight = d.add_body({.name = "weight", .inertia = of_weight});
  d.add_joint("tip", "prismatic", marker_on(1, "tip", tip), d.add_marker(weight, "in", in_weight));
  const int bob = d.add_body({.name = "bob", .inertia = of_bob});
  d.add_joint("middle", "cylindrical", marker_on(2, "middle", middle), d.add_marker(bob, "in", in_bob));
  return d;
}

TEST_P(PlanarBeams, IdentitiesOfMechanicsHoldInSpace) {
  const Mechanism mechanism(mechanism_of(part_in_space(), GetParam(), false));
  checks::all_identities_hold(mechanism, 7);
  checks::lagrange_equations_hold(mechanism, checks::random_state(mechanism, 9, 0.3), 11);
}

// Where nothing leaves the plane the derivatives are others.
TEST_P(PlanarBeams, IdentitiesOfMechanicsHoldInThePlane) {
  const Mechanism mechanism(mechanism_of(part_in_space(), GetParam(), true));
  checks::all_identities_hold(mechanism, 7);
  checks::lagrange_equations_hold(mechanism, checks::random_state(mechanism, 9, 0.3), 11);
}

// Many elements stand in several bodies, whose seams nobody sees.
TEST_P(PlanarBeams, IdentitiesOfMechanicsHoldOfSeveralPieces) {
  BeamPart part = part_in_space();
  part.elements = 40;
  const MechanismDescription d = mechanism_of(part, GetParam(), true);
  EXPECT_GT(d.bodies.size(), 4u);
  const Mechanism mechanism(d);
  const State s = checks::random_state(mechanism, 3, 0.02);
  checks::mass_matrix_is_slope_of_momentum(mechanism, s);
  checks::kinetic_energy_is_quadratic_form(mechanism, s);
}

// The element in space, strained in its plane alone, its start moved in space at will: the same forces and wrench, to round-off.
TEST_P(PlanarBeams, ElementIsThatInSpaceStrainedInItsPlane) {
  const Kind kind = GetParam();
  const BeamPart part = part_in_space();
  const double l = 0.7;
  Vector6d rest = Vector6d::Zero();
  rest.tail<3>() = part.curvature;
  const auto field = beam::exact::strain_field(kind, part.C, l);
  const Element in_space(field, l, part.section_inertia(), rest);
  const PlanarChain planar(beam::exact::planar_field(kind, part.C, l), 1, l, part.section_inertia(),
                           part.curvature.z());
  std::vector<int> kept;  // of the coordinates in space
  for (int j = 0; j < in_space.n(); ++j)
    if (field.g_0.col(j).head<2>().norm() + field.g_1.col(j).head<2>().norm() + std::abs(field.k_0(2, j)) +
            std::abs(field.k_1(2, j)) >
        1e-12)
      kept.push_back(j);
  ASSERT_EQ(static_cast<int>(kept.size()), planar.n());
  checks::Random random(3);
  for (int trial = 0; trial < 5; ++trial) {
    const VectorXd s = random.vector(planar.n(), 0.5), v = random.vector(planar.n()),
                   a = random.vector(planar.n());
    VectorXd S = VectorXd::Zero(in_space.n()), V = S, A = S, need(planar.n()), Need(in_space.n());
    S(kept) = s;
    V(kept) = v;
    A(kept) = a;
    const Element::Carried start{random.vector3(2.0), random.vector3(2.0), random.vector3(5.0)};
    PlanarChain::Pass pass = planar.make_pass();
    planar.move(s.data(), v.data(), a.data(), pass);
    const Vector6d ours = planar.inertia_force(pass, start, need.data()),
                   theirs = in_space.inertia_force(S.data(), V.data(), A.data(), start, Need.data());
    EXPECT_LT((ours - theirs).norm(), 1e-13 * theirs.norm());
    EXPECT_LT((need - Need(kept)).norm(), 1e-13 * Need.norm());
    Element::Integrals is, of;
    planar.integrate(pass, is);
    in_space.integrate(S.data(), of);
    EXPECT_LT((is.J - of.J).norm(), 1e-13 * of.J.norm());
    EXPECT_LT((is.M - of.M(kept, kept)).norm(), 1e-13 * of.M.norm());
    EXPECT_LT((is.C_r - of.C_r(Eigen::all, kept)).norm(), 1e-13 * of.C_r.norm());
    const auto at = planar.place(0, 0.6 * l);
    const auto there = in_space.place(0.6 * l);
    const Element::Motion x = planar.motion(at, s.data(), v.data(), a.data(), pass),
                          y = in_space.motion(there, S.data(), V.data(), A.data());
    EXPECT_LT((x.p - y.p).norm() + (x.R - y.R).norm(), 1e-13);
    EXPECT_LT((x.V - y.V).norm() + (x.A - y.A).norm(), 1e-12 * (1.0 + y.A.norm()));
  }
}

}  // namespace
}  // namespace flexura::mbs
