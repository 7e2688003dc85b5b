// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Assemblies drawn here, whose joints and degrees of freedom are known, imported as a user does it.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <regex>

#include "mbs/superelement/file.hpp"
#include "tests/import/assembly_run.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using namespace drawing;
using testing::HasSubstr;
using testing::Not;
using testing::Pair;
using testing::UnorderedElementsAre;

const gp_Dir kX(1, 0, 0), kY(0, 1, 0), kZ(0, 0, 1);

TopoDS_Shape plate(double hole) {
  return box({-30, -30, 0}, {30, 30, 10}) - cylinder({0, 0, 0}, kZ, hole, 10);
}

// Runs in that plate, between its shoulders.
TopoDS_Shape spool() {
  return cylinder({0, 0, -5}, kZ, 8, 5) + cylinder({0, 0, 0}, kZ, 5, 10) + cylinder({0, 0, 10}, kZ, 8, 5);
}

TEST(AssemblyImport, ShaftWithShouldersOnBothSidesIsAHinge) {
  const Folder folder;
  Assembly a("hinge");
  a.place(a.part("plate", plate(5.0)), at({0, 0, 0}));
  a.place(a.part("spool", spool()), at({0, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_EQ(i.outcome.exit_code, 0) << i.outcome.err;
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("plate_spool", "revolute")));
  EXPECT_EQ(i.freedom, 1);
  EXPECT_THAT(i.mechanism, HasSubstr("# confidence high\n# "));
}

TEST(AssemblyImport, WithoutShouldersItSlidesTooWithOneItMightLiftOff) {
  const Folder folder, second;
  Assembly a("bush");
  a.place(a.part("plate", plate(5.05)), at({0, 0, 0}));
  a.place(a.part("rod", cylinder({0, 0, -20}, kZ, 5, 50)), at({0, 0, 0}));
  Import i = import(folder, a);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("plate_rod", "cylindrical")));
  EXPECT_EQ(i.freedom, 2);
  Assembly b("one shoulder");
  b.place(b.part("plate", plate(5.0)), at({0, 0, 0}));
  b.place(b.part("rod", cylinder({0, 0, -20}, kZ, 5, 30) + cylinder({0, 0, 10}, kZ, 8, 5)), at({0, 0, 0}));
  i = import(second, b);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("plate_rod", "revolute")));
  EXPECT_THAT(i.mechanism, HasSubstr("confidence medium: held from one side only"));
}

