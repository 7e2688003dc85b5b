// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/planar_links.hpp"

/// Constraints that conflict, are redundant or lose rank: what contradicts is refused by the names of its rows
/// (2: by the file alone, before the first step; 1: where the motion gets there, rows kept), what is redundant and
/// fits runs. constraints/ holds the family, rigid/ and safe/overcon/ the files by which it was found.
namespace flexura {
namespace {

using mbs::test::hinge;
using mbs::test::PlanarLink;
using test::Outcome;
using test::run;
using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kFound = FLEXURA_SOURCE_DIR "/tests/found/";

Outcome simulate(const std::string& file, const test::Folder& folder, const std::string& method = "ida") {
  return run("flexura", {"simulate", kFound + file + ".toml", "-o", folder / "rows.h5", "--no-estimate",
                         "--set", "solver.method=" + method});
}

struct Refused {
  std::string file;
  std::vector<std::string> names;  // that the message must hold
};

class RefusedBeforeTheFirstStep : public ::testing::TestWithParam<Refused> {};
TEST_P(RefusedBeforeTheFirstStep, NamesTheRows) {
  const test::Folder folder;
  const Outcome outcome = simulate(GetParam().file, folder);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err << outcome.out;
  for (const std::string& name : GetParam().names) EXPECT_THAT(outcome.err, HasSubstr(name));
  EXPECT_FALSE(std::filesystem::exists(folder / "rows.h5"));
}
// Where a row is open by a rate at t = 0 the number in the message follows from the drives by hand.
INSTANTIATE_TEST_SUITE_P(
    Constraints, RefusedBeforeTheFirstStep,
    ::testing::Values(
        Refused{"rigid/gear_two_drives",
                {"\"g.ratio\"", "\"a.drive\"", "\"b.drive\"", "contradict", "1 rad/s"}},
        Refused{"rigid/two_drives_conflict", {"\"c.drive\"", "\"a.drive\"", "contradict", "1 rad/s"}},
        Refused{"rigid/two_motors_one_dof", {"\"A.drive\"", "\"D.drive\"", "\"C.", "contradict"}},
        Refused{"rigid/misaligned_rigid_fourbar", {"\"A.drive\"", "\"C.axis_", "contradict"}},
        Refused{"constraints/coupler_offset_conflict", {"\"c.ratio\"", "0.1 rad/s"}},
        Refused{"constraints/gear_acceleration_conflict", {"\"g.ratio\"", "2 rad/s^2"}},
        Refused{"constraints/gear_speed_drive_conflict", {"\"g.ratio\"", "1 rad/s"}},
        Refused{"constraints/gear_ring3_driven", {"\"j0.drive\"", "contradict"}},
        Refused{"constraints/gear_ring4_wrong_ratio", {"\"j0.drive\"", "contradict"}},
        Refused{"constraints/screw_conflict", {"\"s.", "contradict"}},
        Refused{"constraints/screw_in_slider", {"\"s.", "\"p.drive\"", "contradict"}},
        Refused{"constraints/cam_follower_driven", {"\"c.", "\"cam.drive\"", "\"fol.drive\"", "contradict"}},
        Refused{"constraints/distance_stretched_speed", {"\"d.length\""}},
        Refused{"constraints/distance_locks_driven", {"\"u.length\"", "\"j.drive\"", "contradict"}},
        Refused{"constraints/distance_two_lengths", {"\"d1\" (", "\"d2\" (", " mm"}},
        Refused{"constraints/parallelogram_flat_driven", {"dead point", "ambiguous", "speed"}},
        // Three cranks of 0.3 m: rows left out contradict nothing there. Turned to one line from beside it, they stand there to
        // the square root of what the loops are open by. The coupler turns at -6 rad/s where the second crank takes its
        // antiparallel branch, (2 - 6 0.5 / 0.3)^2 0.3 = 2^2 0.3 + 6^2 0.5, and the third cannot follow:
        // 0.3 18^2 - 0.3 2^2 - 6^2 1 = 60 m/s^2.
        Refused{"constraints/cranks3_flat_driven",
                {"dead point", "ambiguous", "\"g1.speed\"", "\"g2.speed\""}},
        Refused{"constraints/cranks3_flat_driven_guess", {"dead point", "ambiguous", "exact positions"}},
        Refused{"constraints/fourbar_flat_driven_guess", {"dead point", "ambiguous", "exact positions"}},
        Refused{"constraints/cranks3_flat_one_antiparallel",
                {"dead point", "speeds given", "\"k2.x\"", "60 m/s^2"}},
        Refused{"constraints/slider_driven_dead_point", {"dead point", "ambiguous", "speed", "\"A.speed\""}},
        Refused{"constraints/misaligned_slow_start", {"\"A.drive\"", "\"C.axis_", "rad/s^2"}},
        Refused{"constraints/misaligned_1e-4", {"\"A.drive\"", "\"C.axis_", "contradict"}},
        Refused{"constraints/two_sliders_skew_axis", {"\"r.rotation_y\" (", "cannot be met"}},
        Refused{"constraints/door_offset_1mm", {"\"h2.x\" (-0.001 m)"}},
        Refused{"constraints/bennett_off", {"\"j1\" ("}},
        Refused{"constraints/distance_to_itself",
                {"\"d2.length\" (-1 m)", "cannot be met", "nothing can move"}},
        Refused{"constraints/weld_and_free", {"\"c.length\"", "cannot be met", "nothing can move"}}));

struct Stopped {
  std::string file, method;
  std::vector<std::string> names;
  double since;  // of the contradiction [s]
};

class StoppedOnTheWay : public ::testing::TestWithParam<Stopped> {};
TEST_P(StoppedOnTheWay, NamesRowsAndTimeAndKeepsTheRowsBefore) {
  const test::Folder folder;
  const Outcome outcome = simulate(GetParam().file, folder, GetParam().method);
  EXPECT_EQ(outcome.exit_code, 1) << outcome.err << outcome.out;
  for (const std::string& name : GetParam().names) EXPECT_THAT(outcome.err, HasSubstr(name));
  const results::Results results = results::read(folder / "rows.h5");
  ASSERT_FALSE(results.runs.empty());
  EXPECT_FALSE(results.runs[0].complete);
  const Eigen::VectorXd& t = results.runs[0].time;
  ASSERT_GT(t.size(), 0);
  EXPECT_LE(t(t.size() - 1), GetParam().since + 1e-3);
  EXPECT_GE(t(t.size() - 1), GetParam().since - 0.02);  // a row every hundredth of the run at least
}
// sin t leaves t by t^3 / 6, which the rows are to be told from by their rates, t^2 / 2 = 1e-5. The step functions
// begin at 0.5 and 0.4 s. The slider is drawn out of the crank's reach, 0.1 + 0.3 m, at (0.4 - 0.338) / 0.1 s; the
// rocker (0.6 m) is held by crank and coupler folded on each other, 0.9 - 0.3 m to a pivot 0.8 m away, at the angle
// whose cosine is (0.8^2 + 0.6^2 - 0.6^2) / (2 0.8 0.6), its supplement being 1.9 + 0.5 t.
INSTANTIATE_TEST_SUITE_P(
    Constraints, StoppedOnTheWay,
    ::testing::Values(
        Stopped{"constraints/coupler_jerk_conflict", "ida", {"\"c.ratio\"", "contradict"}, 0.00447},
        Stopped{"constraints/gear_later_conflict", "ida", {"\"g.ratio\"", "from t = 0.5 s on"}, 0.5},
        Stopped{"constraints/gear_later_conflict", "radau", {"\"g.ratio\"", "contradict"}, 0.5},
        Stopped{"constraints/gear_later_conflict", "generalised_alpha", {"\"g.ratio\"", "contradict"}, 0.5},
        Stopped{"constraints/gear_later_conflict", "runge_kutta", {"\"g.ratio\"", "contradict"}, 0.5},
        Stopped{"constraints/misaligned_late", "ida", {"\"C.axis_", "\"A.drive\"", "contradict"}, 0.4},
        Stopped{"constraints/misaligned_late", "radau", {"\"C.axis_", "\"A.drive\"", "contradict"}, 0.4},
        Stopped{"constraints/misaligned_late", "generalised_alpha", {"\"C.axis_", "contradict"}, 0.4},
        Stopped{"constraints/misaligned_late", "runge_kutta", {"\"C.axis_", "contradict"}, 0.4},
        Stopped{"constraints/slider_driven_out_of_reach", "ida", {"\"S.drive\"", "locks"}, 0.62},
        Stopped{"constraints/slider_driven_out_of_reach", "radau", {"\"S.drive\"", "locks"}, 0.62},
        Stopped{"constraints/fourbar_rocker_driven_too_far",
                "ida",
                {"\"D.drive\"", "locks"},
                2.0 * (std::numbers::pi - std::acos(0.64 / 0.96) - 1.9)}));

struct Fits {
  std::string file, says;
  int redundant;
};

class Runs : public ::testing::TestWithParam<Fits> {};
TEST_P(Runs, WithItsRedundantRowsReported) {
  const test::Folder folder;
  const Outcome outcome = simulate(GetParam().file, folder);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().says));
  EXPECT_THAT(outcome.err, Not(HasSubstr("do not fit")));
  const results::Results results = results::read(folder / "rows.h5");
  const nlohmann::json summary = nlohmann::json::parse(results.runs.at(0).summary_json);
  EXPECT_EQ(summary.at("redundant_constraints"), GetParam().redundant);
  // Rows that are left out are among them: closed to the round-off of lengths of a metre and what 1e-9 of
  // misalignment opens.
  EXPECT_LT(summary.at("peak_position_drift").get<double>(), 1e-9);
}
INSTANTIATE_TEST_SUITE_P(
    Constraints, Runs,
    ::testing::Values(
        Fits{"rigid/door_two_hinges_rounding", "redundant", 5},
        Fits{"rigid/door_two_hinges_skew", "redundant", 5},
        Fits{"rigid/cam_false_misfit_n96", "redundant", 1},
        Fits{"constraints/coupler_compatible", "\"c.ratio\"", 1},
        Fits{"constraints/gear_compatible", "\"g.ratio\"", 1}, Fits{"constraints/gear_ring4", "redundant", 1},
        Fits{"constraints/screw_compatible", "redundant", 5}, Fits{"constraints/cam_nearly", "redundant", 1},
        Fits{"constraints/distance_twice", "redundant", 1},
        Fits{"constraints/parallelogram_flat_speeds", "redundant", 3},
        Fits{"constraints/cranks3_flat_speeds", "redundant", 7},
        Fits{"constraints/parallelogram_flat_rest", "give speeds for \"A.speed\"", 3},
        Fits{"constraints/parallelogram_through", "redundant", 3},
        Fits{"constraints/parallelogram_through_driven", "redundant", 3},
        Fits{"constraints/fourbar_oblique", "redundant", 3}, Fits{"constraints/fourbar_far", "redundant", 3},
        Fits{"constraints/fourbar_two_motors_agree", "redundant", 4},
        Fits{"constraints/two_drives_agree", "\"c.drive\"", 6},
        Fits{"constraints/two_sliders_driven_alike", "\"c.drive\"", 6},
        Fits{"constraints/misaligned_1e-9", "redundant", 3},
        Fits{"constraints/two_sliders_rounding", "redundant", 5},
        Fits{"constraints/revolute_cylindrical", "redundant", 4},
        Fits{"constraints/revolute_and_connection", "redundant", 3},
        Fits{"constraints/sarrus", "redundant", 1}, Fits{"constraints/bennett", "redundant", 3},
        Fits{"constraints/bennett_falls", "redundant", 3},
        Fits{"constraints/cardan_straight", "redundant", 1}));

