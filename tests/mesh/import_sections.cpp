// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The shapes of PBARL against Green's integrals over their outlines, drawn after the Quick Reference Guide (as the sections
// library of robbievanleeuwen/section-properties, MIT licence, draws them too).
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

#include "mesh/import/nastran/nastran_sections.hpp"

namespace flexura::mesh {
namespace {

using Eigen::Vector2d;
using Ring = std::vector<Vector2d>;  // (z, y): to the right and up, as the guide draws

struct Moments {
  double A = 0, I_yy = 0, I_zz = 0, I_yz = 0;
  Vector2d centre = Vector2d::Zero();  // (z, y)
};

// Rings after the first are holes.
Moments green(const std::vector<Ring>& rings) {
  Moments m;
  Vector2d first = Vector2d::Zero();
  for (std::size_t r = 0; r < rings.size(); ++r) {
    double A = 0, zz = 0, yy = 0, zy = 0;
    Vector2d S = Vector2d::Zero();
    for (std::size_t k = 0; k < rings[r].size(); ++k) {
      const Vector2d &a = rings[r][k], &b = rings[r][(k + 1) % rings[r].size()];
      const double c = a.x() * b.y() - b.x() * a.y();
      A += c / 2, S += c / 6 * (a + b);
      zz += c / 12 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
      yy += c / 12 * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y());
      zy += c / 24 * (a.x() * b.y() + 2 * a.x() * a.y() + 2 * b.x() * b.y() + b.x() * a.y());
    }
    const double sign = (A > 0 ? 1 : -1) * (r == 0 ? 1 : -1);
    m.A += sign * A, first += sign * S;
    m.I_yy += sign * zz, m.I_zz += sign * yy, m.I_yz += sign * zy;
  }
  m.centre = first / m.A;
  m.I_yy -= m.A * m.centre.x() * m.centre.x();
  m.I_zz -= m.A * m.centre.y() * m.centre.y();
  m.I_yz -= m.A * m.centre.x() * m.centre.y();
  return m;
}

struct Shape {
  const char* type;
  std::vector<double> dim;
  std::vector<Ring> rings;
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> kShapes = {
      {"CHAN1",
       {0.75, 1, 3.5, 4},
       {{{0, 0}, {1.75, 0}, {1.75, 0.25}, {1, 0.25}, {1, 3.75}, {1.75, 3.75}, {1.75, 4}, {0, 4}}}},
      {"CHAN2",
       {0.375, 0.5, 2, 4},
       {{{0, 0}, {4, 0}, {4, 2}, {3.625, 2}, {3.625, 0.5}, {0.375, 0.5}, {0.375, 2}, {0, 2}}}},
      {"BOX1",
       {4, 3, 0.375, 0.5, 0.25, 0.75},
       {{{0, 0}, {4, 0}, {4, 3}, {0, 3}}, {{0.75, 0.5}, {3.75, 0.5}, {3.75, 2.625}, {0.75, 2.625}}}},
      {"I1",
       {1, 0.75, 4, 5},
       {{{0, 0},
         {1.75, 0},
         {1.75, 0.5},
         {1.25, 0.5},
         {1.25, 4.5},
         {1.75, 4.5},
         {1.75, 5},
         {0, 5},
         {0, 4.5},
         {0.5, 4.5},
         {0.5, 0.5},
         {0, 0.5}}}},
      {"T1",
       {3, 3.5, 0.375, 0.25},
       {{{0, 0}, {0.375, 0}, {0.375, 3}, {0, 3}, {0, 1.625}, {-3.5, 1.625}, {-3.5, 1.375}, {0, 1.375}}}},
      {"T2",
       {3, 4, 0.375, 0.5},
       {{{0, 0}, {3, 0}, {3, 0.375}, {1.75, 0.375}, {1.75, 4}, {1.25, 4}, {1.25, 0.375}, {0, 0.375}}}},
      {"CROSS",
       {1.5, 0.375, 3, 0.25},
       {{{0.75, 0},
         {1.125, 0},
         {1.125, 1.375},
         {1.875, 1.375},
         {1.875, 1.625},
         {1.125, 1.625},
         {1.125, 3},
         {0.75, 3},
         {0.75, 1.625},
         {0, 1.625},
         {0, 1.375},
         {0.75, 1.375}}}},
      {"Z",
       {1.125, 0.5, 3.5, 4},
       {{{1.125, 0}, {2.75, 0}, {2.75, 0.25}, {1.625, 0.25}, {1.625, 4}, {0, 4}, {0, 3.75}, {1.125, 3.75}}}},
      {"HEXA", {0.5, 2, 1.5}, {{{0.5, 0}, {1.5, 0}, {2, 0.75}, {1.5, 1.5}, {0.5, 1.5}, {0, 0.75}}}},
      {"HAT",
       {1.25, 0.25, 1.5, 0.5},
       {{{0, 0},
         {0.75, 0},
         {0.75, 1},
         {1.75, 1},
         {1.75, 0},
         {2.5, 0},
         {2.5, 0.25},
         {2, 0.25},
         {2, 1.25},
         {0.5, 1.25},
         {0.5, 0.25},
         {0, 0.25}}}}};
  return kShapes;
}

TEST(BarSections, ShapesOfNastranAreTheIntegralsOverTheirOutlines) {
  for (const Shape& shape : shapes()) {
    SCOPED_TRACE(shape.type);
    ASSERT_EQ(nastran_dimensions(shape.type), shape.dim.size());
    const BarSection s = nastran_section(shape.type, shape.dim);
    const Moments m = green(shape.rings);
    EXPECT_NEAR(s.A, m.A, 1e-12 * m.A);
    EXPECT_NEAR(s.I_yy, m.I_yy, 1e-12 * m.I_yy);
    EXPECT_NEAR(s.I_zz, m.I_zz, 1e-12 * m.I_zz);
    EXPECT_NEAR(s.I_yz, m.I_yz, 1e-12 * (m.I_yy + m.I_zz));
    EXPECT_GT(s.J, 0);
    // The outline is the hull of the drawn one.
    Ring hulled;
    for (const Vector2d& p : shape.rings[0]) hulled.emplace_back(p.y() - m.centre.y(), p.x() - m.centre.x());
    hulled = hull(std::move(hulled));
    ASSERT_EQ(s.outline.size(), hulled.size());
    for (const Vector2d& p : hulled) {
      double least = 1;
      for (const Vector2d& q : s.outline) least = std::min(least, (p - q).norm());
      EXPECT_LT(least, 1e-12);
    }
  }
}

TEST(BarSections, TorsionOfAHexagonAndOfAnUnevenBox) {
  // Regular, one unit across its flats: 0.1154 (Roark's formulas for stress and strain, table 10.7); Saint-Venant's rule gives
  // 1.3 % more.
  EXPECT_NEAR(nastran_section("HEXA", {1 / (2 * std::sqrt(3)), 2 / std::sqrt(3), 1}).J / 0.1154, 1.0, 0.015);
  const BarSection even = nastran_section("BOX", {4, 3, 0.2, 0.3}),
                   uneven = nastran_section("BOX1", {4, 3, 0.2, 0.2, 0.3, 0.3});
  EXPECT_NEAR(uneven.J, even.J, 1e-12 * even.J);
  EXPECT_NEAR(uneven.I_yy, even.I_yy, 1e-12 * even.I_yy);
}

// Where textbooks have the distance: a channel's e = 3 b^2 t_f / (h t_w + 6 b t_f) beyond its web, a Z's and an angle's corner;
// a hat without lips is a channel.
TEST(BarSections, ShearCentresOfThinWalls) {
  const double b = 2, h = 3, t_f = 0.2, t_w = 0.1, e = 3 * b * b * t_f / (h * t_w + 6 * b * t_f);
  const Vector2d channel = thin_shear_centre({{-h / 2, b}, {-h / 2, 0}, {h / 2, 0}, {h / 2, b}},
                                             {{0, 1, t_f}, {1, 2, t_w}, {2, 3, t_f}});
  EXPECT_LT((channel - Vector2d(0, -e)).norm(), 1e-14);
  const Vector2d zee = thin_shear_centre({{-h / 2, b}, {-h / 2, 0}, {h / 2, 0}, {h / 2, -b}},
                                         {{0, 1, t_f}, {1, 2, t_w}, {2, 3, t_f}});
  EXPECT_LT(zee.norm(), 1e-14);
  EXPECT_LT(thin_shear_centre({{0, 2}, {0, 0}, {5, 0}}, {{0, 1, 0.1}, {1, 2, 0.3}}).norm(), 1e-14);

  // With lips, all walls alike (Boresi and Schmidt, Advanced mechanics of materials, table 8.1): inwards, and outwards as a hat.
  const double c = 0.7, t = 0.1;
  const auto lipped = [&](double way) {
    return b * (3 * h * h * b + 6 * h * h * c - 8 * c * c * c) /
           (h * h * h + 6 * h * h * b + 6 * h * h * c + 8 * c * c * c + way * 12 * h * c * c);
  };
  for (const double way : {-1.0, 1.0}) {
    const double lip = h / 2 + way * c;
    const Vector2d centre =
        thin_shear_centre({{-lip, b}, {-h / 2, b}, {-h / 2, 0}, {h / 2, 0}, {h / 2, b}, {lip, b}},
                          {{0, 1, t}, {1, 2, t}, {2, 3, t}, {3, 4, t}, {4, 5, t}});
    EXPECT_LT((centre - Vector2d(0, -lipped(way))).norm(), 1e-14) << way;
  }
  // HAT: its web on top, its lips from middle line to end.
  const BarSection hat = nastran_section("HAT", {b + t, t, h + t, c - t / 2});
  const Moments drawn = green({{{-h / 2 - c, 0},
                                {-h / 2 + t / 2, 0},
                                {-h / 2 + t / 2, b},
                                {h / 2 - t / 2, b},
                                {h / 2 - t / 2, 0},
                                {h / 2 + c, 0},
                                {h / 2 + c, t},
                                {h / 2 + t / 2, t},
                                {h / 2 + t / 2, b + t},
                                {-h / 2 - t / 2, b + t},
                                {-h / 2 - t / 2, t},
                                {-h / 2 - c, t}}});
  EXPECT_NEAR(drawn.centre.y() + hat.shear_y, b + t / 2 + lipped(1), 1e-12);
  EXPECT_NEAR(hat.shear_z, 0, 1e-12);
}

}  // namespace
}  // namespace flexura::mesh
