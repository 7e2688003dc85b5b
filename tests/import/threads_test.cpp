// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Threads, cones, rollers in slots, and what may touch: assemblies drawn here, imported as a user does it.
#include "import/cad/threads.hpp"

#include <gmock/gmock.h>

#include <BRepPrimAPI_MakeCone.hxx>
#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <gp_Ax2.hxx>
#include <numbers>

#include "import/cad/worker/slippage.hpp"
#include "tests/import/assembly_run.hpp"

namespace flexura::test {
namespace {

using namespace drawing;
using import::cad::slippage_of;
using import::cad::thread_named;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;
using testing::UnorderedElementsAre;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

const gp_Dir kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

TopoDS_Shape cone(const gp_Pnt& foot, const gp_Dir& axis, double foot_radius, double top_radius,
                  double length) {
  return BRepPrimAPI_MakeCone(gp_Ax2(foot, axis), foot_radius, top_radius, length).Solid();
}

// r(u, v) = (u cos v, u sin v, h v): a helicoid of lead 2 pi h about z, here moved to (1, 2, 3) and turned.
TEST(Slippage, OfAHelicoidIsItsScrewOfATorusItsTurnOfACylinderNothing) {
  const Eigen::Vector3d at(1, 2, 3), axis = Eigen::Vector3d(1, -2, 2).normalized();
  const Eigen::Matrix3d R =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis).toRotationMatrix();
  constexpr int n = 200;
  for (const double h : {0.0002, -0.0002}) {
    Rows p(n, 3), m(n, 3);
    for (int k = 0; k < n; ++k) {
      const double u = 0.004 + 0.001 * std::fmod(0.57 * k, 1.0), v = 90.0 * std::fmod(0.754877666 * k, 1.0);
      const Eigen::Vector3d by_u(std::cos(v), std::sin(v), 0), by_v(-u * std::sin(v), u * std::cos(v), h);
      p.row(k) = (at + R * Eigen::Vector3d(u * std::cos(v), u * std::sin(v), h * v)).transpose();
      m.row(k) = (R * by_u.cross(by_v).normalized()).transpose();
    }
    const auto found = slippage_of(p, m);
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->lead, 2.0 * std::numbers::pi * h, 1e-9);
    EXPECT_LT(found->axis.cross(axis).norm(), 1e-6);
    EXPECT_LT((found->point - at).cross(axis).norm(), 1e-8);
  }
  Rows p(n, 3), m(n, 3);
  for (int k = 0; k < n; ++k) {
    const double u = 6.0 * std::fmod(0.57 * k, 1.0), v = 6.0 * std::fmod(0.754877666 * k, 1.0);
    const Eigen::Vector3d radial(std::cos(v), std::sin(v), 0),
        normal = std::cos(u) * radial + Eigen::Vector3d(0, 0, std::sin(u));
    p.row(k) = (at + 0.02 * radial + 0.005 * normal).transpose();
    m.row(k) = normal.transpose();
  }
  const auto torus = slippage_of(p, m);
  ASSERT_TRUE(torus);
  EXPECT_EQ(torus->lead, 0.0);
  EXPECT_LT(torus->axis.cross(Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  for (int k = 0; k < n; ++k) {  // turns and slides
    const double v = 6.0 * std::fmod(0.754877666 * k, 1.0);
    m.row(k) << std::cos(v), std::sin(v), 0.0;
    p.row(k) = 0.01 * m.row(k) + Eigen::RowVector3d(0, 0, 0.03 * std::fmod(0.57 * k, 1.0));
  }
  EXPECT_FALSE(slippage_of(p, m));
}

TEST(ThreadNames, TellDiameterLeadAndWhetherTheyDrive) {
  EXPECT_FALSE(thread_named("crank arm"));
  EXPECT_FALSE(thread_named("frame12"));
  EXPECT_NEAR(thread_named("Screw M8x40")->diameter, 0.008, 1e-12);
  EXPECT_EQ(thread_named("Screw M8x40")->lead, 0.0);  // 40 is the length
  EXPECT_NEAR(thread_named("M12x1.5")->lead, 0.0015, 1e-12);
  EXPECT_NEAR(thread_named("Spindel Tr16x4")->lead, 0.004, 1e-12);
  EXPECT_TRUE(thread_named("Spindel Tr16x4")->drives);
  EXPECT_FALSE(thread_named("M12x1.5")->drives);
  EXPECT_NEAR(import::cad::coarse_lead(0.008), 0.00125, 1e-12);
}

// A bearing cap held by bolts M8 in holes of 6.8 mm, and clearance holes in the cap: no bolt is loose.
TEST(Threads, BoltsInHolesForTheTapAreFixed) {
  const Folder folder;
  Assembly a("cap");
  TopoDS_Shape base = box({-40, -20, -40}, {40, 20, 0}), cap = box({-40, -20, 0}, {40, 20, 15});
  for (const double x : {-28.0, 28.0}) {
    base = base - cylinder({x, 0, -25}, kZ, 3.4, 25);
    cap = cap - cylinder({x, 0, 0}, kZ, 4.15, 15);
  }
  a.place(a.part("base", base), at({0, 0, 0}));
  a.place(a.part("cap", cap), at({0, 0, 0}));
  const TDF_Label bolt =
      a.part("bolt", cylinder({0, 0, -35}, kZ, 4, 35) + box({-6, -6, 0}, {6, 6, 6}));  // an edged head
  for (const double x : {-28.0, 28.0}) a.place(bolt, at({x, 0, 15}));
  const Import i = import(folder, a, {"--ground", "base"});
  for (const auto& [name, type] : i.joints) EXPECT_EQ(type, "fixed") << name;
  EXPECT_EQ(i.joints.size(), 3U);
  EXPECT_EQ(i.freedom, 0) << i.outcome.err;
  EXPECT_THAT(i.mechanism, HasSubstr("tightened against its head"));
}

// A vice: the jaw in its dovetail, a spindle that turns in the jaw between shoulders and screws into the body.
TEST(Threads, SpindleOfAViceMovesItsJaw) {
  const Folder folder;
  Assembly a("vice");
  TopoDS_Shape body = box({-20, -60, -40}, {220, 60, 15}) + box({200, -60, 15}, {220, 60, 110});
  body = body - box({-20, -20, -5}, {200, 20, 5}) - box({-20, -10, 0}, {200, 10, 15});
  body = body - cylinder({200, 0, 60}, kX, 6.0, 20);
  a.place(a.part("body", body), at({0, 0, 0}));
  TopoDS_Shape jaw =
      box({0, -20, -5}, {80, 20, 5}) + box({0, -10, 0}, {80, 10, 15}) + box({0, -50, 15}, {40, 50, 95});
  jaw = jaw - cylinder({0, 0, 60}, kX, 6.02, 24) - cylinder({24, 0, 60}, kX, 10.5, 8) -
        cylinder({32, 0, 60}, kX, 8.5, 8);
  a.place(a.part("jaw", jaw), at({40, 0, 0}));
  const TopoDS_Shape screw = cylinder({2, 0, 0}, kX, 6, 22) + cylinder({24, 0, 0}, kX, 10, 8) +
                             cylinder({32, 0, 0}, kX, 8, 10) + cylinder({42, 0, 0}, kX, 7, 180) +
                             cylinder({222, 0, 0}, kX, 14, 14);
  a.place(a.part("Tr14x3", screw), at({40, 0, 60}));
  const Import i = import(folder, a, {"--ground", "body"});
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("body_jaw", "prismatic"), Pair("jaw_Tr14x3", "revolute"),
                                             Pair("body_Tr14x3", "screw")));
  EXPECT_EQ(i.freedom, 1) << i.outcome.err;
  EXPECT_THAT(i.mechanism, HasSubstr("pitch = 0.003\n"));
  EXPECT_THAT(i.outcome.err, HasSubstr("joint body_Tr14x3 (screw) is doubtful"));
  // Two turns move the jaw by two leads.
  const Outcome driven =
      run("flexura", {"simulate", folder / "out/mechanism.toml", "-o", folder / "v.h5", "--no-estimate",
                      "--set", "solver.method=kinematics", "solver.end_time=1", "solver.output_step=0.1",
                      "joint.jaw_Tr14x3.drive=4*pi*t"});
  ASSERT_EQ(driven.exit_code, 0) << driven.err;
  const results::Run r = results::read(folder / "v.h5").runs.at(0);
  const auto& x = flexura::test::body(r, "jaw").pose;
  EXPECT_NEAR(std::abs(x(x.rows() - 1, 0) - x(0, 0)), 0.006, 1e-8);
}