// Bar and crank of a Scott-Russell linkage meet in one line twice a turn: a row that vanishes there was kept, and the one that
// holds was left out and said to contradict it, at the fifth passage (0.322 s) or the first.
TEST(Constraints, AScottRussellLinkageGoesThroughItsDeadPoints) {
  for (const std::string method : {"ida", "radau", "generalised_alpha", "runge_kutta"})
    for (const std::string tolerance : {"1e-4", "1e-6", "1e-9"}) {
      const test::Folder folder;
      const Outcome outcome =
          test::run("flexura", {"simulate", "-q", kFound + "constraints/scott_russell.toml", "-o",
                                folder / "rows.h5", "--no-estimate", "--set", "solver.end_time=2", "--set",
                                "solver.method=" + method, "--set", "solver.tolerance=" + tolerance});
      ASSERT_EQ(outcome.exit_code, 0) << method << " " << tolerance << outcome.err;
      // The bar's upper end stays on its line: rows of the results are closed to 1e-11 of the mechanism, the run's
      // Newton to its tolerance.
      const results::Run run = results::read(folder / "rows.h5").runs.at(0);
      EXPECT_EQ(run.time(run.time.size() - 1), 2.0);
      for (std::size_t i = 0; i < run.quantities.size(); ++i)
        if (run.quantities[i].name == "x_top")
          EXPECT_LT(run.values.col(static_cast<Eigen::Index>(i)).cwiseAbs().maxCoeff(), 1e-9) << method;
    }
}

