// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/model/model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <cmath>
#include <numbers>

#include "beam/model/mechanism.hpp"
#include "tests/beam/common.hpp"
#include "tests/beam/models.hpp"
#include "tests/beam/vibration.hpp"

namespace flexura::beam {
namespace {

using testing::divided;
using testing::entry;
using ::testing::HasSubstr;
using testing::kSteel;
using testing::refusal;
using testing::static_solution;
using testing::straight;

const std::vector<int> kClampA = {0, 1, 2, 3, 4, 5};

TEST(BeamModel, FedemCantileverUnderGravity) {
  // reference/superelement/fedem_reducer CBAR02_.nas: 1 m, PBAR constants of the deck, gravity 9.81 in +y of
  // the width direction: tip 5.62180e-5 m (six digits printed: half a unit is 5e-11).
  Constants c;
  c.A = 0.020000001;
  c.I_z = 1.666666503e-5;  // I1 bends in the plane of the orientation vector
  c.I_y = 6.666666741e-5;
  c.I_t = 4.577562868e-5;
  c.A_sy = c.A_sz = 0.833333313 * c.A;
  const Material material{"GENERIC_ISOTROPIC_STEEL", 2.067999949e11, 8.015504179e10, 7820.0};
  Model model;
  model.nodes = {{"1", {0, 0, 0}}, {"2", {0, 0, -1}}};
  model.sections = {{make_section("RECTANGLE 0.2 X 0.1", c, material), {}, {}}};
  Member member;
  member.name = "beam";
  member.end[0].node = 0;
  member.end[1].node = 1;
  member.section = 0;
  member.direction_B = Eigen::Vector3d(0, 1, 0);
  model.members = {member};
  const BeamMesh mesh(model, divided(8));
  MemberLoad gravity{0, {}, false};
  gravity.load.at_1(1) = gravity.load.at_2(1) = 9.81 * material.rho * c.A;
  const Eigen::VectorXd u = static_solution(stiffness_matrix(mesh), load_vector(mesh, {gravity}), kClampA);
  EXPECT_NEAR(u(6 + 1), 5.62180e-5, 5e-11);
  // Gravity through the consistent mass matrix is the same load.
  Eigen::VectorXd g = Eigen::VectorXd::Zero(mesh.n_dofs());
  for (int node = 0; node < mesh.n_dofs() / 6; ++node) g(6 * node + 1) = 9.81;
  const Eigen::VectorXd via_mass = static_solution(stiffness_matrix(mesh), mass_matrix(mesh) * g, kClampA);
  EXPECT_NEAR(via_mass(7), u(7), 1e-12 * u(7));
}

TEST(BeamModel, PrincetonBeamAtSmallLoad) {
  // flexible/princeton_beam.md: linear P L^3/(3 E I) = 0.0107135 m (strong axis) and 0.16005 m (weak)
  // for 8.896 N.
  const Material aluminium = isotropic("7075", 71.7e9, 0.31, 2800.0);
  const double L = 0.508, P = 8.896;
  Model model =
      straight(entry("blade", Rectangle{3.2024e-3, 12.3777e-3}, aluminium), L, Theory::euler_bernoulli);
  const auto tip = [&](int direction) {
    const BeamMesh mesh(model, divided(4));
    Eigen::VectorXd p = Eigen::VectorXd::Zero(mesh.n_dofs());
    p(6 + direction) = P;
    return static_solution(stiffness_matrix(mesh), p, kClampA)(6 + direction);
  };
  EXPECT_NEAR(tip(2), 0.0107135, 5e-8);
  EXPECT_NEAR(tip(1), 0.16005, 5e-6);
  // ANSYS' beam (csv, 0 deg) has shear and large displacements: 1 - 4/35 (P L^2/EI)^2 of the linear value for
  // the latter (series of the elastica).  What is left is its choice of shear factor, 1 % of P L/(kappa G A),
  // and its mesh: 1e-4.
  model.members[0].theory = Theory::timoshenko;
  const double alpha = P * L * L / (71.7e9 * model.sections[0].section.constants->I_y);
  EXPECT_NEAR(tip(2) * (1 - 4.0 / 35 * alpha * alpha) / 0.0107141763, 1.0, 1e-4);
}

TEST(BeamModel, OffsetsEqualRigidArms) {
  // A member whose ends sit 0.3 m off their nodes: the same as forces and levers at its ends.
  Model model = straight(entry("r", Rectangle{0.1, 0.2}, kSteel), 2.0);
  for (MemberEnd& end : model.members[0].end) end.offset_B = {0.0, 0.3, 0.1};
  const BeamMesh mesh(model, divided(3));
  Eigen::VectorXd p = Eigen::VectorXd::Zero(mesh.n_dofs());
  p.segment<3>(6) << 1000, 500, -200;
  const Eigen::VectorXd u = static_solution(stiffness_matrix(mesh), p, kClampA);
  // Own solution: end force (F, -o x F) on the bare member, displacement back through the arm.
  const Model bare = straight(entry("r", Rectangle{0.1, 0.2}, kSteel), 2.0);
  const BeamMesh bare_mesh(bare, divided(1));
  const Eigen::Vector3d o(0.0, 0.3, 0.1), F = p.segment<3>(6);
  Eigen::VectorXd q = Eigen::VectorXd::Zero(12);
  q.segment<3>(6) = F;
  q.segment<3>(9) = -o.cross(F);
  const Eigen::VectorXd d = static_solution(stiffness_matrix(bare_mesh), q, kClampA);
  const Eigen::Vector3d expected =
      Eigen::Vector3d(d.segment<3>(6)) - Eigen::Vector3d(d.segment<3>(9)).cross(o);
  EXPECT_LT((u.segment<3>(6) - expected).norm(), 1e-12 * expected.norm());
}

TEST(BeamModel, SectionForcesAreExactOnAnyMesh) {
  // Clamped-clamped member under a triangular load (beam tables, no shear): ends -q l^2/30 and -q l^2/20 at
  // the higher end, maximum field moment q l^2/46.64.  Resultants come from one element as well as from five.
  const double l = 3.0, q0 = 900.0;
  const Model model = straight(entry("r", Rectangle{0.1, 0.2}, kSteel), l, Theory::euler_bernoulli);
  for (const int n : {1, 5}) {
    const BeamMesh mesh(model, divided(n));
    MemberLoad load{0, {}, true};
    load.load.at_2(2) = q0;
    std::vector<int> fixed = kClampA;
    for (int k = 6; k < 12; ++k) fixed.push_back(k);
    const Eigen::VectorXd u = static_solution(stiffness_matrix(mesh), load_vector(mesh, {load}), fixed);
    const auto results = member_results(mesh, 0, u, 7, {load});
    ASSERT_EQ(results.size(), 7u);
    for (const MemberResult& r : results) {
      // M_y = int z sigma dA is positive when +z is pulled: load in +z on a clamped beam gives M = -q l^2/30
      // there.
      const double M = q0 * l * l * (-1.0 / 30 + 3.0 / 20 * (r.x / l) - std::pow(r.x / l, 3) / 6);
      EXPECT_NEAR(r.resultants(M_y), -M * -1.0, 1e-9 * q0 * l * l) << n << " " << r.x;
      const double t = r.x / l;  // q l^4/(120 EI) (2 t^2 - 3 t^3 + t^5)
      const double EI = kSteel.E * model.sections[0].section.constants->I_y;
      EXPECT_NEAR(r.displacement(2),
                  q0 * std::pow(l, 4) / (120 * EI) * (2 * t * t - 3 * t * t * t + std::pow(t, 5)),
                  1e-12 * q0 * std::pow(l, 4) / EI);
    }
  }
}

Model portal() {
  Model model;
  model.nodes = {
      {"foot left", {0, 0, 0}}, {"top left", {0, 0, 3}}, {"top right", {4, 0, 3}}, {"foot right", {4, 0, 0}}};
  model.sections = {entry("column", Rectangle{0.2, 0.3}, kSteel),
                    entry("beam", HollowRectangle{0.2, 0.4, 0.01, 0.02}, kSteel)};
  for (int k = 0; k < 3; ++k) {
    Member member;
    member.name = std::array<const char*, 3>{"left", "beam", "right"}[k];
    member.end[0].node = k;
    member.end[1].node = k + 1;
    member.section = k == 1;
    member.direction_B = Eigen::Vector3d(0, 1, 0);
    model.members.push_back(member);
  }
  return model;
}

TEST(BeamModel, InertiaSumsGiveTheRigidBodyAndTheMassMatrix) {
  Model model = portal();
  PointMass bell;
  bell.node = 2;
  bell.mass = 250.0;
  bell.p_NC_B = {0.1, -0.4, -0.7};
  bell.I_C_B = Eigen::Vector3d(20, 30, 25).asDiagonal();
  bell.I_C_B(0, 1) = bell.I_C_B(1, 0) = 2.0;
  model.point_masses = {bell};
  Member tie = model.members[1];  // closes the loop, so that the hinge leaves no mechanism
  tie.end[0].node = 0;
  tie.end[1].node = 3;
  model.members.push_back(tie);
  model.members[1].end[0].released[4] = true;
  const BeamMesh mesh(model, divided(4));
  const InertiaSums sums = inertia_sums(mesh);
  const SparseMatrix M = mass_matrix(mesh), difference = sums.S_uu[0] + sums.S_uu[1] + sums.S_uu[2] - M;
  EXPECT_LT(Eigen::MatrixXd(difference).cwiseAbs().maxCoeff(), 1e-12 * Eigen::MatrixXd(M).maxCoeff());
  Eigen::MatrixXd R(mesh.n_dofs(), 6);
  for (int node = 0; node < mesh.n_dofs() / 6; ++node) {
    const Eigen::Vector3d p = mesh.points()[node];
    R.block<6, 6>(6 * node, 0).setIdentity();
    R.block<3, 3>(6 * node, 3) << 0, p.z(), -p.y(), -p.z(), 0, p.x(), p.y(), -p.x(), 0;
  }
  const double mass = kSteel.rho * (2 * 0.06 * 3 + 2 * (0.2 * 0.4 - 0.18 * 0.36) * 4) + 250.0;
  EXPECT_NEAR(sums.mass, mass, 1e-12 * mass);
  const Eigen::MatrixXd rigid = R.transpose() * M * R;
  EXPECT_NEAR(rigid(0, 0), mass, 1e-12 * mass);
  const Eigen::Matrix3d J = sums.S_xx.trace() * Eigen::Matrix3d::Identity() - sums.S_xx;
  EXPECT_LT((rigid.bottomRightCorner<3, 3>() - J).norm(), 1e-12 * J.norm());
  const Eigen::MatrixXd spins = sums.S_xu * R.rightCols(3);  // int x_a (e x x)_b dm
  for (int k = 0; k < 3; ++k)
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d expected = Eigen::Vector3d::Unit(k).cross(Eigen::Vector3d(sums.S_xx.row(a)));
      for (int b = 0; b < 3; ++b) EXPECT_NEAR(spins(3 * a + b, k), expected(b), 1e-12 * J.norm());
    }
  // Strain-free but for round-off.
  const SparseMatrix K = stiffness_matrix(mesh);
  EXPECT_LT((K * R).cwiseAbs().maxCoeff(),
            1e-13 * Eigen::MatrixXd(K).cwiseAbs().maxCoeff() * R.cwiseAbs().maxCoeff());
}

TEST(BeamModel, SubdivisionByLengthAndFrequency) {
  Model model = straight(entry("r", Rectangle{0.05, 0.1}, kSteel), 2.0);
  Subdivision rule;
  rule.max_length = 0.3;
  EXPECT_EQ(elements_of(model, model.members[0], rule), 7);
  rule = {};
  rule.max_frequency_hz = 800.0;
  const int n = elements_of(model, model.members[0], rule);
  rule.max_frequency_hz = 3200.0;  // stretch and torsion waves shorten in proportion
  EXPECT_NEAR(elements_of(model, model.members[0], rule), 4.0 * n, 4.0);
  model.members[0].elements = 3;
  EXPECT_EQ(elements_of(model, model.members[0], rule), 3);
}

TEST(BeamModel, ExtrudedSurfaceEnclosesTheVolumeAndMovesWithTheBeam) {
  const BeamMesh mesh(straight(entry("r", Rectangle{0.1, 0.2}, kSteel), 2.0), divided(2));
  const ExtrudedSurface surface = extruded_surface(mesh, 4);
  // Side walls only: int x_perp . n dA = 2 V for the two cross directions (the open ends do not count there).
  double twice_volume = 0.0;
  for (int t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Eigen::Vector3d, 3> p;
    for (int k = 0; k < 3; ++k) p[k] = surface.vertices.row(surface.triangles(t, k));
    const Eigen::Vector3d normal = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]),
                          centre = (p[0] + p[1] + p[2]) / 3.0;
    twice_volume += normal.y() * centre.y() + normal.z() * centre.z();
  }
  EXPECT_NEAR(twice_volume, 2 * 0.1 * 0.2 * 2.0, 1e-13);
  // Rigid rotation about Bo's z: u = e_z x X for every vertex.
  Eigen::VectorXd u(mesh.n_dofs());
  for (int node = 0; node < mesh.n_dofs() / 6; ++node) {
    const Eigen::Vector3d p = mesh.points()[node];
    u.segment<6>(6 * node) << -p.y(), p.x(), 0, 0, 0, 1;
  }
  for (int v = 0; v < surface.vertices.rows(); ++v) {
    const MeshElement& record = mesh.elements()[surface.element[v]];
    Vector12d q;
    q << u.segment<6>(6 * record.node[0]), u.segment<6>(6 * record.node[1]);
    const Eigen::Vector3d expected(-surface.vertices(v, 1), surface.vertices(v, 0), 0.0);
    EXPECT_LT((surface.at[v] * q - expected).norm(), 1e-13);
  }
}

