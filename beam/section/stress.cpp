// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <numbers>

#include "beam/section/shapes.hpp"

namespace flexura::beam {
namespace {

using std::numbers::pi;

// Extreme half dimensions, the material's total width on the two axes and the half-section moments Q there.
struct Geometry {
  double y, z;              // half width, half height
  double width_y, width_z;  // of material on the line z = 0 and on the line y = 0
  double Q_z, Q_y;          // int z dA above z = 0; int y dA beyond y = 0
  bool centre;              // material at the origin
  bool corners;
};

Geometry ellipse(double a, double b, double a_i, double b_i) {
  return {a,
          b,
          2 * (a - a_i),
          2 * (b - b_i),
          2.0 / 3.0 * (a * b * b - a_i * b_i * b_i),
          2.0 / 3.0 * (a * a * b - a_i * a_i * b_i),
          a_i == 0.0,
          false};
}

Geometry geometry_of(const Shape& shape) {
  if (const auto* s = std::get_if<Circle>(&shape)) return ellipse(s->diameter / 2, s->diameter / 2, 0, 0);
  if (const auto* s = std::get_if<HollowCircle>(&shape))
    return ellipse(s->outer_diameter / 2, s->outer_diameter / 2, s->inner_diameter / 2,
                   s->inner_diameter / 2);
  if (const auto* s = std::get_if<Ellipse>(&shape)) return ellipse(s->width / 2, s->height / 2, 0, 0);
  if (const auto* s = std::get_if<HollowEllipse>(&shape))
    return ellipse(s->width / 2, s->height / 2, s->inner_width / 2, s->inner_height / 2);
  if (const auto* s = std::get_if<Rectangle>(&shape))
    return {s->width / 2,
            s->height / 2,
            s->width,
            s->height,
            s->width * s->height * s->height / 8,
            s->height * s->width * s->width / 8,
            true,
            true};
  const auto& s = std::get<HollowRectangle>(shape);
  const double w = s.width - 2 * s.web, h = s.height - 2 * s.flange;
  return {s.width / 2,
          s.height / 2,
          2 * s.web,
          2 * s.flange,
          (s.width * s.height * s.height - w * h * h) / 8,
          (s.height * s.width * s.width - h * w * w) / 8,
          false,
          true};
}

// Shear stress per unit torque at the middle of the sides z = +-height/2 of a rectangle (Timoshenko, Goodier,
// art. 109): 2 G theta' (b/2) (1 - 8/pi^2 sum 1/(n^2 cosh(n pi a / 2b))) on the long side; the short side
// from the same membrane.
double rectangle_side(double across, double along, double I_t) {
  // `across`: dimension normal to the side, `along`: of the side.  phi(0, z): derivative at the side's
  // middle.
  double sum = 0.0;
  for (int n = 199; n >= 1; n -= 2)
    sum += 1.0 / (n * n * std::cosh(std::min(700.0, n * pi * along / (2 * across))));
  return across * (1.0 - 8.0 / (pi * pi) * sum) / I_t;
}

// Magnitude of tau_xy at (0, z_max) and of tau_xz at (y_max, 0) per unit torque.
std::array<double, 2> torsion_stress(const Shape& shape, const Constants& c, const Geometry& g) {
  if (std::holds_alternative<Rectangle>(shape))
    return {rectangle_side(2 * g.z, 2 * g.y, c.I_t), rectangle_side(2 * g.y, 2 * g.z, c.I_t)};
  if (const auto* s = std::get_if<HollowRectangle>(&shape)) {
    const double twice_area = 2 * (s->width - s->web) * (s->height - s->flange);
    return {1 / (twice_area * s->flange), 1 / (twice_area * s->web)};
  }
  // Ellipse: tau_xy = -2 a^2 z / (a^2 + b^2) G theta', tau_xz = 2 b^2 y / (a^2 + b^2) G theta'.
  const double a2 = g.y * g.y, b2 = g.z * g.z;
  return {2 * a2 * g.z / ((a2 + b2) * c.I_t), 2 * b2 * g.y / ((a2 + b2) * c.I_t)};
}

}  // namespace

std::vector<StressPoint> stress_points(const Shape& shape, const Constants& c) {
  const Geometry g = geometry_of(shape);
  const auto [tau_y, tau_z] = torsion_stress(shape, c, g);
  // On the axis of symmetry z = 0 the mean stress of V_z, on y = 0 that of V_y.
  const double shear_z = g.Q_z / (c.I_y * g.width_y), shear_y = g.Q_y / (c.I_z * g.width_z);

  std::vector<StressPoint> points;
  const auto add = [&](const char* name, double y, double z) -> StressPoint& {
    StressPoint point{name, y, z, {}};
    point.S.setZero();
    point.S(0, N) = 1 / c.A;
    point.S(0, M_y) = z / c.I_y;
    point.S(0, M_z) = -y / c.I_z;
    return points.emplace_back(point);
  };
  for (const double sign : {1.0, -1.0}) {
    StressPoint& side = add(sign > 0 ? "+y" : "-y", sign * g.y, 0.0);
    side.S(2, V_z) = shear_z;
    side.S(2, T) = sign * tau_z;
    StressPoint& top = add(sign > 0 ? "+z" : "-z", 0.0, sign * g.z);
    top.S(1, V_y) = shear_y;
    top.S(1, T) = -sign * tau_y;
  }
  if (g.centre) {
    StressPoint& centre = add("centre", 0.0, 0.0);
    centre.S(1, V_y) = shear_y;
    centre.S(2, V_z) = shear_z;
  }
  if (g.corners)
    for (const double y : {1.0, -1.0})
      for (const double z : {1.0, -1.0})
        add(y > 0 ? (z > 0 ? "+y+z" : "+y-z") : (z > 0 ? "-y+z" : "-y-z"), y * g.y, z * g.z);
  return points;
}

}  // namespace flexura::beam
