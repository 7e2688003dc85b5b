// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "beam/section/outline_stress.hpp"

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

// Shear stress per unit torque on a side of a rectangle, `at` from its middle (Timoshenko, Goodier, art. 109, from the membrane
// phi = 8 c^2/pi^3 sum (-1)^((n-1)/2)/n^3 (1 - cosh(n pi at / c)/cosh(n pi along / 2c)) cos(n pi across / c), c = `across`):
// 8 c/(pi^2 I_t) sum 1/n^2 (1 - cosh(n pi at / c) / cosh(n pi along / 2c)), n = 1, 3, ...
// `across`: dimension normal to the side, `along`: of the side.
double rectangle_side(double across, double along, double I_t, double at = 0.0) {
  double sum = 0.0;
  for (int n = 1999; n >= 1; n -= 2) {
    const double a = n * pi * std::abs(at) / across, b = n * pi * along / (2.0 * across);
    // cosh a / cosh b without overflow
    const double ratio = std::exp(a - b) * (1.0 + std::exp(-2.0 * a)) / (1.0 + std::exp(-2.0 * b));
    sum += ratio / (static_cast<double>(n) * n);
  }
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

namespace {

// Half the section beyond a cut at height `at` (of the direction with half dimension `half`): its first moment about the middle, and
// the width of material on the cut.
struct Cut {
  double Q, width;
};

// Of a box on a cut along y at height z (`along_z`), or along z at y.
Cut box_cut(const Shape& shape, bool along_z, double at) {
  const auto pick = [along_z](double y, double z) { return along_z ? z : y; };
  const auto other = [along_z](double y, double z) { return along_z ? y : z; };
  const auto box = [&](double w, double h) {
    const double half = pick(w, h) / 2, across = other(w, h);
    return std::abs(at) < half ? Cut{0.5 * across * (half * half - at * at), across} : Cut{0.0, across};
  };
  if (const auto* s = std::get_if<Rectangle>(&shape)) return box(s->width, s->height);
  const auto& s = std::get<HollowRectangle>(shape);
  Cut cut = box(s.width, s.height);
  const double w = s.width - 2 * s.web, h = s.height - 2 * s.flange;
  if (std::abs(at) < pick(w, h) / 2) {
    const Cut inner = box(w, h);
    cut.Q -= inner.Q, cut.width -= inner.width;
  }
  return cut;
}

// The outward normal at a place of the outline, and what torsion gives there along the outline, counter-clockwise about x.
struct Edge {
  double n_y = 0.0, n_z = 0.0, torsion = 0.0;
};

Edge box_edge(const Shape& shape, const Constants& c, double y, double z) {
  const auto* solid = std::get_if<Rectangle>(&shape);
  const auto* hollow = std::get_if<HollowRectangle>(&shape);
  const double w = solid ? solid->width : hollow->width, h = solid ? solid->height : hollow->height;
  const auto on = [&](double at, double side) { return std::abs(std::abs(at) - side) < 1e-9 * (w + h); };
  Edge edge;
  bool on_y = on(y, w / 2), on_z = on(z, h / 2);
  if (hollow && !on_y && !on_z) {
    on_y = on(y, w / 2 - hollow->web) && std::abs(z) < h / 2 - hollow->flange + 1e-9 * h;
    on_z = on(z, h / 2 - hollow->flange) && std::abs(y) < w / 2 - hollow->web + 1e-9 * w;
  }
  if (on_y == on_z) return edge;  // a corner: two free faces
  edge.n_y = on_y ? std::copysign(1.0, y) : 0.0;
  edge.n_z = on_z ? std::copysign(1.0, z) : 0.0;
  if (solid) {
    edge.torsion = on_y ? rectangle_side(w, h, c.I_t, z) : rectangle_side(h, w, c.I_t, y);
  } else {
    // Bredt's flow carries its share of I_t; G theta' t is added outside and taken away inside, as in open walls.
    const double w_m = w - hollow->web, h_m = h - hollow->flange, t = on_y ? hollow->web : hollow->flange;
    const double I_closed = 4 * (w_m * h_m) * (w_m * h_m) / (2 * (w_m / hollow->flange + h_m / hollow->web));
    const bool outer = on(y, w / 2) || on(z, h / 2);
    edge.torsion = I_closed / c.I_t / (2 * w_m * h_m * t) + (outer ? t : -t) / c.I_t;
  }
  return edge;
}

Edge edge_at(const Shape& shape, const Constants& c, const Geometry& g, double y, double z) {
  if (g.corners) return box_edge(shape, c, y, z);
  // tau_xy = -2 a^2 z / (a^2 + b^2) G theta', tau_xz = 2 b^2 y / (a^2 + b^2) G theta', also in similar ellipses inside.
  const double a2 = g.y * g.y, b2 = g.z * g.z;
  const Eigen::Vector2d normal = Eigen::Vector2d(y / a2, z / b2).normalized();
  const double tau_y = -2 * a2 * z / ((a2 + b2) * c.I_t), tau_z = 2 * b2 * y / ((a2 + b2) * c.I_t);
  return {normal(0), normal(1), -normal(1) * tau_y + normal(0) * tau_z};
}

// Half axes of the inner ellipse; 0: solid.
std::array<double, 2> hole_of(const Shape& shape) {
  if (const auto* s = std::get_if<HollowCircle>(&shape))
    return {s->inner_diameter / 2, s->inner_diameter / 2};
  if (const auto* s = std::get_if<HollowEllipse>(&shape)) return {s->inner_width / 2, s->inner_height / 2};
  return {0.0, 0.0};
}

// Jourawski's mean on a cut along the ray through the place, along the wall: of a circle V (r_o^3 - r_i^3) cos / (3 I (r_o - r_i)),
// of ellipses its affine image.
void put_shear_of_ellipse(const Shape& shape, const Constants& c, const Geometry& g, double y, double z,
                          Eigen::Matrix<double, 3, 6>& S) {
  const auto [a_i, b_i] = hole_of(shape);
  const double outer = std::hypot(y / g.y, z / g.z), inner = a_i > 0.0 ? std::hypot(y / a_i, z / b_i) : 0.0;
  const double q = a_i > 0.0 ? outer / inner : 0.0, k = (1.0 + q + q * q) / 3.0;
  const double Y = y / outer, Z = z / outer, ratio = g.z * g.z / (g.y * g.y);
  S(1, V_z) = -k * Y * Z / c.I_y;
  S(2, V_z) = k * ratio * Y * Y / c.I_y;
  S(1, V_y) = k / ratio * Z * Z / c.I_z;
  S(2, V_y) = -k * Y * Z / c.I_z;
}

}  // namespace

Eigen::Matrix<double, 3, 6> stress_on_outline(const Shape& shape, const Constants& c, double y, double z) {
  Eigen::Matrix<double, 3, 6> S = Eigen::Matrix<double, 3, 6>::Zero();
  S(0, N) = 1 / c.A;
  S(0, M_y) = z / c.I_y;
  S(0, M_z) = -y / c.I_z;
  const Geometry geometry = geometry_of(shape);
  const Edge edge = edge_at(shape, c, geometry, y, z);
  // Along the outline (-n_z, n_y): tau_xz = tau n_y, tau_xy = -tau n_z.
  S(1, T) = -edge.torsion * edge.n_z;
  S(2, T) = edge.torsion * edge.n_y;
  if (!geometry.corners) {
    put_shear_of_ellipse(shape, c, geometry, y, z, S);
    return S;
  }
  // On sides along the force the mean across the cut; none on the others.
  if (edge.n_y != 0.0) {
    const Cut cut = box_cut(shape, true, z);
    S(2, V_z) = cut.Q / (c.I_y * cut.width);
  }
  if (edge.n_z != 0.0) {
    const Cut cut = box_cut(shape, false, y);
    S(1, V_y) = cut.Q / (c.I_z * cut.width);
  }
  return S;
}

}  // namespace flexura::beam
