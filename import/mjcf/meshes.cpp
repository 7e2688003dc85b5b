// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/meshes.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "import/mjcf/hull.hpp"
#include "import/model/folder.hpp"
#include "import/urdf/mesh_file.hpp"
#include "import/xml/values.hpp"
#include "mbs/base/files/inputs.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::mjcf {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& why) {
  throw std::invalid_argument(why);
}

// MuJoCo's own: numbers of vertices, normals, texture coordinates and faces, then these, 4 bytes each.
Surface read_msh(const fs::path& file) {
  files::note_input(file);
  std::ifstream in(file, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  std::int32_t n[4] = {};
  if (bytes.size() >= sizeof n) std::memcpy(n, bytes.data(), sizeof n);
  std::size_t size = sizeof n;
  for (int k = 0; k < 4; ++k) {
    if (n[k] < 0) refuse(file.string() + ": is no mesh of MuJoCo's: a negative count; write the file anew");
    size += static_cast<std::size_t>(n[k]) * (k == 2 ? 2 : 3) * 4;
  }
  if (n[0] < 1 || size != bytes.size())
    refuse(file.string() +
           ": is no mesh of MuJoCo's: its length is not what its counts say; save it as STL or OBJ");
  Surface surface;
  for (int v = 0; v < n[0]; ++v) {
    float x[3];
    std::memcpy(x, bytes.data() + sizeof n + 12 * static_cast<std::size_t>(v), sizeof x);
    surface.vertices.emplace_back(x[0], x[1], x[2]);
  }
  for (int t = 0; t < n[3]; ++t) {
    std::int32_t c[3];
    std::memcpy(c, bytes.data() + bytes.size() - 12 * static_cast<std::size_t>(n[3] - t), sizeof c);
    for (const std::int32_t v : c)
      if (v < 0 || v >= n[0])
        refuse(file.string() + ": a face names a vertex that is not there; write the file anew");
    surface.triangles.emplace_back(c[0], c[1], c[2]);
  }
  return surface;
}

fs::path file_of(const Node& mesh, const Model& model) {
  std::string name = mesh.get("file");
  if (model.compiler.strip_path) name = fs::path(name).filename().string();
  const fs::path folder = model.file.parent_path();
  const fs::path named = folder / model.compiler.mesh_folder / name;
  std::error_code none;
  // As the compiler finds it, then beside the file.
  for (const fs::path& file : {named, folder / name, folder / fs::path(name).filename()})
    if (fs::is_regular_file(file, none)) return file;
  refuse(fmt::format("the file \"{}\" is not there ({}); put it there, or give the body an <inertial>",
                     shown(name), named.lexically_normal().string()));
}

Surface inline_surface(const Node& mesh) {
  const auto x = xml::parse_numbers(mesh.get("vertex"));
  if (!x || x->size() % 3 != 0 || x->size() < 12)
    refuse("its vertices are not four or more points; give three numbers for each");
  Surface surface;
  for (std::size_t i = 0; i < x->size(); i += 3)
    surface.vertices.emplace_back((*x)[i], (*x)[i + 1], (*x)[i + 2]);
  if (!mesh.has("face")) return convex_hull(surface.vertices);
  const auto corners = xml::parse_numbers(mesh.get("face"));
  if (!corners || corners->size() % 3 != 0)
    refuse("its faces are not three numbers each; give the vertices of triangles");
  for (std::size_t i = 0; i < corners->size(); i += 3) {
    Eigen::Vector3i t;
    for (int k = 0; k < 3; ++k) {
      const double c = (*corners)[i + static_cast<std::size_t>(k)];
      if (!(c >= 0.0) || c >= static_cast<double>(surface.vertices.size()))
        refuse("a face names a vertex that is not there; give vertices from 0 on");
      t[k] = static_cast<int>(c);
    }
    surface.triangles.push_back(t);
  }
  return surface;
}

tree::Inertial legacy(const Surface& surface, double density) {
  const auto corner = [&](const Eigen::Vector3i& t, int k) {
    return surface.vertices[static_cast<std::size_t>(t[k])];
  };
  double area = 0.0;
  Vector3d center = Vector3d::Zero();
  for (const Eigen::Vector3i& t : surface.triangles) {
    const Vector3d a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
    const double s = 0.5 * (b - a).cross(c - a).norm();
    area += s;
    center += s / 3.0 * (a + b + c);
  }
  if (!(area > 0.0)) return {};
  center /= area;
  tree::Inertial sum;
  for (const Eigen::Vector3i& t : surface.triangles) {
    tree::Solid tetrahedron{.kind = tree::Solid::Kind::surface};
    tetrahedron.surface.vertices = {center, corner(t, 0), corner(t, 1), corner(t, 2)};
    tetrahedron.surface.triangles = {{1, 2, 3}};
    sum = tree::together(sum, tree::uniform(tetrahedron, density));
  }
  return sum;
}

tree::Inertial shell(const Surface& surface, double density) {
  // Three points in the middles of the edges weigh a triangle exactly to the second order.
  double mass = 0.0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (const Eigen::Vector3i& t : surface.triangles) {
    Vector3d x[3];
    for (int k = 0; k < 3; ++k) x[k] = surface.vertices[static_cast<std::size_t>(t[k])];
    const double m = density * 0.5 * (x[1] - x[0]).cross(x[2] - x[0]).norm();
    mass += m;
    for (int k = 0; k < 3; ++k) {
      const Vector3d middle = 0.5 * (x[k] + x[(k + 1) % 3]);
      first += m / 3.0 * middle;
      second += m / 3.0 * middle * middle.transpose();
    }
  }
  if (!(mass > 0.0)) return {};
  const Vector3d c = first / mass;
  const Matrix3d S = second - mass * c * c.transpose();
  return {mass, c, S.trace() * Matrix3d::Identity() - S};
}

}  // namespace

Surface read_mesh(const Node& mesh, const Model& model) {
  Surface surface;
  if (mesh.has("vertex")) {
    surface = inline_surface(mesh);
  } else if (mesh.has("builtin")) {
    refuse(fmt::format("a builtin mesh (\"{}\") is not read; give its points, or the body an <inertial>",
                       shown(mesh.get("builtin"))));
  } else {
    const fs::path file = file_of(mesh, model);
    surface = ending_of(file) == ".msh" ? read_msh(file) : urdf::read_surface(file);
    if (surface.triangles.empty()) surface = convex_hull(surface.vertices);
  }
  Findings findings(*mesh.file);
  const Vector3d scale = xml::vector(mesh, "scale", Vector3d::Ones(), findings),
                 origin = xml::vector(mesh, "refpos", Vector3d::Zero(), findings);
  const std::vector<double> q = xml::numbers(mesh, "refquat", findings);
  findings.require_no_fault();
  const Matrix3d R = q.size() == 4 ? mbs::rotation_of_quaternion(q.data()) : Matrix3d(Matrix3d::Identity());
  for (Vector3d& v : surface.vertices) v = (R.transpose() * (v - origin)).cwiseProduct(scale);
  if (scale.prod() < 0.0)
    for (Eigen::Vector3i& t : surface.triangles) std::swap(t[1], t[2]);
  return surface;
}

tree::Inertial mesh_inertial(const Surface& surface, const std::string& rule, double density) {
  if (rule == "shell") return shell(surface, density);
  if (rule == "legacy") return legacy(surface, density);
  tree::Solid solid{.kind = tree::Solid::Kind::surface};
  solid.surface = rule == "convex" ? convex_hull(surface.vertices) : surface;
  return tree::uniform(solid, density);
}

}  // namespace flexura::import::mjcf
