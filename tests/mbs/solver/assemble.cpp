// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/position/assemble.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "mbs/solver/algebra/accelerations.hpp"
#include "tests/mbs/solver/planar.hpp"

namespace flexura::mbs::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TEST(Assemble, SliderCrankClosesAtTheClosedFormPosition) {
  const PlanarMechanism m = slider_crank(0.1, 0.3);
  State s = make_state(m);
  s.p << 0.7, -0.1, 0.5;  // the rod hangs open by about 0.1 m
  s.v << 12.0, 0.0, 0.0;
  AssembleOptions keep;
  keep.keep_position = {true, false, false};
  keep.keep_velocity = {true, false, false};
  Eigen::VectorXd v_dot;
  const AssembleReport report = assemble(m, s, v_dot, keep);
  const double beta = -std::asin(0.1 * std::sin(0.7) / 0.3);
  const double x = 0.1 * std::cos(0.7) + 0.3 * std::cos(beta);
  const double beta_dot = -0.1 * std::cos(0.7) * 12.0 / (0.3 * std::cos(beta));
  const double x_dot = -0.1 * std::sin(0.7) * 12.0 - 0.3 * std::sin(beta) * beta_dot;
  // Newton ends at round-off of lengths of 0.4 m: 1e-15 amplified by 1 / (l cos beta).
  EXPECT_EQ(s.p(0), 0.7);
  EXPECT_NEAR(s.p(1), beta, 1e-14);
  EXPECT_NEAR(s.p(2), x, 1e-14);
  EXPECT_EQ(s.v(0), 12.0);
  EXPECT_NEAR(s.v(1), beta_dot, 1e-12);
  EXPECT_NEAR(s.v(2), x_dot, 1e-12);
  EXPECT_TRUE(report.positions_kept && report.velocities_kept);
  EXPECT_EQ(report.constraint_rank, 2);
  EXPECT_LT(report.position_residual, 1e-15);
}

TEST(Assemble, AndrewsMechanismHasThePublishedAccelerationsAndMultipliers) {
  const PlanarMechanism m = andrews();
  State s = make_state(m);
  s.p << -0.0617138900142764496, 0, 0.455279819163070380, 0.222668390165885885, 0.487364979543842550,
      -0.222668390165885885, 1.23054744454982119;
  Eigen::VectorXd v_dot;
  const Eigen::VectorXd published = s.p;
  assemble(m, s, v_dot);
  // The published angles are consistent to 1e-16, so assembling leaves them there but for round-off.
  EXPECT_LT((s.p - published).cwiseAbs().maxCoeff(), 1e-14);
  Eigen::VectorXd w(7);
  w << 14222.4439199541, -10666.8329399656, 0, 0, 0, 0, 0;
  // 15 digits are printed; M has condition 1e3.
  EXPECT_LT((v_dot - w).cwiseAbs().maxCoeff(), 1e-11 * 14222);
  Eigen::VectorXd lambda(6);
  lambda << 98.5668703962411, -6.12268834425567, 0, 0, 0, 0;
  EXPECT_LT((s.lambda - lambda).cwiseAbs().maxCoeff(), 1e-11 * 98);
}

TEST(Assemble, StretchedLoopStillFindsItsWayOut) {
  // Both rods on the x axis, piston 0.05 m too near: to first order no rotation helps.
  const PlanarMechanism m = slider_crank(0.1, 0.3);
  State s = make_state(m);
  s.p << 0.0, 0.0, 0.35;
  AssembleOptions keep;
  keep.keep_position = {false, false, true};
  const AssembleReport report = assemble_positions(m, s, keep);
  EXPECT_TRUE(report.positions_kept);
  EXPECT_NEAR(s.p(2), 0.35, 0.0);
  EXPECT_NEAR(0.1 * std::cos(s.p(0)) + 0.3 * std::cos(s.p(1)), 0.35, 1e-14);
  EXPECT_NEAR(0.1 * std::sin(s.p(0)) + 0.3 * std::sin(s.p(1)), 0.0, 1e-14);
}

