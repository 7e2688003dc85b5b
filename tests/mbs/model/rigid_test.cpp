// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/LU>

#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/model/checks.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;

constexpr double g_0 = 9.81;

/// Random bodies, one for each of the types, hung on each other in a branching tree; every other joint is
/// written with its From marker on the outer body.
MechanismDescription random_tree(const std::vector<std::string>& types, unsigned seed) {
  Random random(seed);
  MechanismDescription d;
  d.gravity = {0.3, -0.4, -g_0};
  for (std::size_t i = 0; i < types.size(); ++i) {
    const int b = d.add_body({.name = "body_" + std::to_string(i), .inertia = random.inertia()});
    const int parent = i < 2 ? static_cast<int>(i) : static_cast<int>(i) - static_cast<int>(i % 3 == 0);
    const int in = d.add_marker(parent, "out_" + std::to_string(i), random.pose());
    const int out = d.add_marker(b, "in", random.pose());
    if (i % 2 == 0)
      d.add_joint("joint_" + std::to_string(i), types[i], in, out);
    else
      d.add_joint("joint_" + std::to_string(i), types[i], out, in);
  }
  return d;
}

std::vector<std::string> type_names() {
  std::vector<std::string> names;
  for (const JointType& type : joint_types()) names.push_back(type.name);
  return names;
}

TEST(Joint, RowsVanishOnItsMotionAndRestrainAllElse) {
  Random random(1);
  for (const std::string& type : type_names()) {
    SCOPED_TRACE(type);
    const auto joint = make_joint(type);
    double q[7], d[6], v[6], q_moved[7];
    joint->reference(q);
    for (double& x : d) x = random(-0.8, 0.8);
    joint->retract(q, d, q_moved);
    for (double& x : v) x = random();
    const Pose X = joint->pose(q_moved);
    MotionMatrix S(6, joint->n_v());
    joint->motion(q_moved, S);
    Vector6d V = Vector6d::Zero();
    for (int i = 0; i < joint->n_v(); ++i) V += S.col(i) * v[i];
    Rows rows(X, V);
    joint->constrain(rows);
    ASSERT_EQ(rows.n, 6 - joint->n_v());
    EXPECT_LE(rows.g.cwiseAbs().maxCoeff(), 1e-14);
    const MatrixXd G = rows.G.topRows(rows.n);
    if (rows.n > 0 && joint->n_v() > 0) {
      EXPECT_LE((G * S).cwiseAbs().maxCoeff(), 1e-14);
    }
    if (rows.n > 0) {
      EXPECT_EQ(Eigen::FullPivLU<MatrixXd>(G).rank(), rows.n);
    }
    // g'' = G (S v' + bias) + gamma vanishes for every v'.
    const VectorXd g_ddot = G * joint->bias(q_moved, v) + rows.gamma.head(rows.n);
    if (rows.n > 0) {
      EXPECT_LE(g_ddot.cwiseAbs().maxCoeff(), 1e-13);
    }
    // Coordinates and speeds come back from pose and twist.
    double q_back[7], v_back[6];
    joint->coordinates_of(X, q_back);
    joint->speeds_of(q_moved, V, v_back);
    const Pose X_back = joint->pose(q_back);
    EXPECT_LE((X_back.R - X.R).cwiseAbs().maxCoeff() + (X_back.p - X.p).cwiseAbs().maxCoeff(), 1e-14);
    for (int i = 0; i < joint->n_v(); ++i) EXPECT_NEAR(v_back[i], v[i], 1e-14);
  }
}

