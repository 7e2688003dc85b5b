// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/model/face.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace flexura::mesh {

const char* name_of(FaceKind kind) {
  switch (kind) {
    case FaceKind::plane:
      return "plane";
    case FaceKind::cylinder:
      return "cylinder";
    case FaceKind::cone:
      return "cone";
    case FaceKind::sphere:
      return "sphere";
    case FaceKind::other:
      break;
  }
  return "free-form";
}

namespace {

/// Four significant digits of `scale`, without the noise below.
double rounded(double value, double scale) {
  if (!(scale > 0)) return 0;
  const double digit = std::pow(10, std::floor(std::log10(scale)) - 4);
  const double r = std::round(value / digit) * digit;
  return r == 0 ? 0 : r;
}

std::string triple(const Eigen::Vector3d& v) {
  double scale = v.cwiseAbs().maxCoeff();
  if (scale < 1e-9) scale = 0;  // round-off about the origin
  return fmt::format("({:.6g}, {:.6g}, {:.6g})", rounded(v.x(), scale), rounded(v.y(), scale),
                     rounded(v.z(), scale));
}

}  // namespace

std::string describe_point_mm(const Eigen::Vector3d& point) {
  return triple(1e3 * point) + " mm";
}

std::string describe(const Face& face) {
  std::string text = fmt::format("face {}", face.number);
  if (!face.name.empty()) text += fmt::format(" \"{}\"", face.name);
  switch (face.kind) {
    case FaceKind::plane:
      text += fmt::format(": plane, normal {} at {}", triple(face.normal), describe_point_mm(face.centroid));
      break;
    case FaceKind::cylinder:
      text += fmt::format(": {}, radius {:.6g} mm, length {:.6g} mm, {:.0f} deg, axis {} through {}",
                          !face.hole                                ? "cylinder"
                          : face.sweep > std::numbers::pi / 2 + 0.1 ? "bore"
                                                                    : "hollow",
                          1e3 * face.radius, 1e3 * face.length, face.sweep * 180 / std::numbers::pi,
                          triple(face.axis), describe_point_mm(face.axis_point));
      break;
    case FaceKind::cone:
      text +=
          fmt::format(": {}, mean radius {:.6g} mm, axis {} through {}", face.hole ? "conical bore" : "cone",
                      1e3 * face.radius, triple(face.axis), describe_point_mm(face.axis_point));
      break;
    case FaceKind::sphere:
      text += fmt::format(": {}, radius {:.6g} mm, centre {}", face.hole ? "spherical socket" : "sphere",
                          1e3 * face.radius, describe_point_mm(face.axis_point));
      break;
    case FaceKind::other:
      text += fmt::format(": free-form, centre {}", describe_point_mm(face.centroid));
      break;
  }
  return text + fmt::format(", area {:.4g} mm^2", 1e6 * face.area);
}

namespace {

/// Shortest digits that read back as the same number, with a point; what is round-off beside `scale` is zero.
std::string number(double x, double scale) {
  const std::string text = fmt::format("{}", std::abs(x) < 1e-12 * scale ? 0.0 : x);
  return text.find_first_of(".e") == std::string::npos ? text + ".0" : text;
}

std::string list(const Eigen::Vector3d& v, double scale) {
  return fmt::format("[{}, {}, {}]", number(v.x(), scale), number(v.y(), scale), number(v.z(), scale));
}

}  // namespace

std::string selection_lines(const Face& face) {
  const double size = face.box.cwiseAbs().maxCoeff() + face.centroid.norm() + face.radius;
  if (face.kind == FaceKind::cylinder)
    return fmt::format("by = \"cylinder\"\npoint = {}\naxis = {}\nradius = {}\n", list(face.axis_point, size),
                       list(face.axis, 1.0), number(face.radius, size));
  if (face.kind == FaceKind::plane)
    return fmt::format("by = \"plane\"\npoint = {}\nnormal = {}\n", list(face.centroid, size),
                       list(face.normal, 1.0));
  return fmt::format("by = \"near\"\npoint = {}\n", list(face.centroid, size));
}

}  // namespace flexura::mesh