// Cranks on one line and their couplers pass it at a tolerance at which no error control comes near to it.
TEST(Constraints, FourBarsInLineGoThroughAtTightTolerances) {
  for (const std::string method : {"radau", "generalised_alpha", "runge_kutta"}) {
    const test::Folder folder;
    const Outcome outcome =
        test::run("flexura", {"simulate", "-q", kFound + "constraints/four_bars_in_line.toml", "-o",
                              folder / "rows.h5", "--no-estimate", "--set", "solver.method=" + method});
    EXPECT_EQ(outcome.exit_code, 0) << method << outcome.err;
  }
}

// Opposite hinges of Bennett's linkage turn alike, and tan(theta_1 / 2) tan(theta_2 / 2) is constant (Bennett 1903), through
// where the rows that were kept at the start depend on each other (1.57 s). Velocities are right to 1e-6 of 5 rad/s a step.
TEST(Constraints, ABennettLinkageGoesThroughWhereTheKeptRowsLoseRank) {
  for (const std::string method : {"ida", "radau", "generalised_alpha"}) {
    const test::Folder folder;
    const Outcome outcome = simulate("constraints/bennett_falls", folder, method);
    ASSERT_EQ(outcome.exit_code, 0) << method << outcome.err;
    const results::Run run = results::read(folder / "rows.h5").runs.at(0);
    const auto angle = [&](const std::string& name, Eigen::Index row) {
      for (std::size_t i = 0; i < run.quantities.size(); ++i)
        if (run.quantities[i].name == name) return run.values(row, static_cast<Eigen::Index>(i));
      throw std::logic_error("no quantity " + name);
    };
    const double alpha = 50 * std::numbers::pi / 180, beta = 2 * alpha;
    const double K = std::sin((beta + alpha) / 2) / std::sin((beta - alpha) / 2);
    ASSERT_EQ(run.time.size(), 21);
    for (Eigen::Index row = 0; row < run.time.size(); ++row) {
      EXPECT_NEAR(std::remainder(angle("j3.angle", row) + angle("j1.angle", row), 2 * std::numbers::pi), 0.0,
                  1e-9);
      EXPECT_NEAR(std::remainder(angle("j4.angle", row) + angle("j2.angle", row), 2 * std::numbers::pi), 0.0,
                  1e-9);
      const double theta_1 = 1.0 + angle("j1.angle", row),
                   theta_2 = 2 * std::atan(K / std::tan(0.5)) + angle("j2.angle", row);
      EXPECT_NEAR(std::remainder(theta_2 - 2 * std::atan(K / std::tan(theta_1 / 2)), 2 * std::numbers::pi),
                  0.0, 1e-8)
          << method << " at " << run.time(row);
    }
  }
}

