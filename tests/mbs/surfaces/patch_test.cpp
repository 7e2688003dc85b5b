// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <set>

#include "mbs/kinematics/surface_patch.hpp"
#include "tests/mbs/model/checks.hpp"

/// The tree over a deformed surface against a look at every node.
namespace flexura::mbs {
namespace {

using checks::Random;

/// A cloud of n nodes with m random shapes that vary slowly over it.
struct Cloud {
  Eigen::Matrix3Xd x;
  Eigen::MatrixXd Phi;
  SurfacePatch patch;
  Cloud(int n, int m) : x(points(n)), Phi(shapes(x, m)), patch(x, Eigen::VectorXd::Constant(n, 2.0)) {
    patch.set_shapes(Phi);
  }
  Vector3d place(int given, const Eigen::VectorXd& s) const {
    return x.col(given) + Phi.middleRows<3>(3 * given) * s;
  }
  static Eigen::Matrix3Xd points(int n) {
    Random random(5);
    Eigen::Matrix3Xd x(3, n);
    for (int j = 0; j < n; ++j) x.col(j) = random.vector3();
    return x;
  }
  static Eigen::MatrixXd shapes(const Eigen::Matrix3Xd& x, int m) {
    Random random(6);
    Eigen::MatrixXd Phi(3 * x.cols(), m);
    for (int i = 0; i < m; ++i) {
      const Vector3d a = random.vector3(), k = random.vector3(2.0);
      for (Eigen::Index j = 0; j < x.cols(); ++j)
        Phi.col(i).segment<3>(3 * j) = a * std::sin(k.dot(x.col(j)) + i);
    }
    return Phi;
  }
};

TEST(SurfacePatch, FindsAllNodesThatAreThere) {
  const Cloud cloud(700, 5);
  EXPECT_DOUBLE_EQ(cloud.patch.total_area(), 1400.0);
  for (unsigned seed = 0; seed < 6; ++seed) {
    Random random(seed);
    const Eigen::VectorXd s = random.vector(5, 0.4);
    const Vector3d n = random.vector3().normalized();
    const double level = random(-1.0, 0.2);
    std::set<int> found, wanted;
    cloud.patch.visit(
        s.data(), [&](const Vector3d& c, double r) { return n.dot(c) - level < r; },
        [&](int j, const Vector3d& rho) {
          EXPECT_LT((rho - cloud.place(cloud.patch.given(j), s)).norm(), 1e-14);
          if (n.dot(rho) < level) found.insert(cloud.patch.given(j));
        });
    double least = 1e9;
    for (int j = 0; j < 700; ++j) {
      const double height = n.dot(cloud.place(j, s));
      least = std::min(least, height);
      if (height < level) wanted.insert(j);
    }
    EXPECT_EQ(found, wanted);
    EXPECT_NEAR(cloud.patch.least(s.data(), [&](const Vector3d& rho) { return n.dot(rho); }).value, least,
                1e-14);
  }
}

TEST(SurfacePatch, StandsUndeformedWithoutCoordinates) {
  const Cloud cloud(50, 2);
  int count = 0;
  cloud.patch.visit(
      nullptr, [](const Vector3d&, double) { return true; },
      [&](int j, const Vector3d& rho) {
        ++count;
        EXPECT_EQ(rho, Vector3d(cloud.x.col(cloud.patch.given(j))));
      });
  EXPECT_EQ(count, 50);
  EXPECT_THROW(SurfacePatch(cloud.x, Eigen::VectorXd::Ones(50)).set_shapes(Eigen::MatrixXd::Ones(9, 2)),
               std::invalid_argument);
}

// What is looked at follows what touches: a plane that a corner of a grid of 40,000 nodes dips into.
TEST(SurfacePatch, LooksAtWhatTouchesAndLittleElse) {
  constexpr int n = 200;
  Eigen::Matrix3Xd x(3, n * n);
  Eigen::MatrixXd Phi(3 * n * n, 2);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      x.col(i * n + j) << i / 200.0, j / 200.0, 0.0;
      Phi.middleRows<3>(3 * (i * n + j)) << Eigen::MatrixXd::Zero(2, 2),
          Eigen::RowVector2d(std::sin(i / 70.0), std::cos(j / 90.0));
    }
  SurfacePatch patch(x, Eigen::VectorXd::Ones(n * n));
  patch.set_shapes(Phi);
  const Eigen::Vector2d s(0.02, -0.01);
  const Vector3d normal = Vector3d(0.3, 0.4, 1.0).normalized();
  for (const double level : {0.0, 0.02}) {
    int balls = 0, nodes = 0, touching = 0;
    patch.visit(
        s.data(),
        [&](const Vector3d& c, double r) {
          ++balls;
          return normal.dot(c) - level < r;
        },
        [&](int, const Vector3d& rho) {
          ++nodes;
          touching += normal.dot(rho) < level;
        });
    EXPECT_LT(balls + nodes, 300 + 6 * touching) << touching << " touch";
    EXPECT_EQ(touching > 0, level > 0.0 || touching > 0);
  }
}

}  // namespace
}  // namespace flexura::mbs
