// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Distances of deformable surfaces against closed forms and against FCL's of the same triangles.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "mbs/kinematics/surface_mesh.hpp"
#include "mbs/proximity/surface.hpp"

namespace flexura::proximity {
namespace {

using mbs::SurfaceMesh;

// A box of nodes in layers along z, so that it can bend.
struct Bar {
  Eigen::Matrix3Xd x;
  Eigen::Matrix3Xi f;
};

Bar bar(double w, double h, double length, int layers) {
  Bar out;
  out.x.resize(3, 4 * (layers + 1));
  for (int k = 0; k <= layers; ++k)
    for (int i = 0; i < 4; ++i)
      out.x.col(4 * k + i) = Vector3d(i == 1 || i == 2 ? w : -w, i >= 2 ? h : -h, length * k / layers);
  std::vector<Eigen::Vector3i> f = {{0, 2, 1}, {0, 3, 2}};
  const int top = 4 * layers;
  f.emplace_back(top, top + 1, top + 2);
  f.emplace_back(top, top + 2, top + 3);
  for (int k = 0; k < layers; ++k)
    for (int i = 0; i < 4; ++i) {
      const int a = 4 * k + i, b = 4 * k + (i + 1) % 4;
      f.emplace_back(a, b, b + 4);
      f.emplace_back(a, b + 4, a + 4);
    }
  out.f.resize(3, static_cast<Eigen::Index>(f.size()));
  for (std::size_t t = 0; t < f.size(); ++t) out.f.col(static_cast<Eigen::Index>(t)) = f[t];
  return out;
}

TEST(MeshDistance, OfCornersEdgesAndFacesIsExact) {
  const Bar b = bar(1, 1, 2, 3);
  const SurfaceMesh mesh(b.x, b.f);
  const auto gap = [&](const Pose& X) {
    return SurfaceMesh::between(mesh, nullptr, mesh, nullptr, X).distance;
  };
  Pose X;
  X.p = Vector3d(5, 0.3, 0.2);
  EXPECT_NEAR(gap(X), 3.0, 1e-14);  // faces
  X.p = Vector3d(5, 6, 0);
  EXPECT_NEAR(gap(X), 5.0, 1e-14);  // edges along z: 3, 4
  X.p = Vector3d(4, 5, 2 + 6);
  EXPECT_NEAR(gap(X), 7.0, 1e-14);  // corners: 2, 3, 6
  // An edge over a face: the upper bar lies along y, turned by 45 degrees about it.
  X.R = (Eigen::AngleAxisd(0.25 * M_PI, Vector3d::UnitY()) * Eigen::AngleAxisd(0.5 * M_PI, Vector3d::UnitX()))
            .toRotationMatrix();
  X.p = Vector3d(0, 1, 2 + std::sqrt(2.0) + 0.25);
  EXPECT_NEAR(gap(X), 0.25, 1e-14);
  X.p.z() -= 0.3;
  EXPECT_EQ(gap(X), 0.0);
}

TEST(MeshDistance, IsThatOfFclInAnyPose) {
  const Bar a = bar(0.3, 0.2, 2, 7), b = bar(0.1, 0.5, 1, 4);
  const SurfaceMesh mesh_a(a.x, a.f), mesh_b(b.x, b.f);
  const Surface surface_a(a.x, a.f), surface_b(b.x, b.f);
  std::srand(5);
  int apart = 0;
  for (int k = 0; k < 200; ++k) {
    Pose X;
    X.R = Eigen::Quaterniond(Eigen::Vector4d::Random().normalized()).toRotationMatrix();
    X.p = 2.0 * Vector3d::Random();
    const Gap fcl = gap_between(surface_a, Pose{}, surface_b, X);
    const SurfaceMesh::Gap own = SurfaceMesh::between(mesh_a, nullptr, mesh_b, nullptr, X);
    // FCL's distance of triangles is right to round-off of lengths of one.
    EXPECT_NEAR(own.distance, fcl.distance, 1e-9) << k;
    if (own.distance == 0.0) continue;
    ++apart;
    EXPECT_NEAR((own.p_A - own.p_B).norm(), own.distance, 1e-14);
  }
  EXPECT_GT(apart, 100);
}

// Balls of the tree that are not refitted must not hide what came near: the bent surface against one built in that shape.
TEST(MeshDistance, FollowsTheModes) {
  const Bar a = bar(0.05, 0.05, 2, 20), b = bar(0.2, 0.2, 0.4, 2);
  SurfaceMesh bends(a.x, a.f);
  const SurfaceMesh block(b.x, b.f);
  Eigen::MatrixXd Phi = Eigen::MatrixXd::Zero(3 * a.x.cols(), 2);
  for (Eigen::Index j = 0; j < a.x.cols(); ++j) {
    Phi(3 * j, 0) = a.x(2, j) * a.x(2, j);
    Phi(3 * j + 1, 1) = std::sin(a.x(2, j));
  }
  bends.set_shapes(Phi);
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector2d s = 0.3 * Eigen::Vector2d::Random();
    Eigen::Matrix3Xd x = a.x;
    for (Eigen::Index j = 0; j < x.cols(); ++j) x.col(j) += Phi.middleRows<3>(3 * j) * s;
    Pose X;
    X.p = Vector3d(1, 0.4, 1.5) + 0.5 * Vector3d::Random();
    EXPECT_NEAR(SurfaceMesh::between(bends, s.data(), block, nullptr, X).distance,
                SurfaceMesh::between(SurfaceMesh(x, a.f), nullptr, block, nullptr, X).distance, 1e-14);
  }
}

}  // namespace
}  // namespace flexura::proximity
