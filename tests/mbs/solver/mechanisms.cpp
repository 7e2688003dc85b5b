// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json.hpp>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/results/results.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/solver/run_folder.hpp"

/// Runs of whole mechanisms: from the file, with flexible bodies, through the command line.
namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class MechanismRun : public RunFolder {};

// A crank of 0.1 m, a rod of 0.35 m, a slider along x; the torque 2 N m against a load proportional to the
// speed.
const char* const engine = R"toml(
name = "slider crank"
gravity = [0, -9.81, 0]
[body.crank]
mass = 0.5
center = [0.05, 0, 0]
inertia = [1e-4, 4e-4, 4e-4]
[body.crank.marker.pin]
position = ["100 mm", 0, 0]
[body.rod]
mass = 0.8
center = [0.175, 0, 0]
inertia = [1e-4, 8e-3, 8e-3]
[body.rod.marker.end]
position = [0.35, 0, 0]
[body.slider]
mass = 1.2
[body.slider.marker.guide]
axis = [1, 0, 0]
[ground.marker.guide]
axis = [1, 0, 0]
[joint.shaft]
type = "revolute"
from = "ground"
to = "crank"
angle = "30 deg"
[joint.pin]
type = "revolute"
from = "crank.pin"
to = "rod"
[joint.guide]
type = "prismatic"
from = "ground.guide"
to = "slider.guide"
[joint.wrist]
type = "revolute"
from = "rod.end"
to = "slider"
[force.steam]
type = "joint_force"
joint = "shaft"
value = "2"
[force.load]
type = "joint_force"
joint = "guide"
value = "-10*guide.speed"
[solver]
end_time = "2 s"
output_step = "5 ms"
tolerance = 1e-9
)toml";

TEST_F(MechanismRun, SliderCrankKeepsToTheClosedFormAndClosesItsEnergyBook) {
  const PreparedMechanism p = prepare(file(engine));
  const auto infos = p.mechanism->quantities();
  std::vector<int> which(2, -1);
  for (std::size_t i = 0; i < infos.size(); ++i) {
    if (infos[i].name == "shaft.angle") which[0] = static_cast<int>(i);
    if (infos[i].name == "guide.position") which[1] = static_cast<int>(i);
  }
  ASSERT_GE(which[0], 0);
  ASSERT_GE(which[1], 0);
  double worst = 0.0, first_angle = -1.0;
  auto scratch = p.mechanism->make_scratch();
  RunCallbacks callbacks;
  callbacks.row = [&](const State& s, const Eigen::VectorXd& v_dot, const EnergyAccount&) {
    Eigen::VectorXd value(2);
    p.mechanism->evaluate(which, s, v_dot, *scratch, value);
    if (first_angle < 0.0) first_angle = value(0);
    // The slider starts at 0 and goes to the nearer of the two places where the loop closes.
    const double reach = std::sqrt(0.35 * 0.35 - std::pow(0.1 * std::sin(value(0)), 2));
    const double x = 0.1 * std::cos(value(0)) + std::copysign(reach, value(1));
    worst = std::max(worst, std::abs(value(1) - x));
  };
  const RunResult r = run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  ASSERT_TRUE(r.complete) << r.stopped_because;
  EXPECT_NEAR(first_angle, M_PI / 6, 1e-12);  // given, so kept
  EXPECT_LT(worst, 1e-8);
  EXPECT_GT(r.energy.work_in, 10.0);
  EXPECT_LT(std::abs(r.energy.error()), 1e-5 * r.energy.work_in);
  EXPECT_EQ(p.redundant.size(), 3u);
}

TEST_F(MechanismRun, MechanismThatCannotBeAssembledIsBadInput) {
  std::string text = engine;
  text.replace(text.find("[0.35, 0, 0]"), 12, "[0.35, 0, 1]");
  file(text);
  EXPECT_EQ(flexura("simulate m.toml -o m.h5"), 2);
  // The rod's end lies 1 m beside the slider's plane.
  EXPECT_THAT(text_of("err.txt"),
              AllOf(HasSubstr("error: "), HasSubstr("m.toml"), HasSubstr("cannot be assembled"),
                    HasSubstr("\"wrist\" (from \"rod.end\" to \"slider.frame\") by")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "m.h5"));
}

