// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_planar.hpp"

#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <stdexcept>

#include "mesh/gmsh/worker/worker_nodes.hpp"

namespace flexura::mesh {
namespace {

constexpr double kModelUnit = 1e-3;  // mm: what OpenCASCADE's tolerances are made for

int draw(const std::vector<double>& corners) {
  std::vector<int> points, lines;
  for (std::size_t k = 0; k + 1 < corners.size(); k += 2)
    points.push_back(gmsh::model::occ::addPoint(corners[k] / kModelUnit, corners[k + 1] / kModelUnit, 0));
  for (std::size_t k = 0; k < points.size(); ++k)
    lines.push_back(gmsh::model::occ::addLine(points[k], points[(k + 1) % points.size()]));
  return gmsh::model::occ::addPlaneSurface({gmsh::model::occ::addCurveLoop(lines)});
}

// The faces of a region, its holes cut out of it wherever they lie: one, or several that a hole parts.
gmsh::vectorpair draw(const std::vector<std::vector<double>>& loops) {
  gmsh::vectorpair faces = {{2, draw(loops.front())}}, holes;
  for (std::size_t k = 1; k < loops.size(); ++k) holes.emplace_back(2, draw(loops[k]));
  if (holes.empty()) return faces;
  gmsh::vectorpair left;
  std::vector<gmsh::vectorpair> map;
  gmsh::model::occ::cut(faces, holes, left, map);
  return left;
}

// The coordinates that span the plane of all faces.
std::array<int, 2> plane_of(const gmsh::vectorpair& faces) {
  std::array<double, 3> low = {1e300, 1e300, 1e300}, high = {-1e300, -1e300, -1e300};
  for (const auto& [dimension, tag] : faces) {
    std::array<double, 6> b;
    gmsh::model::occ::getBoundingBox(dimension, tag, b[0], b[1], b[2], b[3], b[4], b[5]);
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], b[k]);
      high[k] = std::max(high[k], b[k + 3]);
    }
  }
  double size = 0;
  for (int k = 0; k < 3; ++k) size = std::max(size, high[k] - low[k]);
  for (const int normal : {2, 0, 1})
    if (high[normal] - low[normal] < 1e-5 * size) return {(normal + 1) % 3, (normal + 2) % 3};
  throw std::runtime_error(
      "does not lie in one coordinate plane; export the section's face in x-y, y-z or z-x");
}

}  // namespace

void mesh_planar_faces(const Job& job, ResultRecord& result, Arrays& arrays) {
  gmsh::vectorpair faces;
  std::vector<int> numbers_of_faces;  // of each its region, or its place in the file
  if (job.path.empty()) {
    for (std::size_t k = 0; k < job.regions.size(); ++k)
      for (const auto& face : draw(job.regions[k])) {
        faces.push_back(face);
        numbers_of_faces.push_back(static_cast<int>(k));
      }
    if (faces.empty()) throw std::runtime_error("has no area");
  } else {
    gmsh::vectorpair imported;
    gmsh::model::occ::importShapes(job.path, imported, true, job.format);
    for (const auto& entity : imported)
      if (entity.first == 2) {
        numbers_of_faces.push_back(static_cast<int>(faces.size()));
        faces.push_back(entity);
      }
    if (faces.empty()) throw std::runtime_error("holds no face; export the section as a planar face");
  }
  std::map<int, int> region_of;
  for (std::size_t k = 0; k < faces.size(); ++k) region_of[faces[k].second] = numbers_of_faces[k];
  if (faces.size() > 1) {
    gmsh::vectorpair pieces;
    std::vector<gmsh::vectorpair> map;
    gmsh::model::occ::fragment({faces.front()}, {faces.begin() + 1, faces.end()}, pieces, map);
    region_of.clear();
    for (std::size_t k = 0; k < map.size() && k < faces.size(); ++k)
      for (const auto& piece : map[k])
        if (piece.first == 2) region_of.insert({piece.second, numbers_of_faces[k]});  // the first keeps it
    faces.clear();
    for (const auto& [tag, region] : region_of) faces.emplace_back(2, tag);
  }
  gmsh::model::occ::synchronize();
  const std::array<int, 2> axes = plane_of(faces);

  double area = 0, outline = 0, mass = 0;
  for (const auto& face : faces) {
    gmsh::model::occ::getMass(2, face.second, mass);
    area += mass;
  }
  gmsh::vectorpair curves;
  gmsh::model::getBoundary(faces, curves, true, false, false);
  for (const auto& curve : curves) {
    gmsh::model::occ::getMass(1, std::abs(curve.second), mass);
    outline += mass;
  }
  if (!(area > 0) || !(outline > 0)) throw std::runtime_error("has no area");
  // Twice area over outline is the thickness of a thin wall: at least two elements stand across it.
  constexpr double most = 300e3;  // equilateral triangles of the size
  const double coarsest = area / outline, finest = std::sqrt(area / (std::sqrt(3.0) / 4 * most));
  const double wanted = job.size > 0 ? job.size / kModelUnit : std::max(0.5 * coarsest, finest);
  const double size = std::min(wanted, coarsest);
  std::ostringstream text;
  text.precision(3);
  if (finest > coarsest) {
    text << "is too thin for its length: two triangles across its mean thickness, 2 area / outline = "
         << 2 * coarsest << " mm, make more than 300000 of them; give its constants (A, I_yy, ...) instead";
    throw std::runtime_error(text.str());
  }
  if (size < finest) {
    text << "would have some " << most * (finest * finest) / (size * size) << " triangles of the size "
         << size << " mm, at most 300000 are taken; give a size of " << 1.05 * finest << " mm or more";
    throw std::runtime_error(text.str());
  }
  if (wanted > coarsest) {
    text << "size = " << wanted
         << " mm is coarser than half of the section's mean thickness, 2 area / outline = " << 2 * coarsest
         << " mm: meshed with " << size << " mm";
    result.messages.push_back(text.str());
  }
  gmsh::option::setNumber("Mesh.MeshSizeMax", size);
  gmsh::option::setNumber("Mesh.MeshSizeMin", 0.2 * size);
  gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", 24);
  gmsh::model::mesh::generate(2);
  gmsh::model::mesh::setOrder(2);

  NodeNumbers numbers;
  for (const auto& [dimension, tag] : faces) {
    std::vector<std::size_t> cells, nodes;
    gmsh::model::mesh::getElementsByType(9, cells, nodes, tag);
    for (std::size_t c = 0; c < cells.size(); ++c) {
      for (int k = 0; k < 6; ++k) {
        arrays.integers.push_back(numbers.of(nodes[6 * c + k], [&](const double* x) {
          arrays.points.insert(arrays.points.end(), {x[axes[0]] * kModelUnit, x[axes[1]] * kModelUnit, 0.0});
        }));
      }
      arrays.integers.push_back(region_of.at(tag));
    }
  }
  if (arrays.integers.empty()) throw std::runtime_error("gave no triangles");
}

}  // namespace flexura::mesh
