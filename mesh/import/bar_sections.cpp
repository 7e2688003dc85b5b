// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/bar_sections.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace flexura::mesh {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<Eigen::Vector2d> around(double r) {
  constexpr int n = 16;  // between two of them bending is 2 % more at most
  std::vector<Eigen::Vector2d> out;
  for (int k = 0; k < n; ++k) out.emplace_back(r * std::cos(2 * kPi * k / n), r * std::sin(2 * kPi * k / n));
  return out;
}

std::vector<Eigen::Vector2d> corners(double b_y, double b_z) {
  const double y = b_y / 2, z = b_z / 2;
  return {{-y, -z}, {y, -z}, {y, z}, {-y, z}};
}

}  // namespace

double flange_centre(double lower_thickness, double lower_width, double upper_thickness, double upper_width) {
  const double lower = lower_thickness * std::pow(lower_width, 3),
               upper = upper_thickness * std::pow(upper_width, 3);
  return upper / (lower + upper);
}

std::vector<Eigen::Vector2d> hull(std::vector<Eigen::Vector2d> points) {
  using Eigen::Vector2d;
  const auto before = [](const Vector2d& a, const Vector2d& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  };
  std::ranges::sort(points, before);
  if (points.size() < 3) return {};
  const double size = (points.back() - points.front()).norm();
  std::vector<Vector2d> out;
  const auto half = [&](auto first, auto last) {  // Andrew's chains
    const std::size_t start = out.size();
    for (; first != last; ++first) {
      const auto turns_right = [&] {
        const Vector2d a = out.back() - out[out.size() - 2], b = *first - out.back();
        return a.x() * b.y() - a.y() * b.x() <= 1e-9 * size * size;
      };
      while (out.size() >= start + 2 && turns_right()) out.pop_back();
      out.push_back(*first);
    }
    out.pop_back();
  };
  half(points.begin(), points.end());
  half(points.rbegin(), points.rend());
  return out;
}

BarSection circle(double r) {
  BarSection s;
  s.A = kPi * r * r;
  s.I_yy = s.I_zz = kPi * r * r * r * r / 4;
  s.J = 2 * s.I_yy;
  s.kappa_y = s.kappa_z = 6.0 / 7.0;
  s.outline = around(r);
  return s;
}

BarSection ellipse(double a, double b) {
  if (a == b) return circle(a);
  BarSection s;
  s.A = kPi * a * b;
  s.I_yy = s.A * b * b / 4;
  s.I_zz = s.A * a * a / 4;
  s.J = kPi * a * a * a * b * b * b / (a * a + b * b);
  const auto shear = [](double along, double across) {
    const double p = along * along, q = across * across;
    return 12 * (3 * p + q) / (40 * p + 16 * q);
  };
  s.kappa_y = shear(a, b), s.kappa_z = shear(b, a);
  for (const Eigen::Vector2d& point : around(1.0)) s.outline.emplace_back(a * point.x(), b * point.y());
  return s;
}

BarSection tube(double r, double inner) {
  const BarSection outside = circle(r), hole = circle(inner);
  BarSection s;
  s.A = outside.A - hole.A;
  s.I_yy = s.I_zz = outside.I_yy - hole.I_yy;
  s.J = 2 * s.I_yy;
  const double m = inner / r, square = (1 + m * m) * (1 + m * m);
  s.kappa_y = s.kappa_z = 6 * square / (7 * square + 20 * m * m);
  s.outline = outside.outline;
  return s;
}

BarSection rectangle(double b_y, double b_z) {
  BarSection s;
  s.A = b_y * b_z;
  s.I_yy = b_y * b_z * b_z * b_z / 12;
  s.I_zz = b_z * b_y * b_y * b_y / 12;
  const double a = std::max(b_y, b_z), b = std::min(b_y, b_z);
  double sum = 0;
  for (int n = 1; n < 40; n += 2) sum += std::tanh(n * kPi * a / (2 * b)) / std::pow(n, 5);
  s.J = a * b * b * b / 3 * (1 - 192 * b / (std::pow(kPi, 5) * a) * sum);
  s.kappa_y = s.kappa_z = 5.0 / 6.0;
  s.outline = corners(b_y, b_z);
  return s;
}

