// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/bar_sections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace flexura::mesh {
namespace {

constexpr double kPi = std::numbers::pi;

void require(bool good, const std::string& what) {
  if (!good) throw std::invalid_argument(what);
}

// Of the height between two flanges, where the shear centre is above the lower one: as their moments about the web.
double flange_centre(double lower_thickness, double lower_width, double upper_thickness, double upper_width) {
  const double lower = lower_thickness * std::pow(lower_width, 3),
               upper = upper_thickness * std::pow(upper_width, 3);
  return upper / (lower + upper);
}

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

namespace {

// Corners (y, z) around, symmetric about both axes.  J by Saint-Venant's rule A^4 / (40 I_p), 1.3 % high for the regular
// hexagon.
BarSection solid_polygon(const std::vector<Eigen::Vector2d>& corners) {
  BarSection s;
  for (std::size_t k = 0; k < corners.size(); ++k) {
    const Eigen::Vector2d &a = corners[k], &b = corners[(k + 1) % corners.size()];
    const double twice = a.x() * b.y() - a.y() * b.x();
    s.A += twice / 2;
    s.I_zz += twice / 12 * (a.x() * a.x() + a.x() * b.x() + b.x() * b.x());
    s.I_yy += twice / 12 * (a.y() * a.y() + a.y() * b.y() + b.y() * b.y());
  }
  s.J = std::pow(s.A, 4) / (40 * (s.I_yy + s.I_zz));
  s.kappa_y = s.kappa_z = 5.0 / 6.0;
  s.outline = corners;
  return s;
}

// A channel whose web stands at z = 0 to `web`, flanges towards +z.
BarSection channel(double width, double height, double web, double flange) {
  const double b = width - web / 2, h = height - flange;  // of the walls' middle lines
  return open_section({{0, web / 2, height - 2 * flange, web},
                       {h / 2, width / 2, flange, width},
                       {-h / 2, width / 2, flange, width}},
                      0, web / 2 - 3 * b * b * flange / (h * web + 6 * b * flange));
}

BarSection turned_quarter(BarSection s) {  // z becomes y, y becomes -z
  std::swap(s.I_yy, s.I_zz), std::swap(s.kappa_y, s.kappa_z);
  s.I_yz = -s.I_yz;
  s.shear_y = std::exchange(s.shear_z, -s.shear_y);
  for (Eigen::Vector2d& point : s.outline) point = Eigen::Vector2d(point.y(), -point.x());
  return s;
}

// Walls of four thicknesses around one hole; the shear centre is taken at the centroid.
BarSection uneven_box(double width, double height, double top, double bottom, double right, double left) {
  BarSection s =
      open_section({{height - top / 2, width / 2, top, width},
                    {bottom / 2, width / 2, bottom, width},
                    {(height - top + bottom) / 2, left / 2, height - top - bottom, left},
                    {(height - top + bottom) / 2, width - right / 2, height - top - bottom, right}},
                   0, 0);
  const double b = width - (left + right) / 2, h = height - (top + bottom) / 2;
  s.J = 4 * b * b * h * h / (b / top + b / bottom + h / left + h / right);
  s.shear_y = s.shear_z = 0;
  return s;
}

BarSection hat(double height, double t, double top, double lip) {
  const double y = height - t, z = (top - t) / 2, end = top / 2 + lip;  // middle lines; the lips' ends
  const Eigen::Vector2d shear = thin_shear_centre({{0, -end}, {0, -z}, {y, -z}, {y, z}, {0, z}, {0, end}},
                                                  {{0, 1, t}, {1, 2, t}, {2, 3, t}, {3, 4, t}, {4, 5, t}});
  return open_section({{y, 0, t, top},
                       {y / 2, z, height - 2 * t, t},
                       {y / 2, -z, height - 2 * t, t},
                       {0, (end + z - t / 2) / 2, t, lip + t},
                       {0, -(end + z - t / 2) / 2, t, lip + t}},
                      shear.x(), shear.y());
}

}  // namespace

std::size_t nastran_dimensions(const std::string& type) {
  static const std::map<std::string, std::size_t> kNumber = {
      {"ROD", 1}, {"TUBE", 2},  {"TUBE2", 2}, {"BAR", 2}, {"BOX", 4},  {"BOX1", 6},  {"I", 6},
      {"I1", 4},  {"T", 4},     {"T1", 4},    {"T2", 4},  {"CHAN", 4}, {"CHAN1", 4}, {"CHAN2", 4},
      {"L", 4},   {"CROSS", 4}, {"H", 4},     {"Z", 4},   {"HEXA", 3}, {"HAT", 4}};
  const auto found = kNumber.find(type);
  require(found != kNumber.end(),
          fmt::format(
              "the cross-section {} is not known; ROD, TUBE, TUBE2, BAR, BOX, BOX1, I, I1, T, T1, T2, CHAN, "
              "CHAN1, CHAN2, L, CROSS, H, Z, HEXA and HAT are, or give its constants (PBAR, PBEAM)",
              type));
  return found->second;
}

// The cards draw z_elem to the side and y_elem upwards (MSC Nastran, Quick Reference Guide, PBARL).
BarSection nastran_section(const std::string& type, const std::vector<double>& d) {
  require(d.size() >= nastran_dimensions(type), fmt::format("a cross-section {} has {} dimensions, not {}",
                                                            type, nastran_dimensions(type), d.size()));
  for (const double value : d)
    require(value > 0 || type == "TUBE",
            fmt::format("a dimension of the cross-section {} is {:g}", type, value));
  const auto sound = [&](bool good) {
    require(good, fmt::format("the dimensions of the cross-section {} leave no material or no hole", type));
  };
  if (type == "ROD") return circle(d[0]);
  if (type == "TUBE") {
    sound(d[0] > d[1] && d[1] >= 0);
    return tube(d[0], d[1]);
  }
  if (type == "TUBE2") {
    sound(d[0] > d[1]);
    return tube(d[0], d[0] - d[1]);
  }
  if (type == "BAR") return rectangle(d[1], d[0]);
  if (type == "BOX") {
    sound(d[1] > 2 * d[2] && d[0] > 2 * d[3]);
    return box(d[1], d[0], d[2], d[3]);
  }
  if (type == "I") {  // height, lower and upper width, web, lower and upper flange
    sound(d[0] > d[4] + d[5]);
    const double web = d[0] - d[4] - d[5];
    return open_section(
        {{d[4] / 2, 0, d[4], d[1]}, {d[4] + web / 2, 0, web, d[3]}, {d[0] - d[5] / 2, 0, d[5], d[2]}},
        d[4] / 2 + flange_centre(d[4], d[1], d[5], d[2]) * (d[0] - (d[4] + d[5]) / 2), 0);
  }
  if (type == "T") {  // width, height, flange, web
    sound(d[1] > d[2]);
    return open_section({{d[1] - d[2] / 2, 0, d[2], d[0]}, {(d[1] - d[2]) / 2, 0, d[1] - d[2], d[3]}},
                        d[1] - d[2] / 2, 0);
  }
  if (type == "CHAN") {  // width, height, web, flanges
    sound(d[1] > 2 * d[3] && d[0] > d[2]);
    return channel(d[0], d[1], d[2], d[3]);
  }
  if (type == "CHAN1") {  // flanges beyond the web, web, height between and over the flanges
    sound(d[3] > d[2]);
    return channel(d[0] + d[1], d[3], d[1], (d[3] - d[2]) / 2);
  }
  if (type == "CHAN2") {  // uprights, web below, height, width
    sound(d[3] > 2 * d[0] && d[2] > d[1]);
    return turned_quarter(channel(d[2], d[3], d[1], d[0]));
  }
  if (type == "BOX1") {  // width, height, walls above, below, right, left
    sound(d[1] > d[2] + d[3] && d[0] > d[4] + d[5]);
    return uneven_box(d[0], d[1], d[2], d[3], d[4], d[5]);
  }
  if (type == "I1") {  // flanges beyond the web together, web, height between and over the flanges
    sound(d[3] > d[2]);
    const double t = (d[3] - d[2]) / 2, y = (d[3] - t) / 2;
    return open_section({{0, 0, d[2], d[1]}, {y, 0, t, d[0] + d[1]}, {-y, 0, t, d[0] + d[1]}}, 0, 0);
  }
  if (type == "T1") {  // height of the upright, length of the web to its left, their thicknesses
    sound(d[0] > d[3]);
    return open_section({{0, 0, d[0], d[2]}, {0, -(d[1] + d[2]) / 2, d[3], d[1]}}, 0, 0);
  }
  if (type == "T2") {  // width below, height, flange, web
    sound(d[1] > d[2] && d[0] > d[3]);
    return open_section({{d[2] / 2, 0, d[2], d[0]}, {(d[1] + d[2]) / 2, 0, d[1] - d[2], d[3]}}, d[2] / 2, 0);
  }
  if (type == "CROSS") {  // both arms together, upright, its height, the arms' thickness
    sound(d[2] > d[3]);
    const double z = d[1] / 2 + d[0] / 4;
    return open_section({{0, 0, d[2], d[1]}, {0, z, d[3], d[0] / 2}, {0, -z, d[3], d[0] / 2}}, 0, 0);
  }
  if (type == "Z") {  // a flange beyond the web, web, height between and over the flanges
    sound(d[3] > d[2]);
    const double t = (d[3] - d[2]) / 2, y = (d[3] - t) / 2, z = d[0] / 2;
    return open_section({{0, 0, d[2], d[1]}, {y, -z, t, d[0] + d[1]}, {-y, z, t, d[0] + d[1]}}, 0, 0);
  }
  if (type == "HEXA") {  // from a corner below to the one at the side, width, height
    sound(d[1] > 2 * d[0]);
    const double z = d[1] / 2, y = d[2] / 2;
    return solid_polygon({{-y, d[0] - z}, {0, -z}, {y, d[0] - z}, {y, z - d[0]}, {0, z}, {-y, z - d[0]}});
  }
  if (type == "HAT") {  // height, thickness, width above, lips
    sound(d[0] > 2 * d[1] && d[2] > 2 * d[1]);
    return hat(d[0], d[1], d[2], d[3]);
  }
  if (type == "L") {  // width, height, lower leg's thickness, upright leg's thickness
    sound(d[1] > d[2] && d[0] > d[3]);
    return open_section(
        {{d[2] / 2, d[0] / 2, d[2], d[0]}, {d[2] + (d[1] - d[2]) / 2, d[3] / 2, d[1] - d[2], d[3]}}, d[2] / 2,
        d[3] / 2);
  }
  // H: inner width, both uprights' thickness together, their height, the bar's thickness
  return open_section({{0, 0, d[3], d[0]},
                       {0, (d[0] + d[1] / 2) / 2, d[2], d[1] / 2},
                       {0, -(d[0] + d[1] / 2) / 2, d[2], d[1] / 2}},
                      0, 0);
}

std::size_t dimensions_of_abaqus_section(const std::string& type) {
  static const std::map<std::string, std::size_t> kNumber = {{"CIRC", 1}, {"PIPE", 2}, {"RECT", 2},
                                                             {"BOX", 6},  {"I", 7},    {"L", 4}};
  const auto found = kNumber.find(type);
  return found == kNumber.end() ? 0 : found->second;
}

BarSection abaqus_section(const std::string& type, const std::vector<double>& d) {
  const std::size_t number = dimensions_of_abaqus_section(type);
  require(
      number > 0,
      fmt::format("SECTION={} is not known; CIRC, PIPE, RECT, BOX, I and L are, or give its constants (*BEAM "
                  "GENERAL SECTION)",
                  type));
  require(d.size() >= number, fmt::format("SECTION={} has {} dimensions, not {}", type, number, d.size()));
  const auto may_be_zero = [&](std::size_t k) {  // of I: where the node is; a flange that is not there (a T)
    return type == "I" && (k == 0 || (k > 1 && k < 6 && d[2 + k % 2] == 0 && d[4 + k % 2] == 0));
  };
  for (std::size_t k = 0; k < number; ++k)
    require(d[k] > 0 || may_be_zero(k), fmt::format("a dimension of SECTION={} is {:g}", type, d[k]));
  if (type == "CIRC") return circle(d[0]);
  if (type == "PIPE") {
    require(d[0] >= d[1], "SECTION=PIPE: the wall is thicker than the radius");
    return tube(d[0], d[0] - d[1]);
  }
  if (type == "RECT") return rectangle(d[0], d[1]);
  if (type == "BOX") {  // a, b, t1 to t4 around
    require(d[0] > d[2] + d[4] && d[1] > d[3] + d[5], "SECTION=BOX: the walls leave no hole");
    BarSection s = box(d[0], d[1], (d[2] + d[4]) / 2, (d[3] + d[5]) / 2);
    return s;
  }
  if (type ==
      "I") {  // l, h, b1, b2, t1, t2, t3: lower and upper flange, web; the node is l above the lower edge
    require(d[2] + d[3] > 0, "SECTION=I: both flanges have the width 0; take SECTION=RECT");
    require(d[1] > d[4] + d[5], "SECTION=I: the flanges are thicker than the section is high");
    const double web = d[1] - d[4] - d[5];
    const double shear = d[4] / 2 + flange_centre(d[4], d[2], d[5], d[3]) * (d[1] - (d[4] + d[5]) / 2);
    BarSection s = open_section(
        {{0, d[4] / 2, d[2], d[4]}, {0, d[4] + web / 2, d[6], web}, {0, d[1] - d[5] / 2, d[3], d[5]}}, 0,
        shear);
    s.node_z = d[0] - (shear - s.shear_z);
    return s;
  }
  require(d[0] > d[3] && d[1] > d[2], "SECTION=L: the legs are thicker than the section");
  return open_section(
      {{d[0] / 2, d[2] / 2, d[0], d[2]}, {d[3] / 2, d[2] + (d[1] - d[2]) / 2, d[3], d[1] - d[2]}}, d[3] / 2,
      d[2] / 2);
}

}  // namespace flexura::mesh
