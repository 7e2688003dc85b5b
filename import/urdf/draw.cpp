// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/draw.hpp"

#include <fmt/format.h>

#include <new>
#include <stdexcept>

#include "import/model/folder.hpp"
#include "import/urdf/link_parts.hpp"
#include "import/urdf/mesh_file.hpp"

namespace flexura::import::urdf {
namespace {

// Of all shapes: many links can show one file.
constexpr std::size_t kMostTriangles = 10'000'000;

bool is_step(const std::filesystem::path& file) {
  const std::string ending = ending_of(file);
  return ending == ".step" || ending == ".stp";
}

bool is_plain(const Shape& shape) {
  return shape.kind != Shape::Kind::mesh &&
         (shape.kind != Shape::Kind::box || (shape.X_LS.R - Matrix3d::Identity()).isZero(0.0));
}

// The solids of the mechanism file: of a capsule three.
std::vector<std::vector<Line>> solids_of(const Shape& shape) {
  const Vector3d half = shape.X_LS.R.col(2) * (0.5 * shape.length);
  const auto sphere = [&](const Vector3d& center) {
    return std::vector<Line>{
        {"type", toml(std::string("sphere"))}, {"center", toml(center)}, {"radius", toml(shape.radius)}};
  };
  std::vector<std::vector<Line>> out;
  if (shape.kind == Shape::Kind::box)
    out.push_back(
        {{"type", toml(std::string("box"))}, {"center", toml(shape.X_LS.p)}, {"size", toml(shape.size)}});
  if (shape.kind == Shape::Kind::cylinder || shape.kind == Shape::Kind::capsule)
    out.push_back({{"type", toml(std::string("cylinder"))},
                   {"from", toml(Vector3d(shape.X_LS.p - half))},
                   {"to", toml(Vector3d(shape.X_LS.p + half))},
                   {"radius", toml(shape.radius)}});
  if (shape.kind == Shape::Kind::capsule)
    for (const double side : {-1.0, 1.0}) out.push_back(sphere(shape.X_LS.p + side * half));
  if (shape.kind == Shape::Kind::sphere) out.push_back(sphere(shape.X_LS.p));
  if (!shape.color.empty())
    for (std::vector<Line>& lines : out) lines.emplace_back("color", toml(shape.color));
  return out;
}

}  // namespace

// Throws std::exception of any kind: of the file, or of the child that reads CAD files.
Surface Drawer::mesh_of(const Shape& shape) {
  // Before another one is read.
  if (n_triangles_ > kMostTriangles)
    throw std::invalid_argument(
        fmt::format("the pictures before it hold {} triangles, at most so many are taken", kMostTriangles));
  const std::filesystem::path file = find_mesh(shape.mesh, file_, choices_.packages);
  Surface mesh = is_step(file) && choices_.read_cad ? choices_.read_cad(file) : read_surface(file);
  for (Vector3d& v : mesh.vertices) v = v.cwiseProduct(shape.size);
  if (shape.size.prod() < 0.0)  // mirrored
    for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  n_triangles_ += mesh.triangles.size();
  return mesh;
}

void Drawer::draw(const Link& link, Body& body, Findings& findings) {
  for (const Shape& shape : link.visuals) {
    if (is_plain(shape)) {
      for (std::vector<Line>& solid : solids_of(shape)) body.shapes.push_back(std::move(solid));
    } else if (!(body.mass > 0.0)) {
      findings.note(
          "pictures of links without mass",
          fmt::format("link \"{}\" has no mass and its mesh no picture: only bodies with mass carry "
                      "one",
                      shown(link.name)));
    } else if (shape.kind == Shape::Kind::box) {
      body.surface.append(box_surface(0.5 * shape.size), shape.X_LS);
    } else {
      try {
        body.surface.append(mesh_of(shape), shape.X_LS);
      } catch (const std::bad_alloc&) {
        throw;
      } catch (const std::exception& why) {
        findings.note("pictures that are not read",
                      fmt::format("link \"{}\" without that picture: {}", shown(link.name), why.what()));
      }
    }
  }
}

MassProperties Drawer::filled(const std::vector<Shape>& shapes) {
  MassProperties all;
  for (const Shape& shape : shapes) {
    MassProperties one;
    switch (shape.kind) {
      case Shape::Kind::box:
        one = box_properties(shape.size);
        break;
      case Shape::Kind::cylinder:
        one = cylinder_properties(shape.radius, shape.length);
        break;
      case Shape::Kind::capsule:
        one = capsule_properties(shape.radius, shape.length);
        break;
      case Shape::Kind::sphere:
        one = sphere_properties(shape.radius);
        break;
      case Shape::Kind::mesh:
        try {
          if (const Surface mesh = mesh_of(shape); is_closed(mesh)) one = surface_properties(mesh);
        } catch (const std::bad_alloc&) {
          throw;
        } catch (const std::exception&) {  // said where it is drawn
        }
    }
    if (one.mass > 0.0) all = all.mass > 0.0 ? all + one.in(shape.X_LS) : one.in(shape.X_LS);
  }
  return all;
}

}  // namespace flexura::import::urdf
