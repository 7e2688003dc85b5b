// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/LU>

#include "tests/mbs/model/checks.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;

constexpr double g_0 = 9.81;

/// Crank of length a about z at the origin, rod of length l, slider along x with offset 0: revolute joints
/// with parallel axes and a prismatic joint along x.
MechanismDescription slider_crank(double a, double l) {
  MechanismDescription d;
  d.gravity = {0, -g_0, 0};
  const auto rod = [](double m, double length) {
    return RigidInertia::from_center(
        m, {0.5 * length, 0, 0},
        Vector3d(1e-4, m * length * length / 12, m * length * length / 12).asDiagonal());
  };
  const int crank = d.add_body({.name = "crank", .inertia = rod(0.5, a)});
  const int con = d.add_body({.name = "rod", .inertia = rod(0.8, l)});
  const int slider = d.add_body(
      {.name = "slider", .inertia = RigidInertia::from_center(1.2, {0, 0, 0}, 1e-3 * Matrix3d::Identity())});
  const Pose at_a{Matrix3d::Identity(), {a, 0, 0}}, at_l{Matrix3d::Identity(), {l, 0, 0}};
  const Pose along_x{frame_along(Vector3d::UnitX()), Vector3d::Zero()};
  const int shaft = d.add_joint("shaft", "revolute", d.add_marker(0, "shaft"), d.add_marker(crank, "shaft"));
  d.add_joint("pin", "revolute", d.add_marker(crank, "pin", at_a), d.add_marker(con, "big_end"));
  d.add_joint("guide", "prismatic", d.add_marker(0, "guide", along_x),
              d.add_marker(slider, "guide", along_x));
  d.add_joint("wrist", "revolute", d.add_marker(con, "small_end", at_l), d.add_marker(slider, "wrist"));
  d.joints[shaft].drives[0] = std::make_shared<Expression>("joint.shaft.drive", "0.4 + 30*t", d.signals,
                                                           std::map<std::string, double>{});
  d.joints[2].initial_coordinates[0] = a + l;
  return d;
}

TEST(SliderCrank, FollowsClosedForm) {
  const double a = 0.1, l = 0.35, w = 30.0;
  Mechanism mechanism(slider_crank(a, l));
  State s = mechanism.initial_state();
  assemble(mechanism, s);
  // A closed planar loop of three revolutes and a slider holds three redundant rows.
  EXPECT_EQ(mechanism.drop_redundant(0.0, s.p).size(), 3u);
  ASSERT_EQ(mechanism.sizes().n_lambda, mechanism.sizes().n_v);  // n_DOF = 0: the crank is driven
  const auto scratch = mechanism.make_scratch();
  const int n = mechanism.sizes().n_v;
  int i_x = -1;
  for (int i = 0; i < mechanism.sizes().n_p; ++i)
    if (mechanism.name_of_position(i) == "guide.position") i_x = i;
  ASSERT_GE(i_x, 0);
  for (double t = 0.0; t < 0.3; t += 0.007) {
    s.t = t;
    assemble(mechanism, s);
    MatrixXd G(n, n);
    mechanism.constraint_matrix(t, s.p, *scratch, G);
    VectorXd rate(n), bias(n);
    mechanism.velocity_constraints(t, s.p, VectorXd::Zero(n), *scratch, rate);
    s.v = Eigen::FullPivLU<MatrixXd>(G).solve(-rate);
    mechanism.acceleration_constraints(t, s.p, s.v, VectorXd::Zero(n), *scratch, bias);
    const VectorXd v_dot = Eigen::FullPivLU<MatrixXd>(G).solve(-bias);
    // x = a cos(phi) + sqrt(l^2 - a^2 sin^2 phi) and its derivatives.
    const double phi = 0.4 + w * t, si = std::sin(phi), co = std::cos(phi);
    const double root = std::sqrt(l * l - a * a * si * si);
    const double x = a * co + root;
    const double dx = -a * si - a * a * si * co / root;
    const double ddx =
        -a * co - a * a * (co * co - si * si) / root - std::pow(a * a * si * co, 2) / std::pow(root, 3);
    EXPECT_NEAR(s.p(i_x), x, 1e-12);  // assembled to 1e-13, carried by well-conditioned G
    EXPECT_NEAR(s.v(i_x), w * dx, 1e-11 * w);
    EXPECT_NEAR(v_dot(i_x), w * w * ddx, 1e-11 * w * w);
  }
}

