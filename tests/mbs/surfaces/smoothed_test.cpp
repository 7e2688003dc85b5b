// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "mbs/kinematics/smoothed_surface.hpp"
#include "tests/mbs/model/checks.hpp"

/// The smoothed surface of facets: where it stands, how it ends, and its derivatives against differences.
namespace flexura::mbs {
namespace {

using checks::Random;
using Foot = TouchedSurface::Foot;

/// (n + 1)^2 vertices over the square of half side 1, as z(x, y) lifts them, within it moved by `shaken` of a square's side; coordinate
/// 3 j + i moves vertex j along axis i.
template <class Height>
std::shared_ptr<SurfaceMesh> grid(int n, const Height& z, double shaken = 0.0) {
  Random random(8);
  const int k = n + 1;
  Eigen::Matrix3Xd x(3, k * k);
  Eigen::Matrix3Xi facets(3, 2 * n * n);
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < k; ++j) {
      Vector3d p(2.0 * i / n - 1.0, 2.0 * j / n - 1.0, 0.0);
      const bool is_inside = i > 0 && j > 0 && i < n && j < n;
      if (is_inside) p += 2.0 * shaken / n * Vector3d(random(), random(), 0.0);
      p.z() = z(p.x(), p.y());
      x.col(i * k + j) = p;
    }
  for (int i = 0, t = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const int p = i * k + j, q = p + k;
      facets.col(t++) << p, q, p + 1;
      facets.col(t++) << p + 1, q, q + 1;
    }
  auto mesh = std::make_shared<SurfaceMesh>(x, facets);
  mesh->set_shapes(Eigen::MatrixXd::Identity(3 * k * k, 3 * k * k));
  return mesh;
}

double flat(double, double) {
  return 0.0;
}
double bowl(double x, double y) {
  return 0.3 * x * x - 0.2 * x * y + 0.1 * std::sin(3.0 * y);
}

TEST(SmoothedSurface, IsThePlaneWhereFacetsLieInOne) {
  for (const double shaken : {0.0, 0.3}) {
    const auto mesh = grid(8, flat, shaken);
    const SmoothedSurface surface(mesh);
    Random random(1);
    Foot foot;
    for (int i = 0; i < 50; ++i) {
      const Vector3d p(random(), random(), random(-0.05, 0.0));
      ASSERT_TRUE(surface.find_foot(p, nullptr, false, foot));
      EXPECT_NEAR(foot.gap, p.z(), 1e-15);
      EXPECT_LT((foot.gap_z.head<3>() - Vector3d::UnitZ()).norm(), 1e-14);
      EXPECT_NEAR(foot.share.sum(), 1.0, 1e-14);
      // On the square, its corners and edges included, all of it is there.
      EXPECT_EQ(foot.cover, 1.0) << p.transpose();
      EXPECT_NEAR(surface.separation(p, nullptr), p.z(), 1e-15);
    }
  }
}

// A square beyond the edge nothing is left, and up to there nothing jumps.
TEST(SmoothedSurface, EndsWithinAFacet) {
  const SmoothedSurface surface(grid(8, flat));
  const double side = 0.25, reach = 2.0 * side * std::sqrt(5.0) / 3.0;
  Foot foot;
  double before = 1.0;
  for (double beyond = 0.0; beyond < 2.0 * side; beyond += 0.001) {
    const Vector3d p(1.0 + beyond, 0.3, -0.01);
    const double cover = surface.find_foot(p, nullptr, false, foot) ? foot.cover : 0.0;
    EXPECT_LE(cover, before + 1e-15);
    EXPECT_GT(cover, before - 0.03);
    // From the row of facets at the edge: a third of a side within.
    if (beyond > reach) EXPECT_EQ(cover, 0.0);
    EXPECT_EQ(surface.separation(p, nullptr) < 0.0, cover > 0.0) << beyond;
    before = cover;
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_GT(surface.separation({3.0, 0.0, -0.5}, nullptr), 1.5);
  EXPECT_GE(surface.separation({0.0, 0.0, 1.0}, nullptr), 1.0 - 1e-15);
}

// On a sphere of the radius R facets of the side h: the zero within 0.1 h^2 / R of it, curved as it is in the mean.
TEST(SmoothedSurface, IsRoundWhereFacetsApproachASphere) {
  const double R = 3.0;
  const SmoothedSurface surface(
      grid(10, [&](double x, double y) { return std::sqrt(R * R - x * x - y * y) - R; }));
  const double h = 0.2;
  Random random(2);
  Foot foot;
  double mean = 0.0;
  for (int i = 0; i < 200; ++i) {
    const Vector3d centre(0.0, 0.0, -R),
        p = centre + (R - 0.01) * (Vector3d(0.5 * random(), 0.5 * random(), 2.0).normalized());
    ASSERT_TRUE(surface.find_foot(p, nullptr, true, foot));
    EXPECT_NEAR(foot.gap, -0.01, 0.1 * h * h / R);
    EXPECT_LT((foot.gap_z.head<3>() - (p - centre).normalized()).norm(), 0.1 * h / R);
    mean += foot.gap_zz.topLeftCorner<3, 3>().trace() / 200.0;
  }
  EXPECT_NEAR(mean, 2.0 / R, 0.2 / R);
}

/// All that a foot says against central differences by p and by the vertices.
void derivatives_agree(const SmoothedSurface& surface, const Vector3d& p) {
  const int m = surface.m();
  Random random(4);
  const Eigen::VectorXd s = random.vector(m, 0.03);
  Foot foot;
  ASSERT_TRUE(surface.find_foot(p, s.data(), true, foot));
  const int n = foot.n();
  const double h = 1e-5;
  // Differences err by h^2 of third derivatives over the reach of 0.3 and by 1e-16 / h.
  const double first = 1e-8, second = 1e-7;
  for (int j = 0; j < n; ++j) {
    Foot sides[2];
    for (int side = 0; side < 2; ++side) {
      Vector3d q = p;
      Eigen::VectorXd u = s;
      const double step = side == 0 ? h : -h;
      if (j < 3)
        q(j) += step;
      else
        u(3 * foot.vertices[static_cast<std::size_t>((j - 3) / 3)] + (j - 3) % 3) += step;
      ASSERT_TRUE(surface.find_foot(q, u.data(), true, sides[side]));
      ASSERT_EQ(sides[side].vertices, foot.vertices);
    }
    const Foot &f = sides[0], &g = sides[1];
    const auto differ = [&](const Eigen::VectorXd& one, const Eigen::VectorXd& other, const auto& column) {
      return ((one - other) / (2.0 * h) - column).cwiseAbs().maxCoeff();
    };
    EXPECT_NEAR((f.gap - g.gap) / (2.0 * h), foot.gap_z(j), first);
    EXPECT_LT(differ(f.gap_z, g.gap_z, foot.gap_zz.col(j)),
              second * (1.0 + foot.gap_zz.cwiseAbs().maxCoeff()));
    EXPECT_LT(differ(f.share, g.share, foot.share_z.col(j)), second);
    if (!foot.is_at_end) continue;
    EXPECT_NEAR((f.cover - g.cover) / (2.0 * h), foot.cover_z(j), second * (1.0 + std::abs(foot.cover_z(j))));
    EXPECT_LT(differ(f.cover_z, g.cover_z, foot.cover_zz.col(j)),
              1e-6 * (1.0 + foot.cover_zz.cwiseAbs().maxCoeff()));
  }
  // Blind to a common motion: forces along gradients balance.
  for (const Eigen::VectorXd* gradient : {&foot.gap_z, &foot.cover_z}) {
    if (gradient == &foot.cover_z && !foot.is_at_end) continue;
    Vector3d sum = gradient->head<3>(), moment = p.cross(sum);
    for (std::size_t k = 0; k < foot.vertices.size(); ++k) {
      const Vector3d f = gradient->segment<3>(3 + 3 * static_cast<Eigen::Index>(k));
      sum += f;
      moment += surface.mesh().vertex(foot.vertices[k], s.data()).cross(f);
    }
    EXPECT_LT(sum.norm(), 1e-13);
    EXPECT_LT(moment.norm(), 1e-13);
  }
}

TEST(SmoothedSurface, HasTheDerivativesOfItsGap) {
  const SmoothedSurface surface(grid(8, bowl, 0.2));
  for (const Vector3d& at : {Vector3d(0.1, 0.2, 0.0), Vector3d(-0.61, 0.33, 0.0)})
    derivatives_agree(surface, {at.x(), at.y(), bowl(at.x(), at.y()) - 0.05});
}

TEST(SmoothedSurface, HasTheDerivativesOfItsEnd) {
  const SmoothedSurface surface(grid(8, flat, 0.2));
  Foot foot;
  const Vector3d p(1.12, 0.2, -0.08);
  ASSERT_TRUE(surface.find_foot(p, nullptr, false, foot));
  ASSERT_TRUE(foot.is_at_end);
  derivatives_agree(surface, p);
}

// The tree finds what a look at everything finds, deformed as well.
TEST(SmoothedSurface, BoundsWhatIsFar) {
  const SmoothedSurface surface(grid(12, bowl));
  Random random(9);
  const Eigen::VectorXd s = random.vector(surface.m(), 0.05);
  const double infinity = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 100; ++i) {
    const Vector3d c = random.vector3(3.0);
    const double bound = surface.bound(c, s.data(), infinity);
    EXPECT_LE(bound, surface.separation(c, s.data()) + 1e-14);
    for (int j = 0; j < 5; ++j) {
      const Vector3d off = random.vector3(0.5);
      EXPECT_GE(surface.separation(c + off, s.data()), bound - off.norm() - 1e-14);
    }
    EXPECT_GE(surface.bound(c, s.data(), 0.5), std::min(0.5, bound) - 1e-14);
  }
}

TEST(SmoothedSurface, KnowsSidesThatLookAway) {
  EXPECT_EQ(SmoothedSurface(grid(6, bowl)).opposed().first, -1);
  // Two sides of a sheet, thinner than its facets are long.
  Eigen::Matrix3Xd x(3, 6);
  x << 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, -0.1, -0.1, -0.1;
  Eigen::Matrix3Xi facets(3, 2);
  facets << 0, 3, 1, 5, 2, 4;
  EXPECT_NE(SmoothedSurface(std::make_shared<SurfaceMesh>(x, facets)).opposed().first, -1);
}

}  // namespace
}  // namespace flexura::mbs