TEST(Joint, MotionIsDerivativeOfPose) {
  Random random(2);
  for (const std::string& type : type_names()) {
    SCOPED_TRACE(type);
    const auto joint = make_joint(type);
    double q_0[7], q[7], a[7], b[7], d[6], d_minus[6];
    joint->reference(q_0);
    for (double& x : d) x = random(-0.8, 0.8);
    joint->retract(q_0, d, q);
    MotionMatrix S(6, joint->n_v());
    joint->motion(q, S);
    for (int i = 0; i < joint->n_v(); ++i) {
      const double h = 1e-5;  // truncation h^2/6, round-off 1e-16/h: both about 1e-11
      for (int k = 0; k < 6; ++k) d[k] = k == i ? h : 0.0, d_minus[k] = -d[k];
      joint->retract(q, d, a);
      joint->retract(q, d_minus, b);
      const Pose X = joint->pose(q), X_a = joint->pose(a), X_b = joint->pose(b);
      const Matrix3d W = (X_a.R - X_b.R) / (2 * h) * X.R.transpose();
      Vector6d V;
      V << W(2, 1), W(0, 2), W(1, 0), (X_a.p - X_b.p) / (2 * h);
      EXPECT_LE((S.col(i) - V).cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(RigidTree, SatisfiesAllIdentities) {
  for (unsigned seed : {1u, 2u, 3u}) {
    std::vector<std::string> types = type_names();
    std::ranges::rotate(types, types.begin() + seed % types.size());
    std::vector<std::string> twice = types;
    twice.insert(twice.end(), types.begin(), types.end());
    // A fixed body at the end would be carried by its parent's freedoms: fine anywhere.
    all_identities_hold(Mechanism(random_tree(twice, seed)), seed);
  }
}

TEST(RigidTree, SatisfiesLagrangesEquations) {
  // Three slides and three turns carry the first body through every motion in space without quaternions; odd
  // joints are reversed.
  const Mechanism mechanism(random_tree({"prismatic", "prismatic", "prismatic", "revolute", "revolute",
                                         "revolute", "fixed", "revolute", "prismatic", "revolute"},
                                        7));
  lagrange_equations_hold(mechanism, random_state(mechanism, 8), 9);
}

TEST(Closure, OfEveryJointTypeSatisfiesAllIdentities) {
  unsigned seed = 20;
  for (const std::string& type : type_names()) {
    SCOPED_TRACE(type);
    MechanismDescription d = random_tree({"six_dof", "revolute", "spherical", "prismatic"}, ++seed);
    Random random(seed);
    const int F = d.add_marker(2, "loop_F", random.pose()), M = d.add_marker(4, "loop_M", random.pose());
    const int joint = d.add_joint("loop", type, F, M);
    d.joints[joint].cut = true;
    all_identities_hold(Mechanism(d), seed);
  }
}

TEST(FreeBody, FallsWithGravity) {
  Random random(3);
  MechanismDescription d;
  d.gravity = {0, 0, -g_0};
  const Pose X = random.pose();
  d.add_body({.name = "stone", .inertia = random.inertia(), .X_WB = X});
  const Mechanism mechanism(d);
  EXPECT_EQ(mechanism.sizes().n_p, 7);
  EXPECT_EQ(mechanism.sizes().n_v, 6);
  State s = mechanism.initial_state();
  const auto scratch = mechanism.make_scratch();
  std::vector<Pose> poses;
  mechanism.body_poses(s, *scratch, poses);
  EXPECT_LE((poses[1].R - X.R).norm() + (poses[1].p - X.p).norm(), 1e-14);
  VectorXd v_dot = VectorXd::Zero(6);
  v_dot(5) = -g_0;
  EXPECT_LE(momentum(mechanism, s, v_dot).cwiseAbs().maxCoeff(), 1e-14 * g_0 * 4);
  EXPECT_EQ(mechanism.name_of_position(4), "stone.x");
  EXPECT_EQ(mechanism.name_of_velocity(0), "stone.omega_x");
}

TEST(Tree, IsBreadthFirstAndTakesDrivenJointsFirst) {
  // Ground - a - b - c - ground: without a drive the joint b-c, last to be reached, closes the loop; when it
  // is driven, a-b does.
  for (bool driven : {false, true}) {
    MechanismDescription d;
    Random random(4);
    for (const char* name : {"a", "b", "c"}) d.add_body({.name = name, .inertia = random.inertia()});
    const auto join = [&](const std::string& name, int x, int y) {
      return d.add_joint(name, "revolute", d.add_marker(x, name + "_1"), d.add_marker(y, name + "_2"));
    };
    join("ground_a", 0, 1);
    const int a_b = join("a_b", 1, 2);
    const int b_c = join("b_c", 2, 3);
    const int c_ground = join("c_ground", 3, 0);
    if (driven)
      d.joints[b_c].drives[0] = std::make_shared<Expression>("joint.b_c.drive", "sin(t)", d.signals,
                                                             std::map<std::string, double>{});
    const Mechanism mechanism(d);
    EXPECT_EQ(mechanism.in_tree(b_c), driven);
    EXPECT_EQ(mechanism.in_tree(a_b), !driven);
    EXPECT_TRUE(mechanism.is_reversed(c_ground));
  }
}

}  // namespace
}  // namespace flexura::mbs
