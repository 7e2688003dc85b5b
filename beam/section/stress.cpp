// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <cmath>

#include "beam/section/outline_stress.hpp"
#include "beam/section/shape_math.hpp"

namespace flexura::beam {
namespace {

// Semi-axes along y and z of the contours of a round section; inner 0: solid.
struct Ellipses {
  double a, b, a_i, b_i;
  bool similar() const { return std::abs(a_i * b - b_i * a) <= 1e-12 * a * b; }
};

bool is_box(const Shape& shape) {
  return std::holds_alternative<Rectangle>(shape) || std::holds_alternative<HollowRectangle>(shape);
}

Ellipses ellipses_of(const Shape& shape) {
  if (const auto* s = std::get_if<Circle>(&shape)) return {s->diameter / 2, s->diameter / 2, 0, 0};
  if (const auto* s = std::get_if<HollowCircle>(&shape))
    return {s->outer_diameter / 2, s->outer_diameter / 2, s->inner_diameter / 2, s->inner_diameter / 2};
  if (const auto* s = std::get_if<Ellipse>(&shape)) return {s->width / 2, s->height / 2, 0, 0};
  const auto& s = std::get<HollowEllipse>(shape);
  return {s.width / 2, s.height / 2, s.inner_width / 2, s.inner_height / 2};
}

// Half width and half height.
std::array<double, 2> reach_of(const Shape& shape) {
  if (const auto* s = std::get_if<Rectangle>(&shape)) return {s->width / 2, s->height / 2};
  if (const auto* s = std::get_if<HollowRectangle>(&shape)) return {s->width / 2, s->height / 2};
  const Ellipses e = ellipses_of(shape);
  return {e.a, e.b};
}

// Shear stress per unit torque on a side of a rectangle, `at` from its middle (Timoshenko, Goodier, art. 109, from the membrane
// phi = 8 c^2/pi^3 sum (-1)^((n-1)/2)/n^3 (1 - cosh(n pi at / c)/cosh(n pi along / 2c)) cos(n pi across / c), c = `across`):
// 8 c/(pi^2 I_t) sum 1/n^2 (1 - cosh(n pi at / c) / cosh(n pi along / 2c)), n = 1, 3, ...
// `across`: dimension normal to the side, `along`: of the side.
double rectangle_side(double across, double along, double I_t, double at) {
  double sum = 0.0;
  for (int n = 1999; n >= 1; n -= 2) {
    const double a = n * pi * std::abs(at) / across, b = n * pi * along / (2.0 * across);
    // cosh a / cosh b without overflow
    const double ratio = std::exp(a - b) * (1.0 + std::exp(-2.0 * a)) / (1.0 + std::exp(-2.0 * b));
    sum += ratio / (static_cast<double>(n) * n);
  }
  return across * (1.0 - 8.0 / (pi * pi) * sum) / I_t;
}

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

// The outward normal at a place of a contour, and what torsion gives there along it, counter-clockwise about x.
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

// Bredt's flow in the wall between two ellipses carries its share of I_t; G theta' t is added outside and taken away inside.
double torsion_of_wall(const Ellipses& e, const Constants& c, double y, double z, bool outer) {
  const MidLine wall(e.a, e.b, e.a_i, e.b_i);
  constexpr int step = 10;  // 144 places: round-off where the thickness varies by less than 1 : 10
  double flow = 0.0;
  for (int k = 0; k < MidLine::n; k += step) {
    const MidLine::Point point = wall.at(k);
    flow += step * point.ds / point.t;
  }
  const double A_m = pi * wall.a * wall.b, I_closed = 4.0 * pow2(A_m) / flow,
               phi = outer ? std::atan2(z / e.b, y / e.a) : std::atan2(z / e.b_i, y / e.a_i),
               t = wall.at(phi / (2.0 * pi) * MidLine::n).t;
  return (I_closed / (2.0 * A_m * t) + (outer ? t : -t)) / c.I_t;
}

// Jourawski's mean on a cut along the ray through the place, r_i to r_o from the middle: the sector between the ray and the axis of
// the force has int z dA = (b^2 r_o - b_i^2 r_i) e_y / 3, e the ray's direction.  The stress runs along the contour there.
void put_round(const Ellipses& e, const Constants& c, double y, double z, Eigen::Matrix<double, 3, 6>& S) {
  const double r = std::hypot(y, z), share = std::hypot(y / e.a, z / e.b),
               share_i = e.a_i > 0.0 ? std::hypot(y / e.a_i, z / e.b_i) : 0.0, r_o = r / share,
               r_i = e.a_i > 0.0 ? r / share_i : 0.0;
  const bool outer = e.a_i == 0.0 || std::abs(share - 1.0) <= std::abs(share_i - 1.0);
  const double a2 = pow2(outer ? e.a : e.a_i), b2 = pow2(outer ? e.b : e.b_i);
  const Eigen::Vector2d along(-z / b2, y / a2);  // r along . (-e_z, e_y) = 1
  const double tau_z = y * (pow2(e.b) * r_o - pow2(e.b_i) * r_i) / (3.0 * c.I_y * (r_o - r_i)),
               tau_y = -z * (pow2(e.a) * r_o - pow2(e.a_i) * r_i) / (3.0 * c.I_z * (r_o - r_i));
  S.block<2, 1>(1, V_z) = tau_z * along;
  S.block<2, 1>(1, V_y) = tau_y * along;
  if (e.similar()) {
    // tau_xy = -2 a^2 z / (a^2 + b^2) G theta', tau_xz = 2 b^2 y / (a^2 + b^2) G theta', also in similar ellipses inside.
    const double sum = pow2(e.a) + pow2(e.b);
    S.block<2, 1>(1, T) = Eigen::Vector2d(-2.0 * pow2(e.a) * z, 2.0 * pow2(e.b) * y) / (sum * c.I_t);
  } else {
    S.block<2, 1>(1, T) = torsion_of_wall(e, c, y, z, outer) * along.normalized();
  }
}

// On sides along the force the mean across the cut; in the walls of a hollow box across it the flow that the other half's fibres
// leave, V y z / I on the mid-line; none on the others.
void put_box(const Shape& shape, const Constants& c, double y, double z, Eigen::Matrix<double, 3, 6>& S) {
  const Edge edge = box_edge(shape, c, y, z);
  // Along the outline (-n_z, n_y): tau_xz = tau n_y, tau_xy = -tau n_z.
  S(1, T) = -edge.torsion * edge.n_z;
  S(2, T) = edge.torsion * edge.n_y;
  const auto* hollow = std::get_if<HollowRectangle>(&shape);
  if (edge.n_y != 0.0) {
    const Cut cut = box_cut(shape, true, z);
    S(2, V_z) = cut.Q / (c.I_y * cut.width);
    if (hollow) S(2, V_y) = -z * std::copysign(0.5 * (hollow->width - hollow->web), y) / c.I_z;
  }
  if (edge.n_z != 0.0) {
    const Cut cut = box_cut(shape, false, y);
    S(1, V_y) = cut.Q / (c.I_z * cut.width);
    if (hollow) S(1, V_z) = -y * std::copysign(0.5 * (hollow->height - hollow->flange), z) / c.I_y;
  }
}

}  // namespace

Eigen::Matrix<double, 3, 6> stress_on_outline(const Shape& shape, const Constants& c, double y, double z) {
  Eigen::Matrix<double, 3, 6> S = Eigen::Matrix<double, 3, 6>::Zero();
  S(0, N) = 1 / c.A;
  S(0, M_y) = z / c.I_y;
  S(0, M_z) = -y / c.I_z;
  if (is_box(shape))
    put_box(shape, c, y, z, S);
  else
    put_round(ellipses_of(shape), c, y, z, S);
  return S;
}

std::vector<StressPoint> stress_points(const Shape& shape, const Constants& c) {
  const auto [y, z] = reach_of(shape);
  std::vector<StressPoint> points;
  const auto add = [&](const char* name, double at_y, double at_z) {
    points.push_back({name, at_y, at_z, stress_on_outline(shape, c, at_y, at_z)});
  };
  add("+y", y, 0.0);
  add("+z", 0.0, z);
  add("-y", -y, 0.0);
  add("-z", 0.0, -z);
  const bool hollow =
      std::holds_alternative<HollowRectangle>(shape) || (!is_box(shape) && ellipses_of(shape).a_i > 0.0);
  if (!hollow) {
    // On cuts through the middle the mean is that of their ends.
    StressPoint centre{"centre", 0.0, 0.0, Eigen::Matrix<double, 3, 6>::Zero()};
    centre.S(0, N) = 1 / c.A;
    centre.S(1, V_y) = points[1].S(1, V_y);
    centre.S(2, V_z) = points[0].S(2, V_z);
    points.push_back(centre);
  }
  if (is_box(shape)) {
    add("+y+z", y, z);
    add("+y-z", y, -z);
    add("-y+z", -y, z);
    add("-y-z", -y, -z);
  }
  return points;
}

}  // namespace flexura::beam
