// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker_volume.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/gmsh/size_field.hpp"
#include "mesh/gmsh/worker_progress.hpp"

namespace flexura::mesh {
namespace {

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
  gmsh::option::setNumber("Mesh.MeshSizeExtendFromBoundary", 1);
  result.size = job.size;
  result.size_min = job.size_min;
  result.elements_per_circle = job.elements_per_circle;
  if (!job.sizes.empty())
    gmsh::model::mesh::setSizeCallback(
        [field = SizeField(job.sizes), to_m = job.to_m](int, int, double x, double y, double z) {
          return field.at(x * to_m, y * to_m, z * to_m) / to_m;
        });
  for (int coarser = 0;; ++coarser) {
    gmsh::option::setNumber("Mesh.MeshSizeMax", result.size / job.to_m);
    gmsh::option::setNumber("Mesh.MeshSizeMin", result.size_min / job.to_m);
    gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", std::lround(result.elements_per_circle));
    say(0.1, "meshing edges");
    gmsh::model::mesh::generate(1);
    say(0.15, "meshing faces");
    gmsh::model::mesh::generate(2);
    if (job.most_triangles == 0 || coarser == 5) break;
    std::vector<std::size_t> triangles, nodes;
    gmsh::model::mesh::getElementsByType(2, triangles, nodes);  // linear triangles, before curving
    if (triangles.size() <= static_cast<std::size_t>(job.most_triangles)) break;
    gmsh::model::mesh::clear();
    result.size_min = std::min(1.4 * result.size_min, result.size);
    result.elements_per_circle =
        std::min(result.elements_per_circle, std::max(6.0, 0.85 * result.elements_per_circle));
    result.size *= 1.1;
  }
  say(0.4, "meshing the volume");
  gmsh::model::mesh::generate(3);
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
    elements_of(job.order == 2 ? 9 : 2, face.number, cells, nodes);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      for (std::size_t k = 0; k < 3; ++k) arrays.triangles.push_back(number[nodes[c * n_face + k]]);
      arrays.face.push_back(face.number);
    }
  }
  return arrays;
}

}  // namespace flexura::mesh