TEST(BeamModelRefusal, GeometryAndConnections) {
  Model model = portal();
  model.nodes[1].p_BoN_B.setZero();
  EXPECT_THAT(refusal([&] { check(model); }), HasSubstr("member \"left\" has no length"));
  model = portal();
  model.members[0].direction_B = Eigen::Vector3d(0, 0, 2);
  EXPECT_THAT(refusal([&] { check(model); }),
              HasSubstr("member \"left\": the direction (0, 0, 2) is parallel"));
  model = portal();
  model.nodes.push_back({"lost", {9, 9, 9}});
  EXPECT_THAT(refusal([&] { check(model); }), HasSubstr("node \"lost\" is not connected to any member"));
  model = portal();
  model.members.erase(model.members.begin() + 1);
  EXPECT_THAT(refusal([&] { check(model); }),
              HasSubstr("member \"right\" is not connected to member \"left\""));
  model.anchors = {3};
  EXPECT_THAT(refusal([&] { check(model); }), HasSubstr("no refusal"));
  model = portal();
  model.members[2].section_at_end = 1;
  EXPECT_THAT(refusal([&] { check(model); }),
              HasSubstr("same kind, not 4 Rectangle and 5 Rectangle, hollow"));
  model = portal();
  PointMass mass;
  mass.node = 1;
  mass.mass = -3;
  model.point_masses = {mass};
  EXPECT_THAT(refusal([&] { check(model); }), HasSubstr("node \"top left\": mass = -3 must not be negative"));
  model.point_masses[0].mass = 1;
  model.point_masses[0].I_C_B = Eigen::Vector3d(1, 1, 3).asDiagonal();
  EXPECT_THAT(refusal([&] { check(model); }), HasSubstr("no body has the inertia (1, 1, 3;"));
  model = portal();
  model.members[1].section = 7;
  EXPECT_THAT(refusal([&] { check(model); }),
              HasSubstr("member \"beam\": there is no section number 7; there are 2"));
}

