// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_surface_patch.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>

namespace flexura::mbs {
namespace {

using input::Section;
using superelement::Superelement;
using InRegion = std::function<bool(int triangle)>;

Vector3d corner(const Superelement& se, int triangle, int k) {
  return se.surface.vertices.row(se.surface.triangles(triangle, k)).transpose();
}

/// Its normal, as long as its area.
Vector3d area_vector(const Superelement& se, int triangle) {
  const Vector3d a = corner(se, triangle, 0);
  return 0.5 * (corner(se, triangle, 1) - a).cross(corner(se, triangle, 2) - a);
}

InRegion in_interfaces(const Section& s, const std::string& key, const Superelement& se) {
  std::vector<int> wanted;
  for (const std::string& name : s.texts(key)) {
    std::vector<std::string> known;
    int found = -1;
    for (std::size_t i = 0; i < se.interfaces.size(); ++i) {
      known.push_back(se.interfaces[i].name);
      if (se.interfaces[i].name == name) found = static_cast<int>(i);
    }
    if (found < 0)
      s.refuse(key, fmt::format("the body has no interface \"{}\"{}", name, input::suggestion(name, known)));
    if (std::ranges::find(se.surface.triangle_interface, found) == se.surface.triangle_interface.end())
      s.refuse(key, fmt::format("no facet of the surface belongs to \"{}\"", name),
               "name one that is a face, or say by box and facing where the body touches");
    wanted.push_back(found);
  }
  return [wanted, &se](int t) {
    return std::ranges::find(wanted, se.surface.triangle_interface[static_cast<std::size_t>(t)]) !=
           wanted.end();
  };
}

InRegion in_box(const Section& s, const std::string& key, const Superelement& se) {
  const std::vector<Vector3d> corners = s.vectors3(key);
  if (corners.size() != 2)
    s.refuse(key, fmt::format("has {} points", corners.size()), "give two opposite corners");
  const Vector3d low = corners[0].cwiseMin(corners[1]), high = corners[0].cwiseMax(corners[1]);
  // What lies on a side of the box lies in it.
  const double round_off = 1e-9 * se.surface.vertices.cwiseAbs().maxCoeff();
  return [=, &se](int t) {
    for (int k = 0; k < 3; ++k) {
      const Vector3d x = corner(se, t, k);
      if (((x - low).array() < -round_off).any() || ((high - x).array() < -round_off).any()) return false;
    }
    return true;
  };
}

InRegion facing(const Section& s, const std::string& key, const Superelement& se) {
  const Vector3d along = s.vector3(key);
  if (!(along.norm() > 0.0)) s.refuse(key, "has no length", "write for example [0, 0, -1]");
  const double least = std::cos(s.quantity(key + "_angle"));
  return [=, &se](int t) {
    const Vector3d n = area_vector(se, t);
    return n.dot(along) >= least * n.norm() * along.norm();
  };
}

/// The triangles that lie in all that the section names, and their corners with the areas around them.
PatchOfSurface read_part(const Section& s, const SurfaceKeys& keys, const Superelement& se, bool deforms,
                         std::vector<int>& triangles) {
  const auto n_v = se.surface.vertices.rows();
  if (n_v == 0 || se.surface.triangles.rows() == 0 || (deforms && se.shapes.rows() != 3 * n_v))
    s.refuse(keys.body, "its superelement has no surface with shapes on it",
             "reduce the part from its CAD file or mesh (foreign matrices bring none)");
  std::vector<InRegion> regions;
  std::string last;
  const auto add = [&](const char* name,
                       InRegion (*read)(const Section&, const std::string&, const Superelement&)) {
    const std::string key = keys.prefix + name;
    if (!s.has(key)) return;
    regions.push_back(read(s, key, se));
    last = key;
  };
  add("interfaces", in_interfaces);
  add("box", in_box);
  add("facing", facing);
  if (s.has(keys.prefix + "facing_angle") && !s.has(keys.prefix + "facing"))
    s.refuse(keys.prefix + "facing_angle", "is the angle around a direction",
             "give " + keys.prefix + "facing, too");

  Eigen::VectorXd area = Eigen::VectorXd::Zero(n_v);
  for (int t = 0; t < se.surface.triangles.rows(); ++t) {
    if (!std::ranges::all_of(regions, [t](const InRegion& region) { return region(t); })) continue;
    const double third = area_vector(se, t).norm() / 3.0;
    if (third > 0.0) triangles.push_back(t);
    for (int k = 0; k < 3; ++k) area(se.surface.triangles(t, k)) += third;
  }
  PatchOfSurface out;
  for (Eigen::Index v = 0; v < n_v; ++v)
    if (area(v) > 0.0) out.vertices.push_back(static_cast<int>(v));
  if (out.vertices.empty()) {
    const Eigen::RowVector3d low = se.surface.vertices.colwise().minCoeff(),
                             high = se.surface.vertices.colwise().maxCoeff();
    s.refuse(
        last,
        fmt::format("no facet of the surface lies there; the body reaches from [{:.4g}, {:.4g}, {:.4g}] to "
                    "[{:.4g}, {:.4g}, {:.4g}] m",
                    low.x(), low.y(), low.z(), high.x(), high.y(), high.z()),
        "let the region hold whole facets, in the body's own frame");
  }
  out.area.resize(static_cast<Eigen::Index>(out.vertices.size()));
  for (std::size_t j = 0; j < out.vertices.size(); ++j)
    out.area(static_cast<Eigen::Index>(j)) = area(out.vertices[j]);
  return out;
}

Eigen::Matrix3Xd places(const PatchOfSurface& part, const Superelement& se) {
  Eigen::Matrix3Xd x(3, part.vertices.size());
  for (Eigen::Index j = 0; j < x.cols(); ++j)
    x.col(j) = se.surface.vertices.row(part.vertices[static_cast<std::size_t>(j)]).transpose();
  return x;
}

}  // namespace

PatchOfSurface read_surface_patch(const Section& s, const Superelement& se, bool deforms) {
  std::vector<int> triangles;
  PatchOfSurface out = read_part(s, {"body", ""}, se, deforms, triangles);
  out.patch = std::make_shared<SurfacePatch>(places(out, se), out.area, out.vertices);
  return out;
}

PatchOfSurface read_touched_surface(const Section& s, const Superelement& se, bool deforms,
                                    const SurfaceKeys& keys) {
  std::vector<int> triangles;
  PatchOfSurface out = read_part(s, keys, se, deforms, triangles);
  std::vector<int> place(static_cast<std::size_t>(se.surface.vertices.rows()), -1);
  for (std::size_t j = 0; j < out.vertices.size(); ++j)
    place[static_cast<std::size_t>(out.vertices[j])] = static_cast<int>(j);
  Eigen::Matrix3Xi facets(3, triangles.size());
  for (Eigen::Index t = 0; t < facets.cols(); ++t)
    for (int k = 0; k < 3; ++k)
      facets(k, t) =
          place[static_cast<std::size_t>(se.surface.triangles(triangles[static_cast<std::size_t>(t)], k))];
  out.mesh = std::make_shared<SurfaceMesh>(places(out, se), facets);
  return out;
}

Eigen::MatrixXd shapes_of(const PatchOfSurface& part, const Superelement& se) {
  Eigen::MatrixXd Phi(3 * part.vertices.size(), se.n());
  for (std::size_t j = 0; j < part.vertices.size(); ++j)
    Phi.middleRows<3>(3 * static_cast<Eigen::Index>(j)) =
        se.shapes.middleRows(3 * part.vertices[j], 3).cast<double>();
  return Phi;
}

Eigen::MatrixXd tractions(const PatchOfSurface& part, const Superelement& se) {
  Eigen::MatrixXd p = Eigen::MatrixXd::Zero(se.n(), 3);
  for (std::size_t j = 0; j < part.vertices.size(); ++j)
    p += part.area(static_cast<Eigen::Index>(j)) *
         se.shapes.middleRows(3 * part.vertices[j], 3).cast<double>().transpose();
  return p;
}

}  // namespace flexura::mbs
