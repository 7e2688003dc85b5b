// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_describe.hpp"

#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "mesh/gmsh/worker/recognise.hpp"

namespace flexura::mesh {
namespace {

Eigen::Vector3d scaled(double x, double y, double z, double to_m) {
  return Eigen::Vector3d(x, y, z) * to_m;
}

std::array<double, 6> box_of(int dimension, int tag, double to_m) {
  double a, b, c, d, e, f;
  gmsh::model::occ::getBoundingBox(dimension, tag, a, b, c, d, e, f);
  return {a * to_m, b * to_m, c * to_m, d * to_m, e * to_m, f * to_m};
}

}  // namespace

std::array<double, 3> as_array(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

std::string label_of(int dimension, int tag) {
  std::string label;
  gmsh::model::getEntityName(dimension, tag, label);
  return label.substr(label.rfind('/') + 1);  // npos + 1 = 0
}

SolidRecord describe_solid(int tag, double to_m) {
  SolidRecord solid;
  solid.number = tag;
  double mass, x, y, z;
  gmsh::model::occ::getMass(3, tag, mass);
  gmsh::model::occ::getCenterOfMass(3, tag, x, y, z);
  std::vector<double> inertia;
  gmsh::model::occ::getMatrixOfInertia(3, tag, inertia);
  solid.volume = mass * std::pow(to_m, 3);
  solid.centroid = as_array(scaled(x, y, z, to_m));
  for (std::size_t k = 0; k < 9 && k < inertia.size(); ++k) solid.inertia[k] = inertia[k] * std::pow(to_m, 5);
  solid.box = box_of(3, tag, to_m);
  return solid;
}

bool coincide(const SolidRecord& a, const SolidRecord& b) {
  double size = 0, apart = 0, inertia_apart = 0, inertia_size = 0;
  for (int k = 0; k < 3; ++k) {
    size = std::max(size, a.box[k + 3] - a.box[k]);
    apart = std::max({apart, std::abs(a.centroid[k] - b.centroid[k]), std::abs(a.box[k] - b.box[k]),
                      std::abs(a.box[k + 3] - b.box[k + 3])});
  }
  for (int k = 0; k < 9; ++k) {
    inertia_apart = std::max(inertia_apart, std::abs(a.inertia[k] - b.inertia[k]));
    inertia_size = std::max(inertia_size, std::abs(a.inertia[k]));
  }
  return apart < 1e-6 * size && std::abs(a.volume - b.volume) < 1e-6 * std::abs(a.volume) &&
         inertia_apart < 1e-5 * inertia_size;
}

FaceRecord describe_face(int tag, int solid, double to_m) {
  Face face;
  std::vector<double> low, high;
  gmsh::model::getParametrizationBounds(2, tag, low, high);
  constexpr int n = 9;
  std::vector<double> uv;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      uv.push_back(low[0] + (high[0] - low[0]) * i / (n - 1));
      uv.push_back(low[1] + (high[1] - low[1]) * j / (n - 1));
    }
  std::vector<double> xyz, nnn;
  gmsh::model::getValue(2, tag, uv, xyz);
  gmsh::model::getNormal(tag, uv, nnn);
  std::vector<Eigen::Vector3d> points, normals;
  for (std::size_t k = 0; k + 2 < xyz.size() && k + 2 < nnn.size(); k += 3) {
    const Eigen::Vector3d normal(nnn[k], nnn[k + 1], nnn[k + 2]);
    if (!normal.allFinite() || std::abs(normal.norm() - 1) > 1e-6) continue;  // a pole of the parametrisation
    points.push_back(scaled(xyz[k], xyz[k + 1], xyz[k + 2], to_m));
    normals.push_back(normal);
  }
  Eigen::Matrix<double, Eigen::Dynamic, 3> P(points.size(), 3), N(points.size(), 3);
  for (std::size_t k = 0; k < points.size(); ++k) {
    P.row(k) = points[k].transpose();
    N.row(k) = normals[k].transpose();
  }
  recognise(P, N, face);

  FaceRecord record;
  record.number = tag;
  record.solid = solid;
  record.kind = static_cast<int>(face.kind);
  record.name = label_of(2, tag);
  double area, x, y, z;
  gmsh::model::occ::getMass(2, tag, area);
  gmsh::model::occ::getCenterOfMass(2, tag, x, y, z);
  record.area = area * to_m * to_m;
  record.centroid = as_array(scaled(x, y, z, to_m));
  record.normal = as_array(face.normal);
  record.axis_point = as_array(face.axis_point);
  record.axis = as_array(face.axis);
  record.radius = face.radius;
  record.length = face.length;
  record.hole = face.hole;
  if (face.radius > 0 && face.length > 0) {
    // Cone: the slant is longer than the height by 1/cos(half angle), and |n . a| = sin(half angle).
    const double sine = face.kind == FaceKind::cone ? std::abs(N.row(0).dot(face.axis)) : 0;
    const double slant = face.length / std::sqrt(std::max(1e-12, 1 - sine * sine));
    record.sweep = std::min(2 * std::numbers::pi, record.area / (face.radius * slant));
  }
  record.box = box_of(2, tag, to_m);
  return record;
}

}  // namespace flexura::mesh
