// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran/nastran_sections.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "mesh/import/builder.hpp"

namespace flexura::mesh {
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

}  // namespace flexura::mesh