// Cantilevers of one line meet at a ball: their first modes bend them alone and let the ball move along the line to second
// order only, "1.1e+03 N left" of the load and no deflection, exit code 0. With response modes they are springs side by
// side: k = 1 / (l^3 / (3 E I) + l / (G A_s)), A_s = A 10 (1 + nu) / (12 + 11 nu) (Cowper 1966).
TEST(Constraints, CantileversMeetWithoutModesThatStretchThem) {
  const test::Folder folder;
  double k = 0.0;
  std::string text =
      "gravity = [0, 0, 0]\n[ground.marker.o]\n[ground.marker.b]\nposition = [2, 0, 0]\naxis = [0, 0, 1]\n"
      "x_axis = [-1, 0, 0]\n";
  for (const auto& [name, h] : {std::pair("A", 0.04), std::pair("B", 0.002)}) {
    folder.write(std::string(name) + ".toml",
                 "[material.s]\nyoung = 210e9\npoisson = 0.3\ndensity = 7850\n[section.s]\ntype = "
                 "\"rectangle\"\nwidth = 0.02\n"
                 "height = " +
                     std::to_string(h) +
                     "\n[node.a]\nposition = [0, 0, 0]\n[node.b]\nposition = [1, 0, 0]\n"
                     "[member.m]\nnodes = [\"a\", \"b\"]\nelements = "
                     "6\n[interface.a]\n[interface.b]\n[modes]\ncount = 6\n");
    const std::string file = folder / (std::string(name) + ".toml"),
                      se = folder / (std::string(name) + ".se.h5");
    ASSERT_EQ(run("flexura", {"reduce", file, "-o", se, "--quiet"}).exit_code, 0);
    text += std::string("[body.") + name + "]\nsuperelement = \"" + name + ".se.h5\"\nmodes = 3\n";
    const double I = 0.02 * h * h * h / 12, A = 0.02 * h * 10 * 1.3 / (12 + 11 * 0.3), E = 210e9;
    k += 1 / (1 / (3 * E * I) + 1 / (E / 2.6 * A));
  }
  const double load = 1e-4 * k;
  text +=
      "position = [2, 0, 0]\naxis = [0, 0, 1]\nx_axis = [-1, 0, 0]\n"
      "[joint.a]\ntype = \"fixed\"\nfrom = \"ground.o\"\nto = \"A.a\"\n"
      "[joint.b]\ntype = \"fixed\"\nfrom = \"ground.b\"\nto = \"B.a\"\n"
      "[joint.t]\ntype = \"spherical\"\nfrom = \"A.b\"\nto = \"B.b\"\n"
      "[force.p]\ntype = \"force\"\nmarker = \"A.b\"\nz = " +
      std::to_string(load) +
      "\n"
      "[measure.z]\ntype = \"position\"\nfrom = \"ground.o\"\nto = \"A.b\"\ndirection = [0, 0, 1]\n";
  const auto file = folder.write("m.toml", text);
  const auto place = [](const std::string& out) {
    double z = 0.0;
    const nlohmann::json statics = nlohmann::json::parse(out);
    for (const auto& one : statics["runs"][0]["quantities"])
      if (one["name"] == "z") z = one["value"].get<double>();
    return z;
  };
  // Nothing stretches: the row is left out, and opens by the stretch of 1e-8 m.
  const Outcome few = run("flexura", {"statics", file, "--json"});
  ASSERT_EQ(few.exit_code, 0) << few.err;
  EXPECT_THAT(few.out,
              AllOf(HasSubstr("1 redundant constraint left out: \\\"t.x\\\""), HasSubstr("attachments = ")));
  // The thick one, which all but bears the load, keeps one mode that bends that way: 12 / (beta l)^4 of the compliance, less for shear.
  EXPECT_NEAR(place(few.out), 12.0 / std::pow(1.8751, 4) * load / k, 1e-3 * load / k);
  const Outcome used = run("flexura", {"statics", file, "--json", "--set", "body.A.attachments=used", "--set",
                                       "body.B.attachments=used"});
  ASSERT_EQ(used.exit_code, 0) << used.err;
  const double z = place(used.out);
  // Cubic elements with shear are exact at their nodes; the line stretches by z^2 / l, 1e-8 m, and pulls back with it:
  // E A (z / l)^3 of both in series, 2e-6 of the load.
  EXPECT_NEAR(z, load / k, 1e-5 * load / k);
}