TEST(SliderCrank, DriveTorqueIsPowerOfMotion) {
  Mechanism mechanism(slider_crank(0.1, 0.35));
  all_identities_hold(mechanism, 5);
}

/// Lengths l of ground link, crank, coupler, rocker; at fold = true all lie on one line (a dead point).
Mechanism four_bar(double ground, double crank, double coupler, double rocker,
                   const Matrix3d& tilt = Matrix3d::Identity(), double mismatch = 0.0) {
  MechanismDescription d;
  const auto inertia = [](double l) {
    return RigidInertia::from_center(l, {0.5 * l, 0, 0}, 0.1 * l * Matrix3d::Identity());
  };
  const int a = d.add_body({.name = "crank", .inertia = inertia(crank)});
  const int b = d.add_body({.name = "coupler", .inertia = inertia(coupler)});
  const int c = d.add_body({.name = "rocker", .inertia = inertia(rocker)});
  const auto at = [](double l) { return Pose{Matrix3d::Identity(), {l, 0, 0}}; };
  d.add_joint("A", "revolute", d.add_marker(0, "A", {tilt, {0, 0, 0}}), d.add_marker(a, "A"));
  d.add_joint("B", "revolute", d.add_marker(a, "B", at(crank)), d.add_marker(b, "B"));
  d.add_joint("D", "revolute", d.add_marker(0, "D", Pose{tilt, {0, 0, 0}} * at(ground)),
              d.add_marker(c, "D"));
  d.add_joint("C", "revolute", d.add_marker(b, "C", at(coupler)),
              d.add_marker(c, "C", {Matrix3d::Identity(), {rocker, 0, mismatch}}));
  d.joints[0].initial_coordinates[0] = 0.9;
  d.joints[2].initial_coordinates[0] = 1.2;
  d.joints[1].initial_coordinates[0] = -0.7;
  return Mechanism(d);
}

TEST(FourBar, HasThreeRedundantRows) {
  Mechanism mechanism = four_bar(1.0, 0.4, 0.9, 0.8);
  State s = mechanism.initial_state();
  assemble(mechanism, s);
  const std::vector<RedundantRow> redundant = mechanism.drop_redundant(0.0, s.p);
  EXPECT_EQ(redundant.size(), 3u);
  EXPECT_EQ(mechanism.sizes().n_lambda, 2);
  EXPECT_EQ(mechanism.name_of_constraint(0), "C.x");
  EXPECT_EQ(mechanism.name_of_constraint(1), "C.y");
  std::vector<std::string> names;
  for (const RedundantRow& row : redundant) names.push_back(row.name);
  EXPECT_EQ(names, (std::vector<std::string>{"C.z", "C.axis_x", "C.axis_y"}));
  constraints_are_consistent(mechanism, random_state(mechanism, 31), 32);
}

TEST(FourBar, IsRecognisedInAnyPlaneAndWithASmallMismatch) {
  // Tilted axes leave round-off in the redundant rows, and parts made on different meshes do not meet exactly
  // across their plane: neither makes a row independent.
  for (unsigned seed : {1u, 2u, 3u}) {
    Random random(seed);
    Mechanism mechanism = four_bar(1.0, 0.4, 0.9, 0.8, rotation_exp(random.vector3(2.0)), 3e-9);
    State s = mechanism.initial_state();
    const auto scratch = mechanism.make_scratch();
    // Close the two rows that can be closed.
    VectorXd g(5), next(3);
    MatrixXd G(5, 3);
    for (int k = 0; k < 30; ++k) {
      mechanism.position_constraints(0.0, s.p, *scratch, g);
      mechanism.constraint_matrix(0.0, s.p, *scratch, G);
      const MatrixXd G_xy = G.topRows(2);
      const MatrixXd normal = G_xy * G_xy.transpose();
      mechanism.retract(s.p, VectorXd(-G_xy.transpose() * normal.fullPivLu().solve(g.head(2))), next);
      s.p = next;
    }
    EXPECT_EQ(mechanism.drop_redundant(0.0, s.p).size(), 3u);
    EXPECT_EQ(mechanism.sizes().n_lambda, 2);
  }
}

