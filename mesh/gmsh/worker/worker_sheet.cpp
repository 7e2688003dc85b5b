// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_sheet.hpp"

#include <gmsh.h>

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "mesh/gmsh/worker/worker_describe.hpp"
#include "mesh/gmsh/worker/worker_nodes.hpp"
#include "mesh/model/mesh.hpp"

namespace flexura::mesh {
namespace {

gmsh::vectorpair import_faces(const Job& job) {
  gmsh::vectorpair imported, faces;
  gmsh::model::occ::importShapes(job.path, imported, true, job.format);
  std::size_t solids = 0, curves = 0;
  for (const auto& entity : imported) {
    solids += entity.first == 3, curves += entity.first == 1;
    if (entity.first == 2) faces.push_back(entity);
  }
  const auto many = [](std::size_t n, const char* what) {
    return std::to_string(n) + " " + what + (n == 1 ? "" : "s");
  };
  if (solids > 0)
    throw std::runtime_error(
        "holds " + many(solids, "solid") +
        ", where [shell] wants the faces of a sheet's middle surface: export these faces, or leave [shell] "
        "out to mesh the solid");
  if (faces.empty())
    throw std::runtime_error("holds no faces, only " + many(curves, "curve") +
                             ", where [shell] wants the faces of a sheet's middle surface");
  if (faces.size() == 1) return faces;
  // Faces that meet share their edges afterwards, where one ends on another too.
  gmsh::option::setNumber("Geometry.ToleranceBoolean", 1e-4);  // mm
  gmsh::vectorpair joined;
  std::vector<gmsh::vectorpair> map;
  gmsh::model::occ::fragment({faces.front()}, {faces.begin() + 1, faces.end()}, joined, map);
  faces.clear();
  for (const auto& entity : joined)
    if (entity.first == 2) faces.push_back(entity);
  return faces;
}

}  // namespace

void mesh_sheet(const Job& job, ResultRecord& result, Arrays& arrays) {
  const gmsh::vectorpair faces = import_faces(job);
  gmsh::model::occ::synchronize();
  for (const auto& face : faces) {
    result.faces.push_back(describe_face(face.second, 0, job.to_m));
    result.area += result.faces.back().area;
  }
  gmsh::vectorpair curves;
  gmsh::model::getBoundary(faces, curves, true, false, false);
  for (const auto& curve : curves) {  // the free edges
    double length = 0;
    gmsh::model::occ::getMass(1, std::abs(curve.second), length);
    result.outline += length * job.to_m;
  }
  if (!(job.size > 0)) return;

  result.size = job.size, result.size_min = job.size_min,
  result.elements_per_circle = job.elements_per_circle;
  const bool triangles = job.surface_algorithm == 1;
  gmsh::option::setNumber("Mesh.Algorithm", job.surface_algorithm);
  gmsh::option::setNumber("Mesh.RecombineAll", triangles ? 0 : 1);
  gmsh::option::setNumber("Mesh.RecombinationAlgorithm", 1);  // blossom
  gmsh::option::setNumber("Mesh.MeshSizeMax", job.size / job.to_m);
  gmsh::option::setNumber("Mesh.MeshSizeMin", job.size_min / job.to_m);
  gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", std::round(job.elements_per_circle));
  gmsh::model::mesh::generate(2);

  NodeNumbers numbers;
  const std::pair<int, CellType> types[] = {{3, CellType::quad4}, {2, CellType::tri3}};
  for (const auto& [type, ours] : types) {
    std::vector<std::int64_t> labels, cells_nodes;
    for (const auto& face : faces) {
      std::vector<std::size_t> cells, nodes;
      gmsh::model::mesh::getElementsByType(type, cells, nodes, face.second);
      labels.insert(labels.end(), cells.size(), face.second);
      for (const std::size_t node : nodes)
        cells_nodes.push_back(numbers.of(node, [&](const double* x) {
          for (int i = 0; i < 3; ++i) arrays.points.push_back(x[i] * job.to_m);
        }));
    }
    if (labels.empty()) continue;
    result.blocks.push_back({static_cast<int>(ours), labels.size()});
    arrays.integers.insert(arrays.integers.end(), labels.begin(), labels.end());
    arrays.integers.insert(arrays.integers.end(), cells_nodes.begin(), cells_nodes.end());
  }
  if (result.blocks.empty()) throw std::runtime_error("gave no cells");
}

}  // namespace flexura::mesh
