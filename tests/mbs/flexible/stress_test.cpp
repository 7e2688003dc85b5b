// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/bodies/section_points.hpp"
#include "mbs/bodies/stress_field.hpp"

namespace flexura::mbs {
namespace {

TEST(VonMises, OfSimpleStates) {
  EXPECT_DOUBLE_EQ(von_mises((Stress() << -7, 0, 0, 0, 0, 0).finished()), 7.0);
  EXPECT_DOUBLE_EQ(von_mises((Stress() << 5, 5, 5, 0, 0, 0).finished()), 0.0);
  EXPECT_NEAR(von_mises((Stress() << 0, 0, 0, 0, 2, 0).finished()), 2.0 * std::sqrt(3.0), 1e-15);
}

TEST(StressField, FindsTheLargestAndTheNearestPlace) {
  // Two places, three shapes, two modes; the second place carries twice the pull of the first.
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(12, 3), Y = Eigen::MatrixXd::Zero(3, 2);
  S(0, 0) = 1e6;
  S(6, 0) = 2e6;
  S(3, 2) = 5e6;
  Y(0, 0) = Y(2, 1) = 1.0;
  Eigen::Matrix3Xd x(3, 2);
  x << 0, 1, 0, 0, 0, 0;
  StressField field(S, x, {4, 9}, Y);
  const double s[2] = {2.0, 0.0}, twisted[2] = {0.0, 1.0};
  const auto largest = field.largest(s);
  EXPECT_DOUBLE_EQ(largest.von_mises, 4e6);
  EXPECT_EQ(field.vertex(largest.place), 9);
  EXPECT_NEAR(field.largest(twisted).von_mises, 5e6 * std::sqrt(3.0), 1e-8);
  field.add_point("middle", {0.4, 0.0, 0.3});
  EXPECT_EQ(field.points()[0].place, 0);
  EXPECT_DOUBLE_EQ(field.points()[0].distance, 0.5);
  EXPECT_DOUBLE_EQ(field.at(0, twisted)(3), 5e6);
  EXPECT_THROW(StressField(S, x, {4}, Y), std::invalid_argument);
  // Hooke's law of each place's material: E = 2e11, nu = 0.3, and a second one twice as soft.
  EXPECT_FALSE(field.has_strain());
  Eigen::Matrix<double, 6, 6> steel = Eigen::Matrix<double, 6, 6>::Zero();
  steel.topLeftCorner<3, 3>().setConstant(-0.3 / 2e11);
  steel.diagonal() << 5e-12, 5e-12, 5e-12, 1.3e-11, 1.3e-11, 1.3e-11;
  EXPECT_THROW(field.set_compliance({steel}, {0, 1}), std::invalid_argument);
  field.set_compliance({steel, 2.0 * steel}, {0, 1});
  const Strain pulled = field.strain_at(1, s);
  EXPECT_NEAR(pulled(0), 2.0 * 4e6 / 2e11, 1e-18);
  EXPECT_NEAR(pulled(2), -0.3 * pulled(0), 1e-18);
  EXPECT_NEAR(field.strain_at(0, twisted)(3), 5e6 * 1.3e-11, 1e-18);
}

// Of a file that does not know what bears within a member.
TEST(SectionPoints, TakeTheNearestPlaceWhereThatIsAllThatIsKnown) {
  superelement::SectionForces forces;
  forces.members = {"beam"};
  forces.member = {0, 0};
  forces.axes.resize(2, 9);
  forces.axes << 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1;
  forces.positions.resize(2, 3);
  forces.positions << 0.0, 0.0, 0.0, 1.0, 0.0, 0.0;
  forces.S = Eigen::MatrixXd::Zero(12, 3);
  forces.S(0, 0) = 100.0;  // N of the first place
  forces.S(11, 2) = 7.0;   // M_z of the second
  ModalData body;
  body.Y = Eigen::MatrixXd::Zero(3, 2);
  body.Y(0, 0) = body.Y(2, 1) = 1.0;
  body.stiffness = Eigen::Vector2d(1.0, 1.0);
  body.damping = Eigen::Vector2d::Zero();
  SectionPoints points(forces, body);
  ASSERT_EQ(points.nearest({0.1, 0.2, 0.0}).size(), 1u);
  EXPECT_NEAR(points.nearest({0.1, 0.2, 0.0})[0].distance, 0.2, 1e-15);
  points.add_point({.name = "root", .member = 0, .share = 0.1});
  points.add_point({.name = "tip", .member = 0, .share = 0.9});
  EXPECT_NEAR(points.points()[0].distance, 0.1, 1e-15);
  EXPECT_FALSE(points.is_whole());
  const double s[2] = {3.0, 2.0}, at_rest[2] = {0.0, 0.0};
  const BodyMotion motion{.s = s, .s_dot = at_rest, .s_ddot = at_rest};
  EXPECT_DOUBLE_EQ(points.at(0, motion)(0), 300.0);
  EXPECT_DOUBLE_EQ(points.at(0, motion)(5), 0.0);
  EXPECT_DOUBLE_EQ(points.at(1, motion)(5), 14.0);
}

}  // namespace
}  // namespace flexura::mbs
