// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What contacts leave free, on contacts whose freedoms are known.
#include "import/cad/freedom.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace flexura::import::cad {
namespace {

using Eigen::Vector3d;
using Type = JointForm::Type;

// A shaft along z in a bore, radius 1, z from -1 to 1; `sector`: how much of the circle touches.
std::vector<Contact> bearing(double sector = 2.0 * std::numbers::pi) {
  std::vector<Contact> contacts;
  for (int k = 0; k < 36; ++k) {
    const double angle = sector * (k + 0.5) / 36.0;
    const Vector3d n(std::cos(angle), std::sin(angle), 0);
    for (const double z : {-1.0, 1.0}) contacts.push_back({n + Vector3d(0, 0, z), -n});
  }
  return contacts;
}

void add_plane(std::vector<Contact>& contacts, double z, double direction) {
  for (const auto& [x, y] : {std::pair{1.0, 0.0}, {-0.5, 0.8}, {-0.5, -0.8}})
    contacts.push_back({Vector3d(2 * x, 2 * y, z), Vector3d(0, 0, direction)});
}

struct Found {
  Eigen::Index kept, open;
  JointForm form;
};

// The same in a world that is turned and moved, so that no axis is one of its own.
Found found(std::vector<Contact> contacts) {
  const Eigen::AngleAxisd R(0.7, Vector3d(1, 2, -3).normalized());
  const Vector3d p(5, -7, 2);
  for (Contact& c : contacts) c = {R * c.p + p, R * c.n};
  const Eigen::MatrixXd kept = kept_freedom(contacts, p, 2.0);
  Found result{kept.cols(), open_freedom(contacts, p, 2.0).cols(), form_of(kept, p, 2.0)};
  result.form.point = R.inverse() * (result.form.point - p);
  result.form.axis = R.inverse() * result.form.axis;
  return result;
}

TEST(Freedom, ShaftInABoreTurnsAndSlides) {
  const Found f = found(bearing());
  EXPECT_EQ(f.kept, 2);
  EXPECT_EQ(f.open, 2);
  EXPECT_EQ(f.form.type, Type::cylindrical);
  EXPECT_NEAR(f.form.axis.cross(Vector3d::UnitZ()).norm(), 0.0, 1e-9);
  EXPECT_NEAR(f.form.point.head<2>().norm(), 0.0, 1e-9);
}

TEST(Freedom, ShouldersOnBothSidesMakeAHingeOnOneSideAnOpenOne) {
  auto contacts = bearing();
  add_plane(contacts, 1.0, 1.0);
  Found f = found(contacts);
  EXPECT_EQ(f.kept, 1);
  EXPECT_EQ(f.open, 2);
  EXPECT_EQ(f.form.type, Type::revolute);
  add_plane(contacts, -1.0, -1.0);
  f = found(contacts);
  EXPECT_EQ(f.kept, 1);
  EXPECT_EQ(f.open, 1);
  EXPECT_EQ(f.form.type, Type::revolute);
}

// Half a bearing (and less) lets the shaft out.
TEST(Freedom, HalfABearingHoldsFromOneSide) {
  const Found f = found(bearing(std::numbers::pi));
  EXPECT_EQ(f.kept, 2);
  EXPECT_GT(f.open, 2);
  // From 190 degrees on it is closed.
  EXPECT_EQ(found(bearing(190.0 / 180.0 * std::numbers::pi)).open, 2);
}

TEST(Freedom, BodyOnATableSlidesAndTurnsInItsPlaneAndLiftsOff) {
  std::vector<Contact> contacts;
  add_plane(contacts, 0.0, 1.0);
  const Found f = found(contacts);
  EXPECT_EQ(f.kept, 3);
  EXPECT_EQ(f.open, 6);
  EXPECT_EQ(f.form.type, Type::planar);
}

TEST(Freedom, BetweenTwoPlanesItCannotLift) {
  std::vector<Contact> contacts;
  add_plane(contacts, 0.0, 1.0);
  add_plane(contacts, 1.0, -1.0);
  EXPECT_EQ(found(contacts).open, 3);
}

TEST(Freedom, BallInItsSocketTurnsAboutItsCentre) {
  std::vector<Contact> contacts;
  for (int k = 0; k < 200; ++k) {  // a spiral over 60 % of the sphere's height
    const double z = -1.0 + 1.4 * k / 199.0, r = std::sqrt(std::max(0.0, 1.0 - z * z));
    const Vector3d n(r * std::cos(2.4 * k), r * std::sin(2.4 * k), z);
    contacts.push_back({n + Vector3d(0.3, 0, 0), -n});
  }
  const Found f = found(contacts);
  EXPECT_EQ(f.kept, 3);
  EXPECT_EQ(f.open, 3);
  EXPECT_EQ(f.form.type, Type::spherical);
  EXPECT_NEAR((f.form.point - Vector3d(0.3, 0, 0)).norm(), 0.0, 1e-9);
}

TEST(Freedom, SquareBarInASquareHoleSlides) {
  std::vector<Contact> contacts;
  for (const Vector3d& n : {Vector3d(1, 0, 0), Vector3d(-1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, -1, 0)})
    for (const double s : {-1.0, 1.0})
      for (const double z : {-3.0, 3.0})
        contacts.push_back({n + s * n.cross(Vector3d::UnitZ()) + Vector3d(0, 0, z), n});
  const Found f = found(contacts);
  EXPECT_EQ(f.kept, 1);
  EXPECT_EQ(f.open, 1);
  EXPECT_EQ(f.form.type, Type::prismatic);
  EXPECT_NEAR(f.form.axis.cross(Vector3d::UnitZ()).norm(), 0.0, 1e-9);
}

// min |A x - b|, x >= 0 where the free solution has x_2 < 0: on the face x_2 = 0.
TEST(Freedom, NonnegativeLeastSquaresStopsAtItsBounds) {
  Eigen::MatrixXd A(3, 2);
  A << 1, 1, 1, 2, 1, 3;
  const Eigen::Vector3d b(3, 2, 1);  // free: (4, -1)
  const Eigen::VectorXd x = nonnegative_least_squares(A, b);
  EXPECT_NEAR(x[0], 2.0, 1e-12);
  EXPECT_EQ(x[1], 0.0);
}

}  // namespace
}  // namespace flexura::import::cad