TEST(Threads, SpindleDrawnAsAPlainShaftIsAScrewByItsName) {
  const Folder folder;
  Assembly a("press");
  a.place(a.part("nut block", box({-30, -30, 0}, {30, 30, 30}) - cylinder({0, 0, 0}, kZ, 10, 30)),
          at({0, 0, 0}));
  a.place(a.part("lead screw", cylinder({0, 0, -20}, kZ, 10, 100)), at({0, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("nut_block_lead_screw", "screw")));
  EXPECT_EQ(i.freedom, 1);
  EXPECT_THAT(i.outcome.err, HasSubstr("a thread by the name of lead_screw"));
}

// A bolt and a nut hold two plates with two of them: the nuts turn as little as the bolts.
TEST(Threads, BoltsWithNutsAreFixed) {
  const Folder folder;
  Assembly a("plates");
  TopoDS_Shape lower = box({-40, -20, -10}, {40, 20, 0}), upper = box({-40, -20, 0}, {40, 20, 10});
  for (const double x : {-28.0, 28.0}) {
    lower = lower - cylinder({x, 0, -10}, kZ, 4.15, 10);
    upper = upper - cylinder({x, 0, 0}, kZ, 4.15, 10);
  }
  a.place(a.part("lower", lower), at({0, 0, 0}));
  a.place(a.part("upper", upper), at({0, 0, 0}));
  const TDF_Label bolt = a.part("bolt", cylinder({0, 0, -32}, kZ, 4, 32) + cylinder({0, 0, 0}, kZ, 6.5, 5)),
                  nut =
                      a.part("nut", box({-6.5, -6.5, -6}, {6.5, 6.5, 0}) - cylinder({0, 0, -6}, kZ, 3.4, 6));
  for (const double x : {-28.0, 28.0}) {
    a.place(bolt, at({x, 0, 10}));
    a.place(nut, at({x, 0, -10}));
  }
  const Import i = import(folder, a, {"--ground", "lower"});
  for (const auto& [name, type] : i.joints) EXPECT_EQ(type, "fixed") << name;
  EXPECT_EQ(i.freedom, 0) << i.outcome.err;
}

// A valve in its seat: the stem alone would slide both ways.
TEST(Contacts, ConeInItsSeatStopsTheValve) {
  const Folder folder;
  Assembly a("valve");
  a.place(a.part("head", box({-40, -40, 0}, {40, 40, 60}) - cylinder({0, 0, 0}, kZ, 5, 60) -
                             cone({0, 0, 0}, kZ, 15, 5, 10)),
          at({0, 0, 0}));
  a.place(a.part("valve", cone({0, 0, 0}, kZ, 15, 5, 10) + cylinder({0, 0, 10}, kZ, 4.95, 80) +
                              cylinder({0, 0, -3}, kZ, 15, 3)),
          at({0, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("head_valve", "revolute")));
  EXPECT_THAT(i.mechanism, HasSubstr("# cone of valve"));
  EXPECT_THAT(i.mechanism,
              HasSubstr("confidence medium: held from one side only: 1 freedom more if it lifts off"));
}

// A roller between two flanges runs in a slot: what is judged, planes against flanges, leaves more than there is.
TEST(Contacts, RollerInASlotIsDoubtful) {
  const Folder folder;
  Assembly a("slot");
  a.place(a.part("rail", box({0, -10, 0}, {120, 10, 6}) - box({20, -4, 0}, {100, 4, 6})), at({0, 0, 0}));
  a.place(a.part("roller", cylinder({0, 0, -2}, kZ, 8, 2) + cylinder({0, 0, 0}, kZ, 3.98, 6) +
                               cylinder({0, 0, 6}, kZ, 8, 2)),
          at({60, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("rail_roller", "planar")));
  EXPECT_THAT(i.outcome.err, HasSubstr("joint rail_roller (planar) is doubtful"));
  EXPECT_THAT(i.outcome.err, HasSubstr("hold that motion from both sides"));
}

// A hub with round-ended teeth of a spline in its bore: the lands say cylindrical, the flanks no.
TEST(Contacts, FlanksOfASplineAreNamed) {
  const Folder folder;
  Assembly a("spline");
  TopoDS_Shape shaft = cylinder({0, 0, -20}, kZ, 10, 80),
               hub = cylinder({0, 0, 0}, kZ, 25, 30) - cylinder({0, 0, 0}, kZ, 10.05, 30);
  for (int k = 0; k < 4; ++k) {  // keys of half a cylinder
    const double angle = 0.5 * std::numbers::pi * k;
    const gp_Pnt at(10 * std::cos(angle), 10 * std::sin(angle), -20);
    shaft = shaft + cylinder(at, kZ, 3, 80);
    hub = hub - cylinder(at, kZ, 3.3, 80);
  }
  a.place(a.part("shaft", shaft), at({0, 0, 0}));
  a.place(a.part("hub", hub), at({0, 0, 0}));
  const Import i = import(folder, a, {"--ground", "shaft"});
  EXPECT_THAT(i.outcome.err, HasSubstr("shaft_hub"));
}

// A wheel over a floor, without a joint between them: the contact that is made ready is taken as it is, and holds it.
TEST(Contacts, ReadyContactsRun) {
  const Folder folder;
  Assembly a("floor");
  a.place(a.part("floor", box({-100, -100, -10}, {100, 100, 0})), at({0, 0, 0}));
  a.place(a.part("ball", sphere({0, 0, 0}, 10)), at({0, 0, 10.5}));
  const Import i = import(folder, a);
  EXPECT_EQ(i.freedom, 6);
  EXPECT_THAT(i.outcome.err, HasSubstr("1 pair of bodies without a joint come near each other"));
  const std::string contacts = read_text(folder / "out/contacts.toml");
  EXPECT_THAT(contacts, HasSubstr("# floor and ball: 0.5 mm apart"));
  std::ofstream(folder / "out/mechanism.toml", std::ios::app) << "\n" << contacts;
  const Outcome ran = run("flexura", {"simulate", folder / "out/mechanism.toml", "-o", folder / "f.h5",
                                      "--no-estimate", "--end-time", "0.2"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  const results::Run r = results::read(folder / "f.h5").runs.at(0);
  const auto& z = flexura::test::body(r, "ball").pose.col(2);
  // It has fallen by the gap of half a millimetre, and no further than its facets (0.2 % of the size) and the law yield.
  EXPECT_GT(z.minCoeff(), 0.0099);
  EXPECT_LT(z.minCoeff(), 0.01005);
}

// Two bodies that hold each other and nothing else: they fall, and it is said.
TEST(Contacts, WhatNoJointLeadsToIsNamed) {
  const Folder folder;
  Assembly a("adrift");
  a.place(a.part("base", box({-100, -100, -20}, {100, 100, -10})), at({0, 0, 0}));
  a.place(a.part("plate", box({-30, -30, 0}, {30, 30, 10}) - cylinder({0, 0, 0}, kZ, 5, 10)), at({0, 0, 50}));
  a.place(a.part("rod", cylinder({0, 0, -20}, kZ, 5, 50)), at({0, 0, 50}));
  const Import i = import(folder, a);
  EXPECT_EQ(i.freedom, 8);
  EXPECT_THAT(
      i.outcome.err,
      HasSubstr("plate, with 1 more body joined to it, touches nothing within 0.2 mm and floats free"));
}

}  // namespace
}  // namespace flexura::test