// Held by its joints a mechanism has equilibria and reactions all the same, and a one-way body its
// deformation.
TEST_F(MechanismRun, WhatCannotMoveHasEquilibriaAndModesOfItsDeformationAlone) {
  file(R"toml(
[body.stone]
mass = 1
inertia = [1, 1, 1]
[joint.held]
type = "fixed"
from = "ground"
to = "stone"
)toml");
  for (const char* command : {"statics", "eigen", "linearize"})
    EXPECT_EQ(flexura(std::string(command) + " m.toml"), 0) << command << text_of("err.txt");
  superelement::write(folder_ / "beam.se.h5", lattice::make_lattice(4).se);
  file(R"toml(
gravity = [0, 0, -1e-3]
[body.beam]
superelement = "beam.se.h5"
frame = "joint_fixed"
[joint.held]
type = "fixed"
from = "ground"
to = "beam.left"
[measure.tip]
type = "position"
from = "ground"
to = "beam.right"
direction = [0, 0, 1]
)toml");
  std::map<std::string, double> tip, hz;
  for (const std::string fidelity : {"modal", "ked", "rigid"}) {
    const std::string set = " m.toml --json --set body.beam.fidelity=" + fidelity;
    ASSERT_EQ(flexura("statics" + set), 0) << text_of("err.txt");
    const auto equilibrium = nlohmann::json::parse(text_of("out.txt"))["runs"][0];
    for (const auto& quantity : equilibrium["quantities"])
      if (quantity["name"] == "tip") tip[fidelity] = quantity["value"];
    ASSERT_EQ(flexura("eigen" + set), 0) << text_of("err.txt");
    const auto modes = nlohmann::json::parse(text_of("out.txt"))["runs"][0]["modes"];
    EXPECT_EQ(modes.empty(), fidelity == "rigid");
    if (!modes.empty()) hz[fidelity] = modes[0]["frequency_hz"];
    if (fidelity == "rigid") {
      // At no load does it buckle.
      ASSERT_EQ(flexura("eigen --buckling" + set), 0) << text_of("err.txt");
      EXPECT_TRUE(nlohmann::json::parse(text_of("out.txt"))["runs"][0]["modes"].empty());
      EXPECT_THAT(text_of("out.txt"), HasSubstr("nothing of the mechanism moves or deforms"));
    }
  }
  // The same linear equilibrium and the same modes, one-way or not; the weight is so small that what is of
  // second order in the deformation is below a thousandth.
  const double sag = tip["modal"] - tip["rigid"];
  EXPECT_LT(sag, -1e-8);
  EXPECT_NEAR(tip["ked"] - tip["rigid"], sag, -1e-3 * sag);
  EXPECT_NEAR(hz["ked"], hz["modal"], 1e-5 * hz["modal"]);  // of a linearisation by differences
}

// It is one body, whose pose tells nothing of how it bends.
TEST_F(MechanismRun, PlanarBeamIsDrawnElementByElement) {
  file(R"toml(
gravity = [0, -9.81, 0]
[body.rope]
fidelity = "cable"
[body.rope.beam]
to = [1.5, 0, 0]
elements = 3
planar = true
EA = 1e5
mass_per_length = 1
[joint.hook]
type = "revolute"
from = "ground"
to = "rope.root"
)toml");
  ASSERT_EQ(flexura("simulate m.toml -o m.h5 --end-time 0.3"), 0) << text_of("err.txt");
  const results::Results r = results::read(folder_ / "m.h5");
  ASSERT_EQ(r.model.bodies.size(), 5u);  // ground, the rope and three pictures
  for (std::size_t k : {2, 3}) {
    const Eigen::RowVectorXd from = r.runs[0].bodies[k].pose.bottomRows<1>(),
                             to = r.runs[0].bodies[k + 1].pose.bottomRows<1>();
    const Eigen::Quaterniond q(from(3), from(4), from(5), from(6));
    const Eigen::Vector3d end = from.head<3>().transpose() + q * Eigen::Vector3d(0.5, 0.0, 0.0);
    EXPECT_LT((to.head<3>().transpose() - end).norm(), 0.02);  // an arc is longer than its chord
  }
}