TEST(BeamModelWarning, MechanismsNameTheNodeAndTheFreeDirection) {
  Model model = portal();
  const auto hinge = [&](int member, int end) { model.members[member].end[end].released[4] = true; };
  const auto release = [&](int member, int end, int dof) {
    model.members[member].end[end].released[dof] = true;
  };
  // Hinges about the members' y axes, which are B's y, across the portal's plane.  The portal is an open
  // chain: its first hinge already lets one side swing.
  release(1, 0, 4);
  EXPECT_THAT(mechanism_of(model),
              HasSubstr("the releases leave a mechanism: node \"top right\" is free to move along z"));
  // Close the loop with a ground beam: three hinges hold, a fourth makes a four-bar linkage.
  model = portal();
  Member ground = model.members[1];
  ground.name = "ground";
  ground.end[0].node = 0;
  ground.end[1].node = 3;
  model.members.push_back(ground);
  hinge(0, 1);
  hinge(1, 1);
  hinge(2, 1);
  EXPECT_EQ(mechanism_of(model), "");
  hinge(0, 0);
  EXPECT_THAT(mechanism_of(model), HasSubstr("is free to move along x"));
  // A node whose only two members are both hinged there about the same axis.
  model = portal();
  model.members.push_back(ground);
  hinge(0, 1);
  hinge(1, 0);
  const std::string text = mechanism_of(model);
  EXPECT_THAT(text, HasSubstr("node \"top left\" is free to turn about y"));
  // Within one member.
  model = portal();
  release(1, 0, 0);
  release(1, 1, 0);
  EXPECT_THAT(refusal([&] { check(model); }),
              HasSubstr("member \"beam\": its releases let it slide along its axis"));
}

