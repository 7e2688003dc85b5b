// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_volume.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "mesh/gmsh/size_field.hpp"
#include "mesh/gmsh/worker/worker_progress.hpp"

namespace flexura::mesh {
namespace {

/// Sizes that grow from those of the pieces of the edges by a quarter of the way: gmsh by itself gives a face the sizes
/// of its edges throughout, which on a tooth drawn as a hundred short edges fills the whole part with small elements.
void grade_from_edges() {
  std::vector<std::size_t> tags, pieces, ends;
  std::vector<double> coordinates, parameters, points;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters, -1, -1, false, false);
  std::map<std::size_t, Eigen::Vector3d> place;
  for (std::size_t k = 0; k < tags.size(); ++k) place[tags[k]] = Eigen::Vector3d::Map(&coordinates[3 * k]);
  gmsh::model::mesh::getElementsByType(1, pieces, ends);
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const Eigen::Vector3d a = place[ends[2 * k]], b = place[ends[2 * k + 1]], middle = 0.5 * (a + b);
    if (!(a - b).isZero(0.0))
      points.insert(points.end(), {middle.x(), middle.y(), middle.z(), (a - b).norm()});
  }
  if (points.empty()) return;
  constexpr double kGrowth = 0.25;
  gmsh::model::mesh::setSizeCallback([field = SizeField(points)](int, int, double x, double y, double z) {
    double distance = 0.0;
    const double size = field.at(x, y, z, &distance);
    return size + kGrowth * distance;
  });
}

std::size_t count_elements(int type) {
  std::vector<std::size_t> cells, nodes;
  gmsh::model::mesh::getElementsByType(type, cells, nodes);
  return cells.size();
}

/// Elements of one type on one entity.  gmsh takes vectors that are not empty for memory of the right size.
void elements_of(int type, int tag, std::vector<std::size_t>& cells, std::vector<std::size_t>& nodes) {
  cells.clear();
  nodes.clear();
  gmsh::model::mesh::getElementsByType(type, cells, nodes, tag);
}

}  // namespace

void generate_mesh(const Job& job, ResultRecord& result) {
  gmsh::option::setNumber("Mesh.Algorithm", job.surface_algorithm);
  gmsh::option::setNumber("Mesh.Algorithm3D", 1);
  gmsh::option::setNumber("Mesh.OptimizeThreshold", 0.7);  // 0.3 leaves slivers, 0.8 gains nothing more
  result.size = job.size;
  result.size_min = job.size_min;
  result.elements_per_circle = job.elements_per_circle;
  if (!job.sizes.empty())
    gmsh::model::mesh::setSizeCallback(
        [field = SizeField(job.sizes), to_m = job.to_m](int, int, double x, double y, double z) {
          return field.at(x * to_m, y * to_m, z * to_m) / to_m;
        });
  constexpr int kMostTries = 6;
  std::string note = job.note;
  for (int tries = 1;; ++tries) {
    gmsh::option::setNumber("Mesh.MeshSizeMax", result.size / job.to_m);
    gmsh::option::setNumber("Mesh.MeshSizeMin", result.size_min / job.to_m);
    gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", std::round(result.elements_per_circle));
    say(0.1, "meshing edges" + note);
    gmsh::model::mesh::generate(1);
    say(0.15, "meshing faces" + note);
    if (result.graded) grade_from_edges();
    // Where sizes are given everywhere, those of the boundary are not spread over what it bounds.
    const bool spread = !result.graded && job.sizes.empty();
    gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", spread ? 1 : 0);
    gmsh::model::mesh::generate(2);
    if (result.graded) gmsh::model::mesh::removeSizeCallback();
    gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", job.sizes.empty() ? 1 : 0);
    const bool bounded = tries < kMostTries;
    const std::size_t triangles = count_elements(2);  // linear, before curving
    bool too_many =
        bounded && job.most_triangles > 0 && triangles > static_cast<std::size_t>(job.most_triangles);
    if (!too_many) {
      say(0.4, "meshing the volume" + note);
      gmsh::model::mesh::generate(3);
      too_many = bounded && job.most_tetrahedra > 0 &&
                 count_elements(4) > static_cast<std::size_t>(job.most_tetrahedra);
    }
    if (!too_many) break;
    gmsh::model::mesh::clear();
    if (!result.graded && job.sizes.empty()) {
      result.graded = true;
      note = job.note + ", sizes growing away from short edges";
      continue;
    }
    result.size_min = std::min(1.4 * result.size_min, result.size);
    result.elements_per_circle =
        std::min(result.elements_per_circle, std::max(6.0, 0.85 * result.elements_per_circle));
    result.size *= 1.1;
    char text[80];
    std::snprintf(text, sizeof text, ", sizes raised to %.4g mm", 1e3 * result.size);
    note = job.note + text;
  }
  if (job.order == 2) {
    say(0.8, "curving to quadratic elements");
    gmsh::model::mesh::setOrder(2);
  }
  say(0.95, "handing over");
}

Arrays collect_mesh(const Job& job, const gmsh::vectorpair& solids, const ResultRecord& result) {
  Arrays arrays;
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters, -1, -1, false, false);
  std::size_t greatest = 0;
  for (const std::size_t tag : tags) greatest = std::max(greatest, tag);
  std::vector<std::int32_t> number(greatest + 1, -1);

  // gmsh orders a tet10's last two edges 2-3, 1-3; Mesh has 1-3, 2-3.
  static constexpr int kOrder[10] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
  const std::size_t n = job.order == 2 ? 10 : 4;
  std::vector<std::size_t> cells, nodes;
  for (const auto& solid : solids) {
    elements_of(job.order == 2 ? 11 : 4, solid.second, cells, nodes);
    for (std::size_t c = 0; c < cells.size(); ++c)
      for (std::size_t k = 0; k < n; ++k) {
        number[nodes[c * n + kOrder[k]]] = 0;
        arrays.tetrahedra.push_back(static_cast<std::int32_t>(nodes[c * n + kOrder[k]]));
      }
  }
  for (std::size_t k = 0; k < tags.size(); ++k) {
    if (number[tags[k]] < 0) continue;
    number[tags[k]] = static_cast<std::int32_t>(arrays.points.size() / 3);
    for (int i = 0; i < 3; ++i) arrays.points.push_back(coordinates[3 * k + i] * job.to_m);
  }
  for (std::int32_t& node : arrays.tetrahedra) node = number[node];
  const std::size_t n_face = job.order == 2 ? 6 : 3;
  for (const FaceRecord& face : result.faces) {
    elements_of(job.order == 2 ? 9 : 2, face.entity > 0 ? face.entity : face.number, cells, nodes);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      for (std::size_t k = 0; k < 3; ++k) arrays.triangles.push_back(number[nodes[c * n_face + k]]);
      arrays.face.push_back(face.number);
    }
  }
  return arrays;
}

}  // namespace flexura::mesh