TEST(Assemble, PrescribedValuesThatContradictTheLoopAreReportedByName) {
  const PlanarMechanism m = slider_crank(0.1, 0.3);
  State s = make_state(m);
  s.p << 0.7, -0.2, 0.5;
  s.v << 12.0, 0.0, 3.0;
  AssembleOptions keep;
  keep.keep_position = {true, false, true};  // x = 0.5 is out of the crank's reach
  keep.keep_velocity = {true, false, true};
  Eigen::VectorXd v_dot;
  const AssembleReport report = assemble(m, s, v_dot, keep);
  EXPECT_FALSE(report.positions_kept);
  EXPECT_FALSE(report.velocities_kept);
  ASSERT_EQ(report.notes.size(), 2u);
  EXPECT_THAT(report.notes[0],
              AllOf(HasSubstr("prescribed initial positions \"q0\", \"q2\""), HasSubstr("moved")));
  EXPECT_THAT(report.notes[1],
              AllOf(HasSubstr("prescribed initial velocities \"q0\", \"q2\""), HasSubstr("changed")));
}

TEST(Assemble, MechanismThatCannotCloseNamesTheWorstConstraint) {
  PlanarMechanism m = slider_crank(0.1, 0.3);
  // The piston's path 1 m away from the crank's axis: the rod cannot reach.
  m.constraints[1].offset = 1.0;
  State s = make_state(m);
  s.p << 0.7, 0.4, 0.35;
  try {
    assemble_positions(m, s);
    FAIL() << "assembled";
  } catch (const AssemblyError& e) {
    // The best that rod and crank can do is to point straight up: 1 - 0.1 - 0.3 = 0.6 m are missing.
    EXPECT_THAT(e.what(), AllOf(HasSubstr("cannot be assembled at t = 0 s"), HasSubstr("\"rod_end.y\" (-0.6"),
                                HasSubstr("check the markers")));
  }
}

TEST(Assemble, ConflictingDrivesNameTheirConstraints) {
  PlanarMechanism m = slider_crank(0.1, 0.3);
  PlanarPoint crank_angle;
  m.constraints.push_back({PlanarPoint().slide(m.unit({0}), 1, 0), {1, 0}, 5.0, 0.7, "drive_1"});
  m.constraints.push_back({PlanarPoint().slide(m.unit({0}), 1, 0), {1, 0}, 6.0, 0.7, "drive_2"});
  State s = make_state(m);
  s.p << 0.7, -0.2, 0.37;
  Eigen::VectorXd v_dot;
  try {
    assemble(m, s, v_dot);
    FAIL() << "assembled";
  } catch (const AssemblyError& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("initial velocities cannot be made consistent"),
                                HasSubstr("\"drive_1\""), HasSubstr("\"drive_2\"")));
  }
}

TEST(Assemble, RedundantRowsGiveTheSameAccelerationsAndTheReportedRank) {
  const PlanarMechanism m = windows(2);
  PlanarMechanism twice = m;
  for (const auto& c : m.constraints) twice.constraints.push_back(c);
  State s = make_state(m), s2 = make_state(twice);
  for (State* state : {&s, &s2}) {
    state->p << 1.3, 1.3, 1.3, 0.0, 0.0;
    state->v << -1.0, -1.0, -1.0, 0.0, 0.0;
  }
  Eigen::VectorXd v_dot, v_dot_2;
  EXPECT_EQ(assemble(m, s, v_dot).constraint_rank, 4);
  EXPECT_EQ(assemble(twice, s2, v_dot_2).constraint_rank, 4);
  // Rank decisions do not touch x: round-off of entries of 10 rad/s2.
  EXPECT_LT((v_dot - v_dot_2).norm(), 1e-12);
  // The least-norm multipliers share the load equally between the twins.
  EXPECT_LT((s2.lambda.head(4) - 0.5 * s.lambda).norm(), 1e-11);
  EXPECT_LT((s2.lambda.tail(4) - 0.5 * s.lambda).norm(), 1e-11);
  // One degree of freedom: th'' = -g W cos(th) / I with I = (N+1)/3 + N, W = (N+1)/2 + N.
  EXPECT_NEAR(v_dot(0), -9.81 * 3.5 * std::cos(1.3) / 3.0, 1e-12);
}

TEST(Assemble, MasslessCoordinateIsNamed) {
  PlanarMechanism m = slider_crank(0.1, 0.3);
  m.bodies[2].mass = 0.0;
  State s = make_state(m);
  s.p << 0.7, -0.2, 0.37;
  Eigen::VectorXd v_dot;
  try {
    assemble(m, s, v_dot);
    FAIL() << "assembled";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr("mass matrix is not positive definite at \"q2\""),
                                HasSubstr("positive mass or inertia")));
  }
}

}  // namespace
}  // namespace flexura::mbs::test