TEST(BeamModelWarning, LongChainsOfMembersAreNoMechanism) {
  // 3,000 members in a row, with a hinged brace beside them: soft, not loose.  A hinge in the row itself:
  // loose.
  Model model;
  model.sections = {entry("r", Rectangle{0.1, 0.2}, kSteel)};
  const int n = 3000;
  for (int k = 0; k <= n; ++k) model.nodes.push_back({"n" + std::to_string(k), {1.0 * k, 0, 0}});
  for (int k = 0; k < n; ++k) {
    Member member;
    member.name = "m" + std::to_string(k);
    member.end[0].node = k;
    member.end[1].node = k + 1;
    member.section = 0;
    model.members.push_back(member);
  }
  Member brace = model.members[0];  // a hinged brace beside the chain
  brace.end[1].node = 5;
  brace.end[1].released[4] = true;
  brace.end[0].offset_B = brace.end[1].offset_B = {0, 0, 0.5};
  model.members.push_back(brace);
  EXPECT_EQ(mechanism_of(model), "");
  model.members[n / 2].end[0].released[4] = true;
  EXPECT_THAT(mechanism_of(model), HasSubstr("the releases leave a mechanism"));
}

TEST(BeamModelWarning, NamesOpenThinWalledMembersWithHeldWarping) {
  // Channel 100 x 50 x 5 mm by mid-line (h = 95, b = 47.5): I_t = sum b t^3/3, I_w = t b^3 h^2/12 (3b +
  // 2h)/(6b + h).
  const double h = 0.095, b = 0.0475, t = 0.005;
  Constants c = constants_of(Rectangle{0.05, 0.1}, 0.3);
  c.I_t = (2 * b + h) * t * t * t / 3;
  SectionEntry channel{make_section("channel", c, kSteel), {}, {}};
  channel.section.open_thin_walled = true;
  channel.section.I_w = t * b * b * b * h * h / 12 * (3 * b + 2 * h) / (6 * b + h);
  const Model short_member = straight(channel, 0.6);
  const auto texts = warnings(short_member, {0});
  ASSERT_EQ(texts.size(), 1u);
  EXPECT_THAT(texts[0], HasSubstr("member \"AB\": its section \"channel\" is open and thin-walled"));
  EXPECT_TRUE(warnings(short_member, {}).empty());              // both ends free
  EXPECT_TRUE(warnings(straight(channel, 60.0), {0}).empty());  // long
  Model fork = short_member;
  fork.members[0].end[0].warping_free = true;
  EXPECT_TRUE(warnings(fork, {0}).empty());
  fork.sections[0].section.I_w = 0.0;
  fork.members[0].end[0].warping_free = false;
  EXPECT_THAT(warnings(fork, {0}).at(0), HasSubstr("warping constant unknown"));
}

}  // namespace
}  // namespace flexura::beam
