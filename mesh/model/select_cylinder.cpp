// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mesh/model/cells/cell.hpp"
#include "mesh/model/geometry.hpp"
#include "mesh/model/patches.hpp"
#include "mesh/model/selecting.hpp"

// Cylindrical faces by axis and radius, on CAD faces and on boundary cells.
namespace flexura::mesh::selecting {
namespace {

using Eigen::Vector3d;

Selection select_cylinder_faces(const Context& c, const CylinderRule& rule, const Vector3d& axis) {
  std::vector<const Face*> about_axis;
  for (const Face& face : c.faces) {
    if (face.kind != FaceKind::cylinder || std::abs(face.axis.dot(axis)) < std::cos(kAngle)) continue;
    const double tolerance = rule.tolerance > 0 ? rule.tolerance : kRelative * face.radius;
    if (distance_to_axis(face.axis_point, rule.point, axis) > tolerance) continue;
    const double height = axis.dot(face.axis_point - rule.point);
    if (rule.extent && (height < (*rule.extent)[0] || height > (*rule.extent)[1])) continue;
    about_axis.push_back(&face);
  }
  const auto fits = [&](const Face* face) {
    const double tolerance = rule.tolerance > 0 ? rule.tolerance : kRelative * *rule.radius;
    return std::abs(face->radius - *rule.radius) <= tolerance;
  };
  std::vector<const Face*> chosen;
  for (const Face* face : about_axis)
    if (!rule.radius || fits(face)) chosen.push_back(face);
  const std::string wanted = fmt::format(
      "cylinder{} about the axis {} through {}", rule.radius ? " of radius " + mm(*rule.radius) : "",
      fmt::format("({:.6g}, {:.6g}, {:.6g})", axis.x(), axis.y(), axis.z()), describe_point_mm(rule.point));
  if (chosen.empty())
    throw std::invalid_argument("no " + wanted + nearest(c.faces, FaceKind::cylinder, [&](const Face& f) {
                                  const double turned = std::acos(std::min(1.0, std::abs(f.axis.dot(axis))));
                                  return distance_to_axis(f.axis_point, rule.point, axis) +
                                         turned * c.diagonal +
                                         (rule.radius ? std::abs(f.radius - *rule.radius) : 0);
                                }));
  if (!rule.radius) {
    const auto [least, most] = std::minmax_element(chosen.begin(), chosen.end(),
                                                   [](auto* a, auto* b) { return a->radius < b->radius; });
    if ((*most)->radius - (*least)->radius > kRelative * (*most)->radius) {
      std::string text = "several radii for the " + wanted + "; state one of:";
      for (const Face* face : chosen) text += "\n  " + describe(*face);
      throw std::invalid_argument(text);
    }
  }
  Selection selection = select_faces(c, chosen);
  put_on_axis(selection, chosen.front()->axis_point, chosen.front()->axis);
  return selection;
}

Selection select_cylinder_cells(const Context& c, const CylinderRule& rule, const Vector3d& axis) {
  if (!rule.radius) throw std::invalid_argument("a cylinder on a mesh without CAD faces needs its radius");
  const double tolerance = rule.tolerance > 0 ? rule.tolerance : kRelative * *rule.radius;
  double nearest_radius = 0, misfit = std::numeric_limits<double>::max();
  Selection selection;
  selection.set = set_of(pick_cells(c.mesh, [&](const CellBlock& block, Index cell, std::size_t) {
    double worst = 0, radius = 0;
    Vector3d middle = Vector3d::Zero();
    for (Eigen::Index k = 0; k < block.nodes.cols(); ++k) {
      const Vector3d p = c.mesh.points.row(block.nodes(cell, k)).transpose();
      const double r = distance_to_axis(p, rule.point, axis);
      worst = std::max(worst, std::abs(r - *rule.radius));
      radius += r / static_cast<double>(block.nodes.cols());
      middle += p / static_cast<double>(block.nodes.cols());
    }
    const double height = axis.dot(middle - rule.point);
    if (rule.extent && (height < (*rule.extent)[0] || height > (*rule.extent)[1])) return false;
    const Vector3d radial = (middle - rule.point - axis * height).normalized();
    if (std::abs(cell_normal(c.mesh, block, cell).dot(radial)) < 0.8)
      return false;  // a disc's ring, not the wall
    if (worst < misfit) {
      misfit = worst;
      nearest_radius = radius;
    }
    return worst <= tolerance;
  }));
  if (selection.set.nodes.empty())
    throw std::invalid_argument(
        fmt::format("no boundary cell lies on the cylinder of radius {} about the axis ({:.6g}, {:.6g}, "
                    "{:.6g}) through {}{}",
                    mm(*rule.radius), axis.x(), axis.y(), axis.z(), describe_point_mm(rule.point),
                    misfit < 1e300 ? "; the nearest lies at radius " + mm(nearest_radius) : ""));
  measure(c.mesh, selection);
  put_on_axis(selection, rule.point, axis);
  selection.description = fmt::format("{} cells on the cylinder of radius {}",
                                      count_cells(selection.set.faces), mm(*rule.radius));
  return selection;
}

}  // namespace

Selection select(const Context& c, const CylinderRule& rule) {
  const Vector3d axis = unit(rule.direction, "direction of the cylinder's axis");
  if (rule.radius && !(*rule.radius > 0))
    throw std::invalid_argument(
        fmt::format("the cylinder's radius {} must be greater than zero", mm(*rule.radius)));
  return c.cad() ? select_cylinder_faces(c, rule, axis) : select_cylinder_cells(c, rule, axis);
}

}  // namespace flexura::mesh::selecting