// The screw runs in both ends of the base, between its shoulders, and in the carriage, which sits longest on it: were it fixed there,
// nothing could slide.
TEST(AssemblyImport, AShaftHeldBetweenShouldersStaysThereAndItsThreadIsDoubtful) {
  const Folder folder;
  Assembly a("slide");
  const auto end = [](double x) { return box({x, -60, -30}, {x + 20, 60, 30}); };
  TopoDS_Shape base = box({0, -60, -45}, {300, 60, -30}) + end(0) + end(280);
  TopoDS_Shape carriage = box({100, -55, -20}, {160, 55, 20}) - cylinder({100, 0, 0}, kX, 9, 60);
  for (const double y : {-40.0, 40.0}) {
    base = base - cylinder({0, y, 0}, kX, 8, 20) - cylinder({280, y, 0}, kX, 8, 20);
    carriage = carriage - cylinder({100, y, 0}, kX, 8.02, 60);
  }
  base = base - cylinder({0, 0, 0}, kX, 7, 20) - cylinder({280, 0, 0}, kX, 7, 20);
  a.place(a.part("base", base), at({0, 0, 0}));
  const auto rail = a.part("rail", cylinder({0, 0, 0}, kX, 8, 300));
  a.place(rail, at({0, -40, 0}));
  a.place(rail, at({0, 40, 0}));
  a.place(a.part("carriage", carriage), at({0, 0, 0}));
  a.place(a.part("Tr18x4", cylinder({0, 0, 0}, kX, 7, 300) + cylinder({20, 0, 0}, kX, 9, 260) +
                               cylinder({-5, 0, 0}, kX, 12, 5)),
          at({0, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_EQ(i.freedom, 1);
  int slides = 0;
  for (const auto& [name, type] : i.joints) slides += type == "prismatic" ? 1 : 0;
  EXPECT_EQ(slides, 1);
  EXPECT_THAT(
      i.outcome.err,
      HasSubstr(
          "a thread by the name of Tr18x4, right-hand and of lead 4 mm; without a thread it is cylindrical"));
  EXPECT_EQ(i.joints.at("carriage_Tr18x4"), "screw");
}

// A housing with a bar in it leans on the body by one plane and nothing else: without that joint both would fall.
TEST(AssemblyImport, WhatHasJointsOfItsOwnIsBoundByItsOnlyContact) {
  const Folder folder;
  Assembly a("island");
  a.place(a.part("body", box({-50, -50, 0}, {50, 50, 60})), at({0, 0, 0}));
  a.place(a.part("housing", box({-30, -20, -60}, {30, 0, 0}) - box({-8, -14, -60}, {8, -6, 0})),
          at({0, 0, 0}));
  a.place(a.part("bar", box({-8, -14, -90}, {8, -6, -10})), at({0, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_THAT(i.joints,
              UnorderedElementsAre(Pair("body_housing", "planar"), Pair("housing_bar", "prismatic")));
  EXPECT_EQ(i.freedom, 4);
  EXPECT_THAT(i.outcome.err, HasSubstr("joint body_housing (planar) is doubtful"));
}

TEST(AssemblyImport, ClearanceDecidesWhatTouches) {
  const Folder folder, wide;
  Assembly a("loose");
  a.place(a.part("plate", plate(5.4)), at({0, 0, 0}));
  a.place(a.part("rod", cylinder({0, 0, -20}, kZ, 5, 50)), at({0, 0, 0}));
  Import i = import(folder, a);
  EXPECT_TRUE(i.joints.empty());
  EXPECT_THAT(i.outcome.err, HasSubstr("rod touches nothing within 0.2 mm and floats free"));
  EXPECT_EQ(i.freedom, 6);
  i = import(wide, (folder / "a.step").string(), {"--clearance", "0.5 mm"});
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("plate_rod", "cylindrical")));
}

TEST(AssemblyImport, BallInASocketBarInAHole) {
  const Folder folder, second;
  Assembly a("ball");
  a.place(a.part("socket", box({-20, -20, -20}, {20, 20, 5}) - sphere({0, 0, 0}, 12)), at({0, 0, 0}));
  a.place(a.part("stud", sphere({0, 0, 0}, 12) + cylinder({0, 0, 8}, kZ, 4, 30)), turned({0, 0, 0}, kX, 0.3));
  Import i = import(folder, a);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("socket_stud", "spherical")));
  EXPECT_EQ(i.freedom, 3);
  Assembly b("slide");
  b.place(b.part("guide", box({-20, -20, 0}, {20, 20, 30}) - box({-6, -4, 0}, {6, 4, 30})),
          turned({5, 6, 7}, kY, 0.4));
  b.place(b.part("bar", box({-6, -4, -20}, {6, 4, 60})), turned({5, 6, 7}, kY, 0.4));
  i = import(second, b, {"--ground", "guide"});
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("guide_bar", "prismatic")));
  EXPECT_EQ(i.freedom, 1);
}

