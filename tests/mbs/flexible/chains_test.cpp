// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/statics/statics.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/flexible/chain.hpp"

/// Flexible bodies on flexible bodies, so many that the program closes the joints between them as constraints
/// (mbs/mechanism/topology/split_branches.cpp).
namespace flexura::mbs {
namespace {

using Eigen::VectorXd;

const int kLinks = Chain().links;

beams::StraightBeam rope() {
  beams::StraightBeam b;
  b.EA = 1e4;
  b.GI_t = b.EI_y = b.EI_z = 50.0;
  b.rho_I_y = b.rho_I_z = 1e-4;
  b.elements = 2;
  return b;
}

std::shared_ptr<const FlexibleBody> link_body(double damping = 0.0) {
  BasisOptions options;  // all twelve deformations
  options.damping = damping;
  return std::make_shared<ModalBody>(modal_data(beams::beam_superelement(rope()), options));
}

Mechanism make_chain(const std::shared_ptr<const FlexibleBody>& link, const Chain& chain) {
  return Mechanism(chain_of(link, chain));
}

Vector3d end_of(const Mechanism& m, const State& s) {
  std::vector<Pose> poses;
  m.body_poses(s, *m.make_scratch(), poses);
  const FlexibleBody& link = *m.description().bodies[kLinks].flexible;
  return (poses[kLinks] * link.node_pose(1, s.p.data() + m.modal_position(kLinks))).p;
}

TEST(ChainOfFlexibleBodies, PartsIntoItsLinks) {
  const auto link = link_body();
  const Mechanism parted = make_chain(link, {}), whole = make_chain(link, {.keep_whole = true});
  EXPECT_EQ(whole.sizes().n_lambda, 0);
  // Every hinge but the one at the wall holds back five of six freedoms.
  EXPECT_EQ(parted.sizes().n_lambda, 5 * (kLinks - 1));
  EXPECT_EQ(parted.sizes().n_v - parted.sizes().n_lambda, whole.sizes().n_v);
  for (int j = 0; j < kLinks; ++j) EXPECT_EQ(parted.in_tree(j), j == 0) << j;
  // The bodies start where the joints put them.
  EXPECT_LE((end_of(parted, parted.initial_state()) - Vector3d(kLinks, 0, 0)).norm(), 1e-14 * kLinks);
}

TEST(ChainOfFlexibleBodies, WhatReadsOrDrivesAJointKeepsItInTheTree) {
  const auto link = link_body();
  MechanismDescription d = chain_of(link, {});
  d.joints[4].initial_coordinates[0] = 0.1;
  const Mechanism m(d);
  for (int j = 0; j < kLinks; ++j) EXPECT_EQ(m.in_tree(j), j == 0 || j == 4) << j;
}

TEST(ChainOfFlexibleBodies, StartsWithTheSpeedOfItsFirstJoint) {
  const auto link = link_body();
  MechanismDescription d = chain_of(link, {.keep_whole = true});
  d.joints[0].initial_speeds[0] = 2.0;
  const Mechanism whole(d);
  for (JointDescription& joint : d.joints) joint.keep_in_tree = false;
  const Mechanism parted(d);
  ASSERT_GT(parted.sizes().n_lambda, 0);
  const auto energy = [](const Mechanism& m) {
    State s = m.initial_state();
    return m.energy(s, VectorXd::Zero(m.sizes().n_v), *m.make_scratch()).kinetic;
  };
  // Both turn as one rigid rod about the wall: m L^2 / 6 w^2 of a uniform rod of 9 kg and 9 m, beside the
  // rotary inertia of its sections.
  const double exact = (9.0 * 81.0 / 6.0 + 0.5 * 9.0 * 1e-4) * 4.0;
  EXPECT_NEAR(energy(whole), exact, 1e-12 * exact);
  EXPECT_NEAR(energy(parted), exact, 1e-12 * exact);
}

TEST(ChainOfFlexibleBodies, HangsStretchedByItsOwnWeight) {
  // Hanging down, every section carries what is below it: the end sinks by rho A g L^2 / 2 EA.
  for (const bool keep_whole : {false, true}) {
    SCOPED_TRACE(keep_whole);
    MechanismDescription d = chain_of(link_body(), {.keep_whole = keep_whole});
    d.gravity = {9.81, 0.0, 0.0};
    const Mechanism m(d);
    State s = m.initial_state();
    s.lambda = VectorXd::Zero(m.sizes().n_lambda);
    solve_statics(m, s);
    const double exact = 9.81 * kLinks * kLinks / (2.0 * rope().EA);
    // A linear element is exact at its nodes; the axial load does no work on what bends.
    EXPECT_NEAR(end_of(m, s).x() - kLinks, exact, 1e-9);
  }
}

RunResult fall(const Mechanism& m, State& s, double end_time, double tolerance) {
  VectorXd v_dot;
  s.lambda = VectorXd::Zero(m.sizes().n_lambda);
  assemble(m, s, v_dot);
  SolverOptions options;
  options.method = "radau";
  options.end_time = options.output_step = end_time;
  options.tolerance = tolerance;
  return run(m, s, v_dot, options);
}

TEST(ChainOfFlexibleBodies, MovesAsTheSameChainInTreeCoordinates) {
  const auto link = link_body(0.5);
  for (const bool closed : {false, true}) {
    SCOPED_TRACE(closed);
    Vector3d end[2], middle[2];
    for (const bool keep_whole : {false, true}) {
      const Mechanism m = make_chain(link, {.keep_whole = keep_whole, .closed = closed});
      State s = m.initial_state();
      const RunResult r = fall(m, s, 0.1, 1e-5);
      ASSERT_TRUE(r.complete) << r.stopped_because;
      EXPECT_LT(std::abs(r.energy.error()), 1e-4 * r.energy.peak);
      end[keep_whole] = end_of(m, r.state);
      std::vector<Pose> poses;
      m.body_poses(r.state, *m.make_scratch(), poses);
      middle[keep_whole] = poses[kLinks / 2 + 1].p;
    }
    if (!closed) EXPECT_GT(std::abs(end[0].y()), 0.04);  // g t^2 / 2, nearly: 0.049 m
    // Some ten steps of 1e-5 relative to metres.
    EXPECT_LT((end[0] - end[1]).norm(), 1e-4);
    EXPECT_LT((middle[0] - middle[1]).norm(), 1e-4);
  }
}

TEST(ChainOfFlexibleBodies, FallsFreelyWithItsCentreOfMass) {
  const auto link = link_body(0.5);
  const Mechanism m = make_chain(link, {.floats = true});
  ASSERT_EQ(m.sizes().n_lambda, 5 * (kLinks - 1));
  const auto centre = [&](const State& s) {
    std::vector<Pose> poses;
    m.body_poses(s, *m.make_scratch(), poses);
    const auto scratch = link->make_scratch();
    auto& work = *scratch;
    Vector3d sum = Vector3d::Zero();
    for (int b = 1; b <= kLinks; ++b) {
      link->set_position(s.p.data() + m.modal_position(b), work);
      sum += poses[b] * Vector3d(work.d / link->mass());
    }
    return Vector3d(sum / kLinks);
  };
  State s = m.initial_state();
  // Every link spins its own way, as far as the hinges let it.
  const int stride = 6 + link->m();
  for (int i = 0; i < m.sizes().n_v; ++i) s.v(i) = i % stride < 6 ? 0.3 * std::cos(1.3 * i) : 0.0;
  AssembleOptions quiet;
  for (int i = 0; i < m.sizes().n_v; ++i) quiet.keep_velocity.push_back(i % stride >= 6);
  VectorXd v_dot;
  s.lambda = VectorXd::Zero(m.sizes().n_lambda);
  assemble(m, s, v_dot, quiet);
  // The centre's velocity, by central differences of its place along the motion: exact to h^2.
  const double h = 1e-5;
  State ahead = s, behind = s;
  m.retract(s.p, VectorXd(h * s.v), ahead.p);
  m.retract(s.p, VectorXd(-h * s.v), behind.p);
  const Vector3d start = centre(s), speed = (centre(ahead) - centre(behind)) / (2.0 * h);
  const double t = 0.1;
  const RunResult r = fall(m, s, t, 1e-6);
  ASSERT_TRUE(r.complete) << r.stopped_because;
  const Vector3d expected = start + t * speed + 0.5 * t * t * Vector3d(0.0, -9.81, 0.0);
  // Some tens of steps of 1e-6; the difference quotient is right to 1e-9.
  EXPECT_LT((centre(r.state) - expected).norm(), 1e-5);
  EXPECT_LT(std::abs(r.energy.error()), 1e-4 * r.energy.peak);
}

}  // namespace
}  // namespace flexura::mbs