TEST_F(MechanismRun, CommandWritesNamedRunsTablesAndSummary) {
  file(std::string(engine) + R"toml(
[run.light]
set = ["body.slider.mass=0.6"]
[run.heavy]
)toml");
  ASSERT_EQ(flexura("simulate m.toml -o m.h5 --csv --set solver.end_time=0.5 --set solver.output_step=0.01"),
            0)
      << text_of("err.txt");
  const results::Results r = results::read(folder_ / "m.h5");
  ASSERT_EQ(r.runs.size(), 2u);
  EXPECT_EQ(r.runs[0].name, "light");
  for (const results::Run& run : r.runs) {
    EXPECT_TRUE(run.complete);
    ASSERT_EQ(run.time.size(), 51);
    EXPECT_DOUBLE_EQ(run.time(50), 0.5);
    int balance = -1, work = -1;
    for (std::size_t i = 0; i < run.quantities.size(); ++i) {
      if (run.quantities[i].name == "energy.balance") balance = static_cast<int>(i);
      if (run.quantities[i].name == "energy.input") work = static_cast<int>(i);
    }
    ASSERT_GE(balance, 0);
    EXPECT_LT(std::abs(run.values(50, balance)), 1e-5 * run.values(50, work));
    EXPECT_THAT(run.summary_json, AllOf(HasSubstr("\"steps\""), HasSubstr("relative_energy_error")));
    for (const results::BodyHistory& body : run.bodies)
      for (Eigen::Index i = 0; i < body.pose.rows(); ++i)
        EXPECT_NEAR(body.pose.row(i).tail<4>().norm(), 1.0, 1e-12);
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "m.light.csv"));
  EXPECT_THAT(text_of("out.txt"), AllOf(HasSubstr("heavy"), HasSubstr("error: of the energy balance")));

  EXPECT_EQ(flexura("simulate m.toml -o m2.h5 --run hevy"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("there is no run \"hevy\", did you mean \"heavy\"?"));
  EXPECT_EQ(flexura("assemble m.toml --run light"), 0);
  EXPECT_THAT(text_of("out.txt"),
              AllOf(HasSubstr("shaft.angle"), HasSubstr("0.523598776"), HasSubstr("multiplier")));
}

