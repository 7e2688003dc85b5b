// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/body.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <random>

#include "beam/ancf/ancf_kinematics.hpp"
#include "tests/beam/ancf/samples.hpp"

namespace flexura::beam::ancf {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

VectorXd random_vector(int n, double size, unsigned seed) {
  std::mt19937 source(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  VectorXd v(n);
  for (double& x : v) x = uniform(source);
  return v;
}

std::vector<AncfBody> all_bodies() {
  const LineSection line{
      .EA = 50, .EI = 3, .mass_per_length = 2, .damping_time_axial = 0.1, .damping_time_bending = 0.2};
  BeamSection beam = uncoupled_section(50, 20, 15, 2, 3, 4, 2.0, 0.05, 0.07);
  beam.damping_time = 0.1;
  const SolidSection solid{.E = 100, .nu = 0.3, .rho = 20, .width = 0.3, .height = 0.4, .damping_time = 0.1};
  std::vector<AncfBody> bodies;
  bodies.push_back(planar_line(line, quarter_circle(3)));
  bodies.push_back(spatial_line(line, straight_curve({0, 0, 0}, {1, 1, 1}, 3)));
  bodies.push_back(spatial_beam(beam, quarter_circle(3)));
  bodies.push_back(solid_beam(solid, straight_curve({0, 0, 0}, {0, 2, 0}, 3, {0, 0, 1})));
  return bodies;
}

TEST(AncfBody, TangentsAreForceGradients) {
  for (const AncfBody& body : all_bodies()) {
    const int n = body.n_q();
    const VectorXd q = body.rest() + random_vector(n, 0.1, 1), v = random_vector(n, 1.0, 2);
    auto scratch = body.make_scratch();
    BlockTridiagonal K(body.n_nodes(), body.node_coordinates()), D = K;
    VectorXd f(n), plus(n), minus(n), only_force(n);
    body.force_and_tangents(q, &v, scratch, f, K, D);
    body.force(q, &v, only_force);
    EXPECT_EQ(f, only_force);
    const MatrixXd K_exact = K.to_sparse(), D_exact = D.to_sparse();
    // Step and tolerance as for single elements (element_test.cpp).
    const double h = 1e-5;
    MatrixXd K_fd(n, n), D_fd(n, n);
    for (int i = 0; i < n; ++i) {
      const VectorXd q_p = q + h * VectorXd::Unit(n, i), q_m = q - h * VectorXd::Unit(n, i);
      body.force(q_p, &v, plus);
      body.force(q_m, &v, minus);
      K_fd.col(i) = (plus - minus) / (2 * h);
      const VectorXd v_p = v + h * VectorXd::Unit(n, i), v_m = v - h * VectorXd::Unit(n, i);
      body.force(q, &v_p, plus);
      body.force(q, &v_m, minus);
      D_fd.col(i) = (plus - minus) / (2 * h);
    }
    EXPECT_LT((K_fd - K_exact).cwiseAbs().maxCoeff(), 1e-7 * K_exact.cwiseAbs().maxCoeff());
    EXPECT_LT((D_fd - D_exact).cwiseAbs().maxCoeff(), 1e-7 * D_exact.cwiseAbs().maxCoeff());
  }
}

TEST(AncfBody, ExtrapolatedStressEntersTheTangentOnly) {
  // From the configuration itself the extrapolation is the stress itself; from elsewhere K changes and f does
  // not.
  for (const AncfBody& body : all_bodies()) {
    const int n = body.n_q();
    const VectorXd q = body.rest() + random_vector(n, 0.1, 1), before = q + random_vector(n, 0.1, 2);
    auto scratch = body.make_scratch();
    BlockTridiagonal K(body.n_nodes(), body.node_coordinates()), K_same = K, K_before = K, D = K;
    VectorXd f(n), f_same(n), f_before(n);
    body.force_and_tangents(q, nullptr, scratch, f, K, D);
    body.force_and_tangents(q, nullptr, scratch, f_same, K_same, D, &q);
    body.force_and_tangents(q, nullptr, scratch, f_before, K_before, D, &before);
    const MatrixXd reference = K.to_sparse();
    EXPECT_LT((MatrixXd(K_same.to_sparse()) - reference).norm(), 1e-14 * reference.norm());
    EXPECT_GT((MatrixXd(K_before.to_sparse()) - reference).norm(), 1e-4 * reference.norm());
    EXPECT_EQ(f, f_same);
    EXPECT_EQ(f, f_before);
  }
}

TEST(AncfBody, RestIsFreeOfForce) {
  for (const AncfBody& body : all_bodies()) {
    VectorXd f(body.n_q());
    body.force(body.rest(), nullptr, f);
    // Strains of round-off (1e-16 times coordinates of 2) by stiffnesses of 50 and slopes' shape functions of
    // 1/l < 5.
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(body.strain_energy(body.rest()), 1e-26);
  }
}

TEST(AncfBody, MassSolveInvertsTheMassMatrix) {
  for (const AncfBody& body : all_bodies()) {
    const VectorXd x = random_vector(body.n_q(), 1.0, 3);
    VectorXd y = VectorXd::Zero(body.n_q());
    body.mass().multiply_add(1.0, x, y);
    body.solve_mass(y);
    // Backward stable: eps times the condition number, which slopes of short elements take to about 1e4.
    EXPECT_LT((y - x).norm(), 1e-11 * x.norm());
  }
}

TEST(AncfBody, RigidMotionHasTheEnergyAndMomentumOfARigidBody) {
  // A straight beam of length 2 along x, m = 2 per length, spinning about z through its start and
  // translating.
  const BeamSection section = uncoupled_section(50, 20, 15, 2, 3, 4, 2.0, 0.05, 0.07);
  const AncfBody body = spatial_beam(section, straight_curve({0, 0, 0}, {2, 0, 0}, 4));
  const double w = 3.0;
  const Vector3d u(0.5, -1.0, 2.0);
  const VectorXd v = body.rigid_velocity(body.rest(), u, Vector3d(0, 0, w));
  const double mass = 4.0, J_z = mass * 4.0 / 3.0 + 0.07 * 2;  // about the start, with int y^2 dm
  const Vector3d centre(1, 0, 0), v_c = u + Vector3d(0, w, 0);
  const Vector3d angular = mass * centre.cross(u) + Vector3d(0, 0, J_z * w);
  const double energy = 0.5 * mass * u.squaredNorm() + mass * u.dot(Vector3d(0, w, 0)) + 0.5 * J_z * w * w;
  // Exact quadrature: round-off of some hundred terms.
  const Momentum p = body.momentum(body.rest(), v);
  EXPECT_NEAR(body.total_mass(), mass, 1e-13);
  EXPECT_LT((p.linear - mass * v_c).norm(), 1e-12);
  EXPECT_LT((p.angular - angular).norm(), 1e-12);
  EXPECT_NEAR(body.kinetic_energy(v), energy, 1e-12);
}

TEST(AncfBody, PlacedBodiesAreStillFreeOfForce) {
  for (const AncfBody& body : all_bodies()) {
    const bool planar = body.dim() == 2;
    const Vector3d axis = planar ? Vector3d::UnitZ() : Vector3d(1, -2, 0.5).normalized();
    const Eigen::Matrix3d R = Eigen::AngleAxisd(2.0, axis).toRotationMatrix();
    const Vector3d p(3, -1, planar ? 0 : 2), w = 4 * axis, u(1, 2, 0);
    const VectorXd q = body.placed(R, p), v = body.rigid_velocity(q, u, w);
    const VectorXd still = VectorXd::Zero(body.n_q());
    const MaterialPoint point = body.locate(0.3 * body.length());
    const auto rest = evaluate_point(body, point, body.rest(), still), at = evaluate_point(body, point, q, v);
    VectorXd f(body.n_q());
    body.force(q, &v, f);
    // Coordinates of 5 and rates of 20 in round-off, times stiffness 50, damping time < 1 and slopes' 1/l
    // < 5.
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((at.p_WoP_W - (p + R * rest.p_WoP_W)).norm(), 1e-13);
    EXPECT_LT((at.v_WP_W - (u + w.cross(at.p_WoP_W))).norm(), 1e-12);
    // The frame of a spatial line does not see a turn about its tangent.
    if (body.dim() == 2 || body.vectors() == 4) {
      EXPECT_LT((at.R_WS - R * rest.R_WS).norm(), 1e-13);
      EXPECT_LT((at.w_WS_W - w).norm(), 1e-12);
    }
  }
  EXPECT_THROW(all_bodies()[0].placed(Eigen::Matrix3d::Identity(), Vector3d(0, 0, 1)), std::invalid_argument);
}

TEST(AncfBody, GravityActsAtTheCentreOfMass) {
  for (const AncfBody& body : all_bodies()) {
    const Vector3d g(1.0, -9.8, body.dim() == 3 ? 0.3 : 0.0);
    const VectorXd f = body.gravity_force(g), v = random_vector(body.n_q(), 1.0, 4);
    // Power of gravity = g . linear momentum, for every motion.
    EXPECT_NEAR(f.dot(v), g.dot(body.momentum(body.rest(), v).linear), 1e-12);
  }
}

TEST(AncfBody, LocatesPointsByArcLength) {
  const auto bodies = all_bodies();
  const AncfBody& body = bodies[0];
  const double third = M_PI / 6;
  EXPECT_EQ(body.locate(0.0).element, 0);
  const MaterialPoint middle = body.locate(1.5 * third);
  EXPECT_EQ(middle.element, 1);
  EXPECT_NEAR(middle.xi, 0.5, 1e-14);
  EXPECT_EQ(body.locate(body.length()).element, 2);
  EXPECT_EQ(body.locate(body.length()).xi, 1.0);
  EXPECT_THAT([&] { body.locate(2.0); },
              testing::ThrowsMessage<std::invalid_argument>(testing::HasSubstr("2 m lies outside")));
}

TEST(AncfPoint, FrameVelocityAndJacobianBelongTogether) {
  for (const AncfBody& body : all_bodies()) {
    const int n = body.n_q();
    const VectorXd q = body.rest() + random_vector(n, 0.1, 5), v = random_vector(n, 1.0, 6);
    const MaterialPoint point = body.locate(0.55 * body.length());
    const auto at = evaluate_point(body, point, q, v);
    const double h = 1e-5;
    const auto plus = evaluate_point(body, point, q + h * v, v),
               minus = evaluate_point(body, point, q - h * v, v);
    const int n_e = 2 * body.node_coordinates();
    // Central differences of functions whose derivatives grow by factors of 10 at most: h^2 * 1e3 / 6 < 1e-7.
    EXPECT_LT((at.R_WS.transpose() * at.R_WS - Eigen::Matrix3d::Identity()).norm(), 1e-14);
    EXPECT_LT(((plus.p_WoP_W - minus.p_WoP_W) / (2 * h) - at.v_WP_W).norm(), 1e-9);
    const Eigen::Matrix3d spin = (plus.R_WS - minus.R_WS) / (2 * h) * at.R_WS.transpose();
    EXPECT_LT((Vector3d(spin(2, 1), spin(0, 2), spin(1, 0)) - at.w_WS_W).norm(), 1e-7);
    EXPECT_LT(((plus.w_WS_W - minus.w_WS_W) / (2 * h) - at.w_bias_W).norm(), 1e-7);
    EXPECT_LT((at.J_v * v.segment(at.first, n_e) - at.v_WP_W).norm(), 1e-13);
    EXPECT_LT((at.J_w * v.segment(at.first, n_e) - at.w_WS_W).norm(), 1e-13);
  }
}

TEST(AncfPoint, ForcesAndMomentsDoTheWorkOfTheirPoint) {
  for (const AncfBody& body : all_bodies()) {
    const int n = body.n_q();
    const VectorXd q = body.rest() + random_vector(n, 0.1, 7), v = random_vector(n, 1.0, 8);
    const MaterialPoint point = body.locate(0.4 * body.length());
    const auto at = evaluate_point(body, point, q, v);
    const Vector3d F(1, -2, 3), M(-2, 1, 4);
    VectorXd f = VectorXd::Zero(n), m = VectorXd::Zero(n);
    Triplets triplets;
    add_point_force(body, point, F, f);
    add_point_moment(body, point, q, M, m, &triplets);
    EXPECT_NEAR(f.dot(v), F.dot(at.v_WP_W), 1e-13 * 10);
    EXPECT_NEAR(m.dot(v), M.dot(at.w_WS_W), 1e-13 * 10);

    Eigen::SparseMatrix<double> exact(n, n);
    exact.setFromTriplets(triplets.begin(), triplets.end());
    const double h = 1e-5;
    MatrixXd difference(n, n);
    for (int i = 0; i < n; ++i) {
      VectorXd plus = VectorXd::Zero(n), minus = plus;
      add_point_moment(body, point, q + h * VectorXd::Unit(n, i), M, plus, nullptr);
      add_point_moment(body, point, q - h * VectorXd::Unit(n, i), M, minus, nullptr);
      difference.col(i) = (plus - minus) / (2 * h);
    }
    EXPECT_LT((difference - MatrixXd(exact)).cwiseAbs().maxCoeff(), 1e-7);
  }
}

TEST(AncfBlockTridiagonal, CholeskySolvesAndRefuses) {
  BlockTridiagonal A(4, 3);
  for (int k = 0; k < 3; ++k) {
    const MatrixXd B = random_vector(36, 1.0, 20 + k).reshaped(6, 6);
    A.add_element(k, B * B.transpose() + MatrixXd::Identity(6, 6));
  }
  BlockCholesky factor;
  factor.factor(A);
  VectorXd x = random_vector(12, 1.0, 9);
  const VectorXd expected = MatrixXd(A.to_sparse()).partialPivLu().solve(x);
  factor.solve(x);
  EXPECT_LT((x - expected).norm(), 1e-13 * expected.norm());
  A.block(2, 2)(0, 0) = -1.0;
  EXPECT_THAT([&] { factor.factor(A); }, testing::ThrowsMessage<std::runtime_error>(
                                             testing::HasSubstr("not positive definite at node 2")));
}

TEST(AncfBody, RefusesCurvesThatMakeNoBeam) {
  using testing::HasSubstr;
  using testing::ThrowsMessage;
  const LineSection line{.EA = 50, .EI = 3, .mass_per_length = 2};
  EXPECT_THAT(
      [&] {
        straight_curve({1, 1, 1}, {1, 1, 1}, 2);
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("coincide")));
  EXPECT_THAT(
      [&] {
        straight_curve({0, 0, 0}, {0, 1, 0}, 2);
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("y axis lies along")));
  EXPECT_THAT(
      [&] {
        planar_line(line, straight_curve({0, 0, 0}, {0, 0, 1}, 2));
      },
      ThrowsMessage<std::invalid_argument>(HasSubstr("outside the x-y plane")));
}

}  // namespace
}  // namespace flexura::beam::ancf
