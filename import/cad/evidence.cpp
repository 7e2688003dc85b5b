// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/evidence.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

namespace flexura::import::cad {

using mesh::FaceKind;

std::string mm(double x) {
  // Less than an atom is round-off.
  return fmt::format("{:.4g} mm", std::abs(x) < 1e-10 ? 0.0 : 1e3 * x);
}

std::string evidence_of(const FacePair& p, const std::string& a, const std::string& b) {
  if (p.kind == FaceKind::cylinder)
    return fmt::format("{} {} of {} (face {}) in {} (face {}), {} long, gap {}", "shaft", mm(p.radius),
                       p.shaft_in_a ? a : b, p.shaft_in_a ? p.face_a : p.face_b, p.shaft_in_a ? b : a,
                       p.shaft_in_a ? p.face_b : p.face_a, mm(p.extent), mm(p.gap));
  if (p.is_thread()) {
    const char* const sign = p.sign == ThreadSign::flanks          ? "by the flanks of both"
                             : p.sign == ThreadSign::flanks_of_one ? "by the flanks of one of them"
                             : p.sign == ThreadSign::overlap
                                 ? "drawn as cylinders that overlap, as a bolt and a hole for the tap"
                                 : "drawn as cylinders, a thread by its name";
    return fmt::format(
        "thread of radius {}{} of {} (face {}) in {} (face {}), {} long, {}", mm(p.radius),
        p.lead != 0.0 ? fmt::format(", lead {}{}", mm(std::abs(p.lead)), p.lead < 0.0 ? " (left-hand)" : "")
                      : "",
        p.shaft_in_a ? a : b, p.shaft_in_a ? p.face_a : p.face_b, p.shaft_in_a ? b : a,
        p.shaft_in_a ? p.face_b : p.face_a, mm(p.extent), sign);
  }
  if (p.kind == FaceKind::cone)
    return fmt::format("cone of {} (face {}) in its seat in {} (face {}), radius {}, {} long, gap {}",
                       p.shaft_in_a ? a : b, p.shaft_in_a ? p.face_a : p.face_b, p.shaft_in_a ? b : a,
                       p.shaft_in_a ? p.face_b : p.face_a, mm(p.radius), mm(p.extent), mm(p.gap));
  if (p.kind == FaceKind::sphere)
    return fmt::format("ball of radius {} of {} (face {}) in {} (face {}), gap {}", mm(p.radius),
                       p.shaft_in_a ? a : b, p.shaft_in_a ? p.face_a : p.face_b, p.shaft_in_a ? b : a,
                       p.shaft_in_a ? p.face_b : p.face_a, mm(p.gap));
  return fmt::format("plane on plane, {} (face {}) and {} (face {}), {:.4g} mm^2, gap {}", a, p.face_a, b,
                     p.face_b, 1e6 * p.extent, mm(p.gap));
}

bool is_of_revolution(const PlacedPart& part, const Vector3d& point, const Vector3d& axis, double clearance) {
  double odd = 0.0, all = 0.0;
  for (const PlacedFace& f : part.faces) {
    all += f.face->shape.area;
    const Vector3d off = f.point - point;
    const bool on_axis = (off - axis * axis.dot(off)).norm() < clearance;
    const bool fits = f.kind == FaceKind::plane ? f.normal.cross(axis).norm() < 1e-3
                      : f.kind == FaceKind::cylinder || f.kind == FaceKind::cone
                          ? f.axis.cross(axis).norm() < 1e-3 && on_axis
                      : f.kind == FaceKind::sphere
                          ? on_axis
                          : f.face->is_turned && f.axis.cross(axis).norm() < 1e-3 && on_axis;
    if (!fits) odd += f.face->shape.area;
  }
  return odd < 0.2 * all;
}

}  // namespace flexura::import::cad