TEST_F(MechanismRun, CommandsCountFreedomsAndLineariseAboutTheEquilibrium) {
  file(engine);
  ASSERT_EQ(flexura("check m.toml"), 0) << text_of("err.txt");
  // Three joint coordinates less two closing conditions in the plane; three more are redundant there.
  const std::string checked = text_of("out.txt");
  EXPECT_THAT(checked, ::testing::ContainsRegex("n_DOF[^\n]* 1\n"));
  EXPECT_THAT(checked, ::testing::ContainsRegex("n_Eq[^\n]* 8\n"));
  EXPECT_THAT(checked, AllOf(HasSubstr("it closes a loop"), HasSubstr("wrist.z follows from")));

  file(rod);  // omega^2 = 3 g / (2 l)
  ASSERT_EQ(flexura("eigen m.toml --equilibrium"), 0) << text_of("err.txt");
  // sqrt(14.715) / 2 pi = 0.610527 Hz, about the rod that hangs down.
  EXPECT_THAT(text_of("out.txt"), AllOf(HasSubstr("0.61052"), HasSubstr("equilibrium in ")));
  ASSERT_EQ(flexura("eigen m.toml --equilibrium --pictures modes.h5 --amplitude 0.1"), 0)
      << text_of("err.txt");
  const results::Results modes = results::read(folder_ / "modes.h5");
  ASSERT_EQ(modes.runs.size(), 1u);
  const auto angle = [&](int row) {
    const auto& pose = modes.runs[0].bodies[1].pose;
    return 2.0 * std::atan2(pose(row, 6), pose(row, 3));
  };
  // 0.1 rad at the start, none after a quarter of the period, 25 rows for all of it.
  ASSERT_EQ(modes.runs[0].time.size(), 25);
  EXPECT_NEAR(std::abs(std::remainder(angle(0) - angle(6), 2.0 * M_PI)), 0.1, 1e-9);
  ASSERT_EQ(flexura("linearize m.toml --equilibrium --input hinge.speed --measure hinge.angle -o rod.m"), 0)
      << text_of("err.txt");
  EXPECT_THAT(text_of("rod.m"), AllOf(HasSubstr("states = {'hinge.angle', 'hinge.speed'};"),
                                      HasSubstr("-14.71"), HasSubstr("outputs = {'hinge.angle'};")));
  ASSERT_EQ(flexura("statics m.toml"), 0) << text_of("err.txt");
  EXPECT_THAT(text_of("out.txt"), HasSubstr("-1.57079633"));  // hinge.angle: straight down
  EXPECT_EQ(flexura("linearize m.toml --input hinge.sped"), 2);
  EXPECT_THAT(text_of("err.txt"), HasSubstr("did you mean \"hinge.speed\"?"));
}

std::shared_ptr<const FlexibleBody> flexible(const lattice::Lattice& l) {
  return std::make_shared<ModalBody>(modal_data(l.se));
}

// A body on a hinge at its left interface, swinging about z, gravity along -y.
MechanismDescription pendulum(const lattice::Lattice& l, bool is_flexible) {
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  int body;
  Pose at_node;
  int node = 0;
  if (is_flexible) {
    body = d.add_body({.name = "beam", .flexible = flexible(l)});
  } else {
    body = d.add_body({.name = "beam", .inertia = rigid_inertia(l.se)});
    at_node.p = l.se.interfaces[0].p_BoN_B;
    node = -1;
  }
  const int on_ground = d.add_marker(0, "pivot"), on_body = d.add_marker(body, "pivot", at_node, node);
  d.add_joint("pivot", "revolute", on_ground, on_body);
  return d;
}

TEST(FlexibleRun, StiffPendulumOfManyModesFallsLikeTheRigidOne) {
  // The deflection under the body's own weight goes with 1 / stiffness, and so does the difference of the
  // motions.
  double difference[2] = {};
  Mechanism rigid(pendulum(lattice::make_lattice(8), false));
  SolverOptions o;
  o.end_time = 1.5;
  o.output_step = 0.5;
  o.tolerance = 1e-7;
  State s = rigid.initial_state();
  Eigen::VectorXd v_dot;
  assemble(rigid, s, v_dot);
  const RunResult reference = run(rigid, s, v_dot, o);
  ASSERT_TRUE(reference.complete) << reference.stopped_because;
  ASSERT_GT(std::abs(reference.state.p(0)), 0.5);  // it does fall
  for (int k = 0; k < 2; ++k) {
    const Mechanism m(pendulum(lattice::make_lattice(8, k == 0 ? 1e4 : 4e6), true));
    EXPECT_GE(m.sizes().n_flx, 14);
    s = m.initial_state();
    assemble(m, s, v_dot);
    const RunResult r = run(m, s, v_dot, o);
    ASSERT_TRUE(r.complete) << r.stopped_because;
    std::printf("stiffness %g: %ld steps, %ld evaluations, difference %.3e, energy %.1e\n",
                k == 0 ? 1e4 : 4e6, r.counts.steps, r.counts.evaluations, r.state.p(0) - reference.state.p(0),
                r.energy.relative_error());
    difference[k] = std::abs(r.state.p(0) - reference.state.p(0));
    EXPECT_LT(r.energy.relative_error(), 1e-4);
  }
  // 400 times stiffer; what is left are the integration errors of 1.5 s at tolerance 1e-7, about 1e-5.
  EXPECT_LT(difference[1], 0.1 * difference[0]);
  EXPECT_LT(difference[1], 1e-4);
}