BarSection box(double b_y, double b_z, double side, double flange) {
  BarSection s;
  const double c_y = b_y - 2 * side, c_z = b_z - 2 * flange;
  s.A = b_y * b_z - c_y * c_z;
  s.I_yy = (b_y * b_z * b_z * b_z - c_y * c_z * c_z * c_z) / 12;
  s.I_zz = (b_z * b_y * b_y * b_y - c_z * c_y * c_y * c_y) / 12;
  const double m_y = b_y - side, m_z = b_z - flange;  // the walls' middle line
  s.J = 4 * m_y * m_y * m_z * m_z / (2 * m_y / flange + 2 * m_z / side);
  s.kappa_y = 2 * flange * b_y / s.A;
  s.kappa_z = 2 * side * b_z / s.A;
  s.kappa_y = std::min(s.kappa_y, 5.0 / 6.0), s.kappa_z = std::min(s.kappa_z, 5.0 / 6.0);
  s.outline = corners(b_y, b_z);
  return s;
}

BarSection open_section(const std::vector<Wall>& walls, double shear_y, double shear_z) {
  BarSection s;
  double y = 0, z = 0, web_y = 0, web_z = 0;
  for (const Wall& w : walls) {
    const double A = w.along_y * w.along_z;
    s.A += A, y += A * w.y, z += A * w.z;
    (w.along_y > w.along_z ? web_y : web_z) += A;
    const double thick = std::min(w.along_y, w.along_z);
    s.J += std::max(w.along_y, w.along_z) * thick * thick * thick / 3;
  }
  y /= s.A, z /= s.A;
  s.shear_y = shear_y - y, s.shear_z = shear_z - z;
  std::vector<Eigen::Vector2d> ends;
  for (const Wall& w : walls)
    for (const Eigen::Vector2d& corner : corners(w.along_y, w.along_z))
      ends.emplace_back(corner + Eigen::Vector2d(w.y - y, w.z - z));
  s.outline = hull(std::move(ends));
  for (const Wall& w : walls) {
    const double A = w.along_y * w.along_z, dy = w.y - y, dz = w.z - z;
    s.I_yy += A * (w.along_z * w.along_z / 12 + dz * dz);
    s.I_zz += A * (w.along_y * w.along_y / 12 + dy * dy);
    s.I_yz += A * dy * dz;
  }
  s.kappa_y = std::min(web_y / s.A, 5.0 / 6.0), s.kappa_z = std::min(web_z / s.A, 5.0 / 6.0);
  if (std::abs(s.I_yz) < 1e-12 * std::max(s.I_yy, s.I_zz)) s.I_yz = 0;
  return s;
}

// A thin-walled open section by the middle lines of its walls: points (y, z), walls from one to another, a tree whose walls
// start where an earlier one ends.  The pole about which the sectorial area is orthogonal to y and z (Vlasov).
Eigen::Vector2d thin_shear_centre(const std::vector<Eigen::Vector2d>& points,
                                  const std::vector<Line>& lines) {
  double A = 0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Line& line : lines) {
    const double area = line.thickness * (points[line.to] - points[line.from]).norm();
    A += area, centre += area * 0.5 * (points[line.from] + points[line.to]);
  }
  centre /= A;
  std::vector<double> sectorial(points.size(), 0.0);
  Eigen::Matrix2d I = Eigen::Matrix2d::Zero();
  Eigen::Vector2d of_sectorial = Eigen::Vector2d::Zero();
  for (const Line& line : lines) {
    const Eigen::Vector2d a = points[line.from] - centre, b = points[line.to] - centre;
    sectorial[line.to] = sectorial[line.from] + a.x() * b.y() - a.y() * b.x();
    const double w_a = sectorial[line.from], w_b = sectorial[line.to], area = line.thickness * (b - a).norm();
    I += area / 6 * (2 * a * a.transpose() + a * b.transpose() + b * a.transpose() + 2 * b * b.transpose());
    of_sectorial += area / 6 * (2 * w_a * a + w_a * b + w_b * a + 2 * w_b * b);
  }
  // About the pole (y, z) it is less by y (z - z_0) and more by z (y - y_0).
  Eigen::Matrix2d solve;
  solve << I(0, 1), -I(0, 0), I(1, 1), -I(0, 1);
  return centre + Eigen::Vector2d(solve.inverse() * of_sectorial);
}

}  // namespace flexura::mesh