// A four-bar whose driven crank is the joint that closes the loop moves as with the crank in the tree, for more than a
// turn.
TEST(Constraints, AJointThatClosesALoopMayBeDriven) {
  const test::Folder folder;
  const auto rocker = [&](const std::string& cut) {
    const auto file =
        folder.write("m.toml", "gravity = [0, -9.81, 0]\n[ground.marker.d]\nposition = [1, 0, 0]\n" +
                                   text_of(PlanarLink{"crank", 0.2, 1.0, 0.1, 0.01}) +
                                   text_of(PlanarLink{"rod", 1.0, 1.0, 0.5, 0.1}) +
                                   text_of(PlanarLink{"rocker", 0.5, 1.0, 0.25, 0.05}) +
                                   hinge("D", "ground.d", "rocker", "angle = 1.8") +
                                   hinge("C", "rocker.t", "rod.t") + hinge("B", "rod", "crank.t") +
                                   hinge("A", "ground", "crank", "drive = \"1 + 7*t\"\n" + cut) + R"toml(
[output]
quantities = ["D.angle", "A.drive_force"]
[solver]
end_time = 1
tolerance = 1e-9
)toml");
    const Outcome outcome = run("flexura", {"simulate", file, "-o", folder / "rows.h5", "--no-estimate"});
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return results::read(folder / "rows.h5").runs.at(0).values;
  };
  const Eigen::MatrixXd tree = rocker(""), closure = rocker("cut = true\n");
  ASSERT_EQ(tree.rows(), closure.rows());
  // Where the crank is prescribed both are geometry: positions to what loops are closed by, torques to 1e-5.
  EXPECT_LT((tree.col(0) - closure.col(0)).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_LT((tree.col(1) - closure.col(1)).cwiseAbs().maxCoeff(), 1e-5 * tree.col(1).cwiseAbs().maxCoeff());
}

// The cam's drive and its follower are where the curve says, whatever digits the start value has.
TEST(Constraints, AStartValueWithFewDigitsIsNoMisfit) {
  const Outcome outcome = run("flexura", {"assemble", kFound + "rigid/cam_false_misfit_n96.toml", "--json"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out + outcome.err, Not(HasSubstr("do not fit")));
}

struct Immovable {
  std::string file;
  bool fits;
  bool is_driven = false;  // it moves as its drives say: no state about which a linear system would last
};

class NothingCanMove : public ::testing::TestWithParam<Immovable> {};
TEST_P(NothingCanMove, InEveryCommandThatReadsMechanisms) {
  const test::Folder folder;
  for (const std::vector<std::string>& command :
       std::vector<std::vector<std::string>>{{"check"},
                                             {"assemble"},
                                             {"statics"},
                                             {"eigen"},
                                             {"linearize", "-o", folder / "linear.m"},
                                             {"simulate", "-o", folder / "rows.h5"}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.begin() + 1, kFound + GetParam().file + ".toml");
    const Outcome outcome = run("flexura", arguments);
    if (GetParam().is_driven && (command[0] == "eigen" || command[0] == "linearize")) {
      EXPECT_EQ(outcome.exit_code, 2) << command[0];
      EXPECT_THAT(outcome.err, HasSubstr("neither an equilibrium nor a steady motion"));
      continue;
    }
    EXPECT_EQ(outcome.exit_code, GetParam().fits ? 0 : 2) << command[0] << ": " << outcome.err;
    if (!GetParam().fits)
      EXPECT_THAT(outcome.err, AllOf(HasSubstr("cannot be met"), HasSubstr("nothing can move")))
          << command[0];
  }
}
INSTANTIATE_TEST_SUITE_P(
    Constraints, NothingCanMove,
    ::testing::Values(Immovable{"safe/overcon/a", true}, Immovable{"safe/overcon/b", true},
                      Immovable{"safe/overcon/fixedonly", true}, Immovable{"safe/overcon/four", false},
                      Immovable{"safe/overcon/l", false}, Immovable{"safe/overcon/overcon", false},
                      Immovable{"constraints/welds_loop", true}, Immovable{"constraints/all_driven", true},
                      Immovable{"constraints/driven_weld", true, true}));

}  // namespace
}  // namespace flexura
