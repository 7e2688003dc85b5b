// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Distances and overlaps of boxes and spheres, whose exact values are known.
#include "mbs/proximity/surface.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "mbs/base/math/rotation.hpp"

namespace flexura::proximity {
namespace {

struct Drawn {
  Eigen::Matrix3Xd x;
  Eigen::Matrix3Xi f;
};

Drawn box(const Vector3d& size) {
  Drawn out;
  out.x.resize(3, 8);
  for (int i = 0; i < 8; ++i)
    out.x.col(i) =
        0.5 * Vector3d((i & 1 ? 1 : -1) * size.x(), (i & 2 ? 1 : -1) * size.y(), (i & 4 ? 1 : -1) * size.z());
  out.f.resize(3, 12);
  out.f << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  //
      2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,       //
      3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
  return out;
}

// Rings of latitude; corners on the sphere.
Drawn sphere(double r, int n) {
  Drawn out;
  std::vector<Vector3d> x = {{0, 0, -r}, {0, 0, r}};
  std::vector<Eigen::Vector3i> f;
  const auto at = [&](int ring, int i) { return 2 + (ring - 1) * 2 * n + i % (2 * n); };
  for (int ring = 1; ring < n; ++ring)
    for (int i = 0; i < 2 * n; ++i) {
      const double theta = std::numbers::pi * ring / n, phi = std::numbers::pi * i / n;
      x.emplace_back(r * std::sin(theta) * std::cos(phi), r * std::sin(theta) * std::sin(phi),
                     -r * std::cos(theta));
    }
  for (int i = 0; i < 2 * n; ++i) {
    f.emplace_back(0, at(1, i + 1), at(1, i));
    f.emplace_back(1, at(n - 1, i), at(n - 1, i + 1));
    for (int ring = 1; ring + 1 < n; ++ring) {
      f.emplace_back(at(ring, i), at(ring, i + 1), at(ring + 1, i + 1));
      f.emplace_back(at(ring, i), at(ring + 1, i + 1), at(ring + 1, i));
    }
  }
  out.x.resize(3, static_cast<Eigen::Index>(x.size()));
  for (std::size_t i = 0; i < x.size(); ++i) out.x.col(static_cast<Eigen::Index>(i)) = x[i];
  out.f.resize(3, static_cast<Eigen::Index>(f.size()));
  for (std::size_t i = 0; i < f.size(); ++i) out.f.col(static_cast<Eigen::Index>(i)) = f[i];
  return out;
}

Surface surface(const Drawn& d) {
  return Surface(d.x, d.f);
}

TEST(Surface, DistanceOfTurnedBoxesIsThatOfCornerAndPlane) {
  const Surface a = surface(box({2, 2, 2})), b = surface(box({1, 1, 1}));
  // A cube that stands on its corner: half its space diagonal below its middle.
  const Vector3d axis = Vector3d(1, 1, 1).normalized();
  const Eigen::Matrix3d R = Eigen::Quaterniond::FromTwoVectors(axis, Vector3d::UnitZ()).toRotationMatrix();
  const Gap gap = gap_between(a, {}, b, {R, {0.2, -0.1, 3.0}});
  EXPECT_NEAR(gap.distance, 3.0 - 0.5 * std::sqrt(3.0) - 1.0, 1e-12);
  EXPECT_LT((gap.p_W_A - Vector3d(0.2, -0.1, 1.0)).norm(), 1e-9);
  EXPECT_LT((gap.p_W_B - Vector3d(0.2, -0.1, 3.0 - 0.5 * std::sqrt(3.0))).norm(), 1e-9);
  EXPECT_FALSE(overlap_of(a, {}, b, {R, {0.2, -0.1, 3.0}}));
}

TEST(Surface, OneBoxInTheTopOfAnother) {
  const Surface a = surface(box({2, 2, 2})), b = surface(box({0.5, 0.6, 1}));
  const auto overlap = overlap_of(a, {}, b, {mbs::rotation_exp({0, 0, 0.4}), {0.1, 0.2, 1.3}});
  ASSERT_TRUE(overlap && overlap->depth);
  EXPECT_NEAR(*overlap->depth, 0.2, 1e-12);  // its lower side stands at 0.8, as do its corners
  EXPECT_GE(overlap->p_W.z(), 0.8 - 1e-12);  // there, or on the top of the other, as deep in this one
  EXPECT_LE(overlap->p_W.z(), 1.0 + 1e-12);
  EXPECT_EQ(gap_between(a, {}, b, {Eigen::Matrix3d::Identity(), {0.1, 0.2, 1.3}}).distance, 0.0);
}

// No corner of either lies in the other.  Bars of side 2 whose axes are 1 apart: the lower side of the upper one stands 1 below the
// top of the other and 1 above its bottom, in the middle also 1 from its sides.
TEST(Surface, BarsThatCrossHaveADepthWithoutAnyCornerInside) {
  const Surface bar = surface(box({20, 2, 2}));
  const auto overlap =
      overlap_of(bar, {}, bar, {mbs::rotation_exp({0, 0, 0.5 * std::numbers::pi}), {0.3, -0.2, 1.0}});
  ASSERT_TRUE(overlap && overlap->depth);
  EXPECT_NEAR(*overlap->depth, 1.0, 0.02);
}

TEST(Surface, WhatLiesWithinOverlapsAndWhatLiesInAHollowDoesNot) {
  const Surface big = surface(sphere(1.0, 16)), small = surface(box({0.2, 0.2, 0.2}));
  const auto within = overlap_of(big, {}, small, {Eigen::Matrix3d::Identity(), {0.1, 0, 0}});
  ASSERT_TRUE(within && within->depth);
  // The middle of the side at x = 0 is the sphere's; its facets stand off by half a per cent.
  EXPECT_NEAR(*within->depth, 1.0, 0.03);
  // A hollow sphere: the inner one looks inwards.
  const Drawn outer = sphere(2.0, 16), inner = sphere(1.0, 16);
  Drawn shell;
  shell.x.resize(3, outer.x.cols() + inner.x.cols());
  shell.x << outer.x, inner.x;
  shell.f.resize(3, outer.f.cols() + inner.f.cols());
  shell.f << outer.f, (inner.f.array() + static_cast<int>(outer.x.cols())).matrix().colwise().reverse();
  EXPECT_FALSE(overlap_of(surface(shell), {}, small, {Eigen::Matrix3d::Identity(), {0.1, 0, 0}}));
}

TEST(Surface, FacetsOfARoundSurfaceStandOffByTheSagitta) {
  // The widest facets of rings at the equator: chords of the angle pi / n.
  const int n = 24;
  const Surface ball = surface(sphere(1.0, n));
  const double sagitta = 1.0 - std::cos(0.5 * std::numbers::pi / n);
  EXPECT_GT(ball.facet_error(), 0.8 * sagitta);
  EXPECT_LT(ball.facet_error(), 2.5 * sagitta);  // diagonals turn less over wider facets
  EXPECT_EQ(surface(box({1, 1, 1})).facet_error(), 0.0);
}

TEST(Surface, AnOpenSurfaceHasNoInside) {
  Drawn open = box({1, 1, 1});
  open.f.conservativeResize(Eigen::NoChange, 11);
  const Surface a = surface(open), b = surface(box({1, 1, 1}));
  EXPECT_FALSE(a.is_closed());
  EXPECT_TRUE(b.is_closed());
  const auto overlap = overlap_of(a, {}, b, {Eigen::Matrix3d::Identity(), {0.1, 0.2, 0.9}});
  ASSERT_TRUE(overlap);
  EXPECT_FALSE(overlap->depth);
}

TEST(Surface, MovedVerticesMoveEverything) {
  const Drawn d = box({1, 1, 1});
  Surface a = surface(d);
  const Surface b = surface(box({1, 1, 1}));
  const mbs::Pose above{Eigen::Matrix3d::Identity(), {0, 0, 1.5}};
  EXPECT_NEAR(gap_between(a, {}, b, above).distance, 0.5, 1e-12);
  Eigen::Matrix3Xd taller = d.x;
  taller.row(2) *= 2.0;
  a.move_vertices(taller);
  EXPECT_NEAR(*overlap_of(a, {}, b, {Eigen::Matrix3d::Identity(), {0.1, 0.1, 1.3}})->depth, 0.2,
              0.004);  // 2 %
  EXPECT_EQ(gap_between(a, {}, b, {Eigen::Matrix3d::Identity(), {0, 0, 1.7}}).distance > 0.19, true);
}

}  // namespace
}  // namespace flexura::proximity