TEST(FourBar, KeepsItsRowsAtADeadPoint) {
  // Crank + coupler = ground + rocker: stretched out, the two planar rows have parallel gradients, G loses a
  // rank.
  Mechanism mechanism = four_bar(1.0, 0.6, 1.2, 0.8);
  State s = mechanism.initial_state();
  s.p << 0.0, 0.0, 0.0;
  for (int i = 0; i < 3; ++i)
    if (mechanism.name_of_position(i) == "D.angle") s.p(i) = 0.0;
  assemble(mechanism, s);
  const auto scratch = mechanism.make_scratch();
  MatrixXd G(5, 3);
  mechanism.constraint_matrix(0.0, s.p, *scratch, G);
  ASSERT_EQ(Eigen::FullPivLU<MatrixXd>(G).setThreshold(1e-6).rank(), 1);
  EXPECT_EQ(mechanism.drop_redundant(0.0, s.p).size(), 3u);
  EXPECT_EQ(mechanism.sizes().n_lambda, 2);
}

TEST(Bricard, HasOneRedundantRowAndMoves) {
  // IFToMM benchmark A04: six hinges that Gruebler's count holds fast; its special axes leave one freedom.
  const Vector3d points[] = {{0, 0, 0}, {1, 0, 0}, {1, -1, 0}, {1, -1, 1}, {0, -1, 1}, {0, 0, 1}};
  const int axes[] = {1, 2, 0, 1, 2, 0};
  MechanismDescription d;
  for (int i = 0; i < 5; ++i) {
    const Vector3d half = 0.5 * (points[i + 1] - points[i]);
    d.add_body({.name = "rod_" + std::to_string(i),
                .inertia = RigidInertia::from_center(1.0, half, 0.08 * Matrix3d::Identity())});
  }
  for (int i = 0; i < 6; ++i) {
    // Rod frames stand at their first point, parallel to the world.
    const Matrix3d R = frame_along(Vector3d::Unit(axes[i]));
    const int before = i, after = i < 5 ? i + 1 : 0;
    const Vector3d from = before == 0 ? Vector3d::Zero() : points[before - 1];
    const Vector3d to = after == 0 ? Vector3d::Zero() : points[after - 1];
    const std::string name = "hinge_" + std::to_string(i);
    d.add_joint(name, "revolute", d.add_marker(before, name + "a", {R, points[i] - from}),
                d.add_marker(after, name + "b", {R, points[i] - to}));
  }
  Mechanism mechanism(d);
  const State s = mechanism.initial_state();
  const std::vector<RedundantRow> redundant = mechanism.drop_redundant(0.0, s.p);
  ASSERT_EQ(redundant.size(), 1u);
  EXPECT_FALSE(redundant[0].follows_from.empty());
  EXPECT_EQ(mechanism.sizes().n_v - mechanism.sizes().n_lambda, 1);
}