// Wheels that roll on one another have no faces that make a joint: the two freedoms may be one, and it is said.
TEST(AssemblyImport, WheelsThatTouchAreDoubtful) {
  const Folder folder;
  Assembly a("wheels");
  a.place(a.part("frame", box({-30, -30, 0}, {70, 30, 10}) - cylinder({0, 0, 0}, kZ, 5, 10) -
                              cylinder({40, 0, 0}, kZ, 5, 10)),
          at({0, 0, 0}));
  const auto wheel = [](double radius) {
    return cylinder({0, 0, -8}, kZ, 8, 8) + cylinder({0, 0, 0}, kZ, 5, 10) +
           cylinder({0, 0, 10}, kZ, radius, 8);
  };
  a.place(a.part("small", wheel(15)), at({0, 0, 0}));
  a.place(a.part("large", wheel(25)), at({40, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_THAT(i.joints,
              UnorderedElementsAre(Pair("frame_small", "revolute"), Pair("frame_large", "revolute")));
  EXPECT_EQ(i.freedom, 2);
  EXPECT_THAT(i.outcome.err, HasSubstr("small and large come within"));
}

TEST(AssemblyImport, BoltedPlatesAreFixedWithTheirBolts) {
  const Folder folder;
  Assembly a("bolted");
  const auto holes = [](const TopoDS_Shape& shape, double z, double length, double radius) {
    return shape - cylinder({-20, 0, z}, kZ, radius, length) - cylinder({20, 0, z}, kZ, radius, length);
  };
  a.place(a.part("lower", holes(box({-30, -10, -20}, {30, 10, 0}), -15, 15, 2.5)), at({0, 0, 0}));
  a.place(a.part("upper", holes(box({-30, -10, 0}, {30, 10, 8}), 0, 8, 2.5)), at({0, 0, 0}));
  const TDF_Label bolt = a.part("bolt", cylinder({0, 0, -20}, kZ, 2.5, 20) + cylinder({0, 0, 0}, kZ, 4.5, 3));
  a.place(bolt, at({-20, 0, 8}));
  a.place(bolt, at({20, 0, 8}));
  const Import i = import(folder, a);
  EXPECT_EQ(i.joints.size(), 3U);
  for (const auto& [name, type] : i.joints) EXPECT_EQ(type, "fixed") << name;
  EXPECT_EQ(i.freedom, 0);
  EXPECT_TRUE(fs::exists(folder / "out/parts/bolt.se.h5"));
  EXPECT_FALSE(fs::exists(folder / "out/parts/bolt_2.se.h5"));  // one part, two bodies
  EXPECT_THAT(i.mechanism, HasSubstr("[body.bolt_2]"));
}

// Half a bearing in the frame and half in a cap, which is bolted to it: only together they hold the shaft.
TEST(AssemblyImport, SplitBearingHoldsItsShaft) {
  const Folder folder;
  Assembly a("split");
  const TopoDS_Shape bore = cylinder({0, -20, 0}, kY, 10.02, 40);
  const auto drilled = [](TopoDS_Shape shape, double low, double high) {
    for (const double x : {-20.0, 20.0}) shape = shape - cylinder({x, 0, low}, kZ, 3, high - low);
    return shape;
  };
  a.place(a.part("frame", drilled(box({-30, -20, -40}, {30, 20, 0}) - bore, -25, 0)), at({0, 0, 0}));
  a.place(a.part("cap", drilled(box({-30, -20, 0}, {30, 20, 20}) - bore, 0, 20)), at({0, 0, 0}));
  a.place(a.part("shaft", cylinder({0, -60, 0}, kY, 10, 120)), at({0, 0, 0}));
  const Import i = import(folder, a);
  EXPECT_THAT(i.joints, UnorderedElementsAre(Pair("frame_cap", "fixed"), Pair("frame_shaft", "cylindrical")));
  EXPECT_EQ(i.freedom, 2);
  // Neither half alone would be sure of it.
  EXPECT_THAT(i.mechanism, HasSubstr("# confidence high\n# shaft 10 mm of shaft"));
  EXPECT_THAT(i.mechanism, Not(HasSubstr("confidence medium")));
}

// A cross between two forks: the fork on the ground, the cross and the other fork turn one on another.
TEST(AssemblyImport, UniversalJointHasTwoFreedoms) {
  const Folder folder;
  Assembly a("cardan");
  // Ears at x = +-(20 .. 28) with bores along x; the cross's arms end in them, its hub's shoulders touch the ears.
  const TopoDS_Shape fork = box({-28, -10, 30}, {28, 10, 38}) + box({-28, -10, -10}, {-20, 10, 30}) +
                            box({20, -10, -10}, {28, 10, 30});
  const TopoDS_Shape drilled = fork - cylinder({-30, 0, 0}, kX, 5, 60);
  const TopoDS_Shape cross = box({-20, -8, -8}, {20, 8, 8}) + box({-8, -20, -8}, {8, 20, 8}) +
                             cylinder({-28, 0, 0}, kX, 5, 56) + cylinder({0, -28, 0}, kY, 5, 56);
  a.place(a.part("cross", cross), at({0, 0, 0}));
  const TDF_Label part = a.part("fork", drilled);
  a.place(part, at({0, 0, 0}), "lower");
  // Upside down and a quarter turned: its bores along y.
  a.place(part, turned({0, 0, 0}, gp_Dir(1, 1, 0), std::numbers::pi), "upper");
  const Import i = import(folder, a, {"--ground", "lower"});
  EXPECT_THAT(i.joints,
              UnorderedElementsAre(Pair("cross_lower", "revolute"), Pair("cross_upper", "revolute")));
  EXPECT_EQ(i.freedom, 2);
}

// Four bars with pins: a body of revolution that runs in two bars is fixed to one, the loop has one freedom and the
// three rows too many of every plane loop of hinges.
TEST(AssemblyImport, FourBarLinkageOfPlatesAndPinsHasOneFreedom) {
  const Folder folder;
  Assembly a("four bar");
  // Bars along x with a bore at either end, in two layers; ends spread so that it is no parallelogram.
  const auto bar = [](double length, double z) {
    return box({-8, -6, z}, {length + 8, 6, z + 5}) - cylinder({0, 0, z}, kZ, 3, 5) -
           cylinder({length, 0, z}, kZ, 3, 5);
  };
  const gp_Pnt A(0, 0, 0), D(80, 0, 0), B(20, 30, 0);
  // C: 70 from B, 50 from D.
  const double d = B.Distance(D), along = (70.0 * 70.0 - 50.0 * 50.0 + d * d) / (2.0 * d),
               off = std::sqrt(70.0 * 70.0 - along * along);
  const double ux = (D.X() - B.X()) / d, uy = (D.Y() - B.Y()) / d;
  const gp_Pnt C(B.X() + along * ux - off * uy, B.Y() + along * uy + off * ux, 0);
  const auto place = [&](const char* name, const gp_Pnt& from, const gp_Pnt& to, double z) {
    a.place(a.part(name, bar(from.Distance(to), z)),
            turned(from, kZ, std::atan2(to.Y() - from.Y(), to.X() - from.X())));
  };
  place("frame", A, D, 0);
  place("crank", A, B, 5);
  place("coupler", B, C, 0);
  place("rocker", D, C, 5);
  const TDF_Label pin = a.part("pin", cylinder({0, 0, -3}, kZ, 6, 3) + cylinder({0, 0, 0}, kZ, 3, 10) +
                                          cylinder({0, 0, 10}, kZ, 6, 3));
  for (const gp_Pnt& p : {A, B, C, D}) a.place(pin, at(p));
  const Import i = import(folder, a, {"--ground", "frame"});
  EXPECT_EQ(i.outcome.exit_code, 0) << i.outcome.err;
  int hinges = 0, fixed = 0;
  for (const auto& [name, type] : i.joints) {
    hinges += type == "revolute" ? 1 : 0;
    fixed += type == "fixed" ? 1 : 0;
  }
  EXPECT_EQ(hinges, 4);
  EXPECT_EQ(fixed, 4);
  EXPECT_EQ(i.joints.size(), 8U);
  EXPECT_EQ(i.freedom, 1);
  // The solver says the same.
  const Outcome check = run("flexura", {"check", folder / "out/mechanism.toml"});
  EXPECT_THAT(check.out, testing::ContainsRegex("redundant constraints +3"));
}

// 20 x 30 x 40 mm less a bore of 5 mm radius: mass, centre and inertia by formulas; in the file's inches and with
// its density.
TEST(AssemblyImport, MassPropertiesAreThoseOfTheExactShape) {
  const Folder folder;
  Assembly a("drilled");
  a.place(a.part("block", box({0, 0, 0}, {20, 30, 40}) - cylinder({10, 12, 0}, kZ, 5, 40), 2700.0, "#FF8000"),
          at({100, 0, 0}));
  a.write(folder / "inch.step", "INCH");
  const Import i = import(folder, (folder / "inch.step").string());
  ASSERT_EQ(i.outcome.exit_code, 0) << i.outcome.err;
  EXPECT_THAT(i.outcome.err, Not(HasSubstr("no density")));
  EXPECT_THAT(i.mechanism, HasSubstr("colour #FF"));
  EXPECT_THAT(i.mechanism, HasSubstr("position = [0.1"));
  const auto se = superelement::read(folder / "out/parts/block.se.h5");
  const double rho = 2700.0, mb = rho * 0.02 * 0.03 * 0.04, mc = rho * std::numbers::pi * 25e-6 * 0.04,
               m = mb - mc;
  // The faces are exact; what is lost is the file's 15 digits in inches and the integration.
  EXPECT_NEAR(se.inertia.mass, m, 1e-8 * m);
  const double y = (mb * 0.015 - mc * 0.012) / m;
  EXPECT_NEAR(se.inertia.S_x.y() / m, y, 1e-9);
  EXPECT_NEAR(se.inertia.S_x.x() / m, 0.01, 1e-9);
  const double xx = mb * 0.02 * 0.02 / 3.0 - mc * (0.25 * 25e-6 + 0.01 * 0.01);
  EXPECT_NEAR(se.inertia.S_xx(0, 0), xx, 1e-8 * xx);
  const double xy = mb * 0.01 * 0.015 - mc * 0.01 * 0.012;
  EXPECT_NEAR(se.inertia.S_xx(0, 1), xy, 1e-8 * xy);
}

// The text of a STEP file with the part whose shapes end at its n-th length unit written in centimetres: points and radii.
std::string with_centimetres(const std::string& step, int n) {
  static const std::regex entity(R"(#\d+ = [^;]*;)"), unit(R"(LENGTH_UNIT[^;]*\.MILLI\.)"),
      point(R"((CARTESIAN_POINT\('[^']*',\()([^,)]*),([^,)]*),([^,)]*)\))"),
      radius(R"(((?:CYLINDRICAL_SURFACE|CIRCLE)\('[^']*',#\d+,)([^)]*)\))");
  const auto tenth = [](const std::string& number) {
    return fmt::format("{:#.17G}", std::stod(number) / 10);
  };
  std::string out;
  int units = 0;
  auto from = step.begin();
  for (std::sregex_iterator at(step.begin(), step.end(), entity), end; at != end; ++at) {
    out.append(from, (*at)[0].first);
    from = (*at)[0].second;
    std::string text = at->str();
    std::smatch m;
    const bool in_part = units == n;
    if (std::regex_search(text, unit)) {
      if (in_part) text = std::regex_replace(text, std::regex("MILLI"), "CENTI");
      ++units;
    } else if (in_part && std::regex_search(text, m, point)) {
      text = m.prefix().str() + m[1].str() + tenth(m[2]) + "," + tenth(m[3]) + "," + tenth(m[4]) + ")" +
             m.suffix().str();
    } else if (in_part && std::regex_search(text, m, radius)) {
      text = m.prefix().str() + m[1].str() + tenth(m[2]) + ")" + m.suffix().str();
    }
    out += text;
  }
  return out.append(from, step.end());
}

TEST(AssemblyImport, EachPartMayHaveUnitsOfItsOwn) {
  const Folder folder, second;
  Assembly a("units");
  a.place(a.part("plate", plate(5.0)), at({0, 0, 0}));
  a.place(a.part("spool", spool()), at({0, 0, 0}));
  const Import plain = import(folder, a);
  // Length units: of the assembly, of the plate, of the spool.
  const auto mixed_file = second.write("mixed.step", with_centimetres(read_text(folder / "a.step"), 2));
  ASSERT_THAT(read_text(mixed_file), HasSubstr(".CENTI.,.METRE."));
  const Import mixed = import(second, mixed_file.string());
  ASSERT_EQ(mixed.outcome.exit_code, 0) << mixed.outcome.err;
  EXPECT_EQ(mixed.joints, plain.joints);
  const double m = superelement::read(folder / "out/parts/spool.se.h5").inertia.mass;
  EXPECT_NEAR(superelement::read(second / "out/parts/spool.se.h5").inertia.mass, m, 1e-9 * m);
}

TEST(AssemblyImport, SubassembliesPlaceWhatTheyHold) {
  const Folder folder;
  Assembly a("nest");
  const TDF_Label inner = a.group("inner"), outer = a.group("outer"),
                  cube = a.part("cube", box({-1, -1, -1}, {1, 1, 1}));
  a.place(inner, cube, at({10, 0, 0}));
  a.place(outer, inner, turned({0, 20, 0}, kZ, std::numbers::pi / 2));
  a.place(outer, at({0, 0, 30}));
  a.place(a.part("base", box({-50, -50, -60}, {50, 50, -50})), at({0, 0, 0}));
  const Import i = import(folder, a);
  // (10, 0, 0) turned by 90 degrees: (0, 10, 0); then (0, 20, 0) and (0, 0, 30).
  EXPECT_THAT(i.mechanism, HasSubstr("of nest / outer / inner"));
  const results::Run r = results::read(folder / "out.h5").runs.at(0);
  EXPECT_NEAR(body(r, "cube").pose(0, 0), 0.0, 1e-12);
  EXPECT_NEAR(body(r, "cube").pose(0, 1), 0.03, 1e-12);
  EXPECT_NEAR(body(r, "cube").pose(0, 2), 0.03, 1e-12);
}

TEST(AssemblyImport, JointsNoneLeavesTheBodiesFree) {
  const Folder folder;
  Assembly a("two");
  a.place(a.part("plate", plate(5.0)), at({0, 0, 0}));
  a.place(a.part("rod", cylinder({0, 0, -20}, kZ, 5, 50)), at({0, 0, 0}));
  const Import i = import(folder, a, {"--joints", "none", "--ground", "rod"});
  EXPECT_TRUE(i.joints.empty());
  EXPECT_THAT(i.mechanism, HasSubstr("to = \"rod.ground\""));
}

// The engine of cases/assembly: block, crank, rod, piston in a closed loop, and what is bolted to them.
class Engine : public testing::Test {};

TEST_F(Engine, IsASliderCrankWithOneFreedom) {
  const Folder folder;
  const Import i = import(folder, FLEXURA_SOURCE_DIR "/cases/assembly/engine.step");
  ASSERT_EQ(i.outcome.exit_code, 0) << i.outcome.err;
  std::map<std::string, std::string> moving;
  for (const auto& [name, type] : i.joints)
    if (type != "fixed") moving[name] = type;
  EXPECT_THAT(moving, UnorderedElementsAre(Pair("block_crankshaft", "revolute"),
                                           Pair("crankshaft_connecting_rod", "revolute"),
                                           Pair("connecting_rod_piston_pin", "cylindrical"),
                                           Pair("block_piston", "cylindrical")));
  EXPECT_EQ(i.joints.size() - moving.size(), 13U);
  EXPECT_EQ(i.freedom, 1);
  // Driven, its piston moves by r cos a + sqrt(l^2 - r^2 sin^2 a); the crank stands at 60 degrees.
  const Outcome driven = run(
      "flexura", {"simulate", folder / "out/mechanism.toml", "-o", folder / "e.h5", "--no-estimate", "--set",
                  "solver.method=kinematics", "solver.output_step=0.02", "joint.block_crankshaft.drive=6*t"});
  ASSERT_EQ(driven.exit_code, 0) << driven.err;
  const results::Run r = results::read(folder / "e.h5").runs.at(0);
  const auto& piston = body(r, "piston").pose;
  const auto& crank = body(r, "crankshaft").pose;
  const double radius = 0.025, length = 0.1;
  double least = 1.0, most = 0.0;
  for (Eigen::Index row = 0; row < r.time.size(); ++row) {
    const Eigen::Quaterniond q(crank(row, 3), crank(row, 4), crank(row, 5), crank(row, 6));
    const Eigen::Vector3d pin = q * Eigen::Vector3d(0, 0, radius);
    // STEP keeps placements to some 1e-9 m.
    EXPECT_NEAR(piston(row, 2), pin.z() + std::sqrt(length * length - pin.x() * pin.x()), 1e-8);
    least = std::min(least, piston(row, 2));
    most = std::max(most, piston(row, 2));
  }
  EXPECT_NEAR(most - least, 2 * radius, 1e-3);  // nearly a turn, in steps of 7 degrees
}

}  // namespace
}  // namespace flexura::test