// Linear and angular momentum about W's origin, summed over the lattice's points.
std::pair<Eigen::Vector3d, Eigen::Vector3d> momenta(const Mechanism& m, const lattice::Lattice& l,
                                                    const State& s) {
  auto scratch = m.make_scratch();
  std::vector<Pose> here, there;
  m.body_poses(s, *scratch, here);
  State moved = s;
  Eigen::VectorXd p_dot(s.p.size());
  m.kinematic(s.p, s.v, p_dot);
  const double dt = 1e-6;  // central: errors of 1e-12 and of round-off 1e-10
  moved.p = s.p + dt * p_dot;
  m.body_poses(moved, *scratch, there);
  std::vector<Pose> behind;
  moved.p = s.p - dt * p_dot;
  m.body_poses(moved, *scratch, behind);
  const Eigen::Vector3d v_Bo = (there[1].p - behind[1].p) / (2 * dt);
  const Eigen::Matrix3d R_dot = (there[1].R - behind[1].R) / (2 * dt);
  const Eigen::MatrixXd& Y = m.description().bodies[1].flexible->modal()->Y;
  const int at = m.modal_position(1);
  const Eigen::VectorXd u = l.T * (Y * s.p.segment(at, Y.cols()));
  const Eigen::VectorXd u_dot = l.T * (Y * p_dot.segment(at, Y.cols()));
  Eigen::Vector3d P = Eigen::Vector3d::Zero(), L = P;
  for (int k = 0; k < l.x.cols(); ++k) {
    const Eigen::Vector3d x = l.x.col(k) + u.segment<3>(3 * k);
    const Eigen::Vector3d v = v_Bo + R_dot * x + here[1].R * u_dot.segment<3>(3 * k);
    P += l.mass(k) * v;
    L += l.mass(k) * (here[1].p + here[1].R * x).cross(v);
  }
  return {P, L};
}

TEST(FlexibleRun, FreeBodyKeepsLinearAndAngularMomentum) {
  const lattice::Lattice l = lattice::make_lattice(5, 4000.0);
  MechanismDescription d;
  d.add_body({.name = "beam", .flexible = flexible(l)});
  const Mechanism m(d);
  State s = m.initial_state();
  for (int i = 0; i < m.sizes().n_v; ++i)
    s.v(i) = i < 6 ? 1.0 + 0.5 * std::cos(2.0 * i) : 0.1 * std::sin(3.0 * i);
  Eigen::VectorXd v_dot;
  assemble(m, s, v_dot);
  const auto [P, L] = momenta(m, l, s);
  SolverOptions o;
  o.end_time = 1.0;
  o.output_step = 0.1;
  o.tolerance = 1e-8;
  double worst_P = 0.0, worst_L = 0.0;
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const Eigen::VectorXd&, const EnergyAccount&) {
    const auto [P_row, L_row] = momenta(m, l, row);
    worst_P = std::max(worst_P, (P_row - P).norm() / P.norm());
    worst_L = std::max(worst_L, (L_row - L).norm() / L.norm());
  };
  const RunResult r = run(m, s, v_dot, o, callbacks);
  ASSERT_TRUE(r.complete) << r.stopped_because;
  std::printf("free body: %ld steps, P %.1e, L %.1e, energy %.1e\n", r.counts.steps, worst_P, worst_L,
              r.energy.relative_error());
  // tolerance 1e-8 in each of some thousand steps; the momenta of the linearised modal field hold to first
  // order in the deformation's products with the spin, which the equations' own inertia terms keep exactly.
  EXPECT_LT(worst_P, 1e-5);
  EXPECT_LT(worst_L, 1e-5);
}

}  // namespace
}  // namespace flexura::mbs::test