TEST(WindowedFourBar, AcceleratesByItsExactEquation) {
  // IFToMM benchmark A02 with N windows: 2 N + 1 uniform rods of 1 m and 1 kg; the uprights stay parallel, so
  // that th'' = -g W cos(th) / I with I = (N + 1) / 3 + N, W = (N + 1) / 2 + N.
  const int N = 3;
  const double th = 1.1, rate = -0.7;
  const RigidInertia rod =
      RigidInertia::from_center(1.0, {0.5, 0, 0}, Vector3d(0.0, 1.0 / 12, 1.0 / 12).asDiagonal());
  const Pose tip{Matrix3d::Identity(), {1, 0, 0}};
  MechanismDescription d;
  d.gravity = {0, -g_0, 0};
  std::vector<int> uprights;
  for (int k = 0; k <= N; ++k) {
    const std::string name = "upright_" + std::to_string(k);
    uprights.push_back(d.add_body({.name = name, .inertia = rod}));
    const int j =
        d.add_joint(name, "revolute", d.add_marker(0, name, {Matrix3d::Identity(), {1.0 * k, 0, 0}}),
                    d.add_marker(uprights.back(), "foot"));
    d.joints[j].initial_coordinates[0] = th;
    d.joints[j].initial_speeds[0] = rate;
  }
  for (int k = 1; k <= N; ++k) {
    const std::string name = "beam_" + std::to_string(k);
    const int beam = d.add_body({.name = name, .inertia = rod});
    const int j =
        d.add_joint(name, "revolute", d.add_marker(uprights[k - 1], name, tip), d.add_marker(beam, "left"));
    d.joints[j].initial_coordinates[0] = -th;
    d.joints[j].initial_speeds[0] = -rate;
    d.add_joint(name + "_right", "revolute", d.add_marker(beam, "right", tip),
                d.add_marker(uprights[k], name + "_end", tip));
  }
  Mechanism mechanism(d);
  State s = mechanism.initial_state();
  EXPECT_EQ(mechanism.drop_redundant(0.0, s.p).size(), 3u * N);
  const Sizes n = mechanism.sizes();
  EXPECT_EQ(n.n_v - n.n_lambda, 1);
  s.lambda = VectorXd::Zero(n.n_lambda);
  const auto scratch = mechanism.make_scratch();
  VectorXd g(n.n_lambda), bias(n.n_lambda);
  mechanism.position_constraints(0.0, s.p, *scratch, g);
  EXPECT_LE(g.cwiseAbs().maxCoeff(), 1e-15);
  mechanism.velocity_constraints(0.0, s.p, s.v, *scratch, g);
  EXPECT_LE(g.cwiseAbs().maxCoeff(), 1e-15);
  // [M G^T; G 0] (v', lambda) = (f, -gamma).
  MatrixXd KKT = MatrixXd::Zero(n.n_v + n.n_lambda, n.n_v + n.n_lambda), M(n.n_v, n.n_v),
           G(n.n_lambda, n.n_v);
  mechanism.mass_matrix(s.p, *scratch, M);
  mechanism.constraint_matrix(0.0, s.p, *scratch, G);
  mechanism.acceleration_constraints(0.0, s.p, s.v, VectorXd::Zero(n.n_v), *scratch, bias);
  KKT << M, G.transpose(), G, MatrixXd::Zero(n.n_lambda, n.n_lambda);
  VectorXd rhs(n.n_v + n.n_lambda);
  rhs << -momentum(mechanism, s, VectorXd::Zero(n.n_v)), -bias;
  const VectorXd x = Eigen::FullPivLU<MatrixXd>(KKT).solve(rhs);
  const double exact = -g_0 * ((N + 1) / 2.0 + N) * std::cos(th) / ((N + 1) / 3.0 + N);
  for (int i = 0; i < n.n_v; ++i)
    if (mechanism.name_of_velocity(i).starts_with("upright")) {
      EXPECT_NEAR(x(i), exact, 1e-12 * std::abs(exact)) << mechanism.name_of_velocity(i);
    }
}

TEST(Mechanism, RefusesWhatCannotStand) {
  const auto message = [](MechanismDescription d) -> std::string {
    try {
      Mechanism mechanism(std::move(d));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return {};
  };
  {
    MechanismDescription d;
    const int b = d.add_body({.name = "rod"});
    d.add_joint("j", "revolute", d.add_marker(b, "left"), d.add_marker(b, "right"));
    EXPECT_EQ(
        message(d),
        "joint \"j\" goes from \"rod.left\" to \"rod.right\", two markers of one body; a joint joins two "
        "bodies");
  }
  {
    MechanismDescription d;
    d.add_body({.name = "rod", .inertia = {.mass = -2.0}});
    EXPECT_EQ(message(d), "body \"rod\" has the mass -2 kg; a mass must not be negative");
  }
  {
    // A point mass on the axis of its hinge.
    MechanismDescription d;
    const int b = d.add_body({.name = "wheel", .inertia = {.mass = 2.0}});
    d.add_joint("hub", "revolute", d.add_marker(0, "hub"), d.add_marker(b, "hub"));
    EXPECT_EQ(message(d),
              "nothing with inertia moves along \"hub.speed\" alone; give body \"wheel\", or what hangs on "
              "it, mass or "
              "inertia");
  }
}

}  // namespace
}  // namespace flexura::mbs
