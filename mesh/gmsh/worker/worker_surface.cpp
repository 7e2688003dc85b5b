// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_surface.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>

#include "mesh/gmsh/worker/stl.hpp"
#include "mesh/gmsh/worker/triangles.hpp"

namespace flexura::mesh {
namespace {

// Edges sharper than this bound faces; a circle of twelve facets is still one.
constexpr double kSharp = 40.0 * std::numbers::pi / 180.0;
constexpr std::size_t kMostTriangles = 500000;

/// The file's triangles.  Corners nearer to each other than 1e-8 of the part are one; what has less than three is left out.
Triangles take_triangles(const std::string& path, double to_m) {
  const std::vector<double> given = read_stl(path, kMostTriangles);
  if (given.empty()) throw std::runtime_error("holds no triangle; save it again");
  std::vector<std::size_t> tags, cells, nodes;
  for (std::size_t k = 1; k <= given.size() / 3; ++k) tags.push_back(k);
  const int face = gmsh::model::addDiscreteEntity(2);
  gmsh::model::mesh::addNodes(2, face, tags, given);
  gmsh::model::mesh::addElementsByType(face, 2, {}, tags);
  gmsh::model::mesh::removeDuplicateNodes();
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters, -1, -1, false, false);
  gmsh::model::mesh::getElementsByType(2, cells, nodes);
  std::map<std::size_t, int> place;
  Triangles out;
  for (std::size_t k = 0; k < tags.size(); ++k) {
    place[tags[k]] = static_cast<int>(k);
    const Eigen::Vector3d x = to_m * Eigen::Vector3d::Map(&coordinates[3 * k]);
    if (!x.allFinite()) throw std::runtime_error("has a vertex that is not finite; save it again");
    out.points.push_back(x);
  }
  for (std::size_t k = 0; k < cells.size(); ++k) {
    const int a = place.at(nodes[3 * k]), b = place.at(nodes[3 * k + 1]), c = place.at(nodes[3 * k + 2]);
    if (a != b && b != c && c != a) out.corners.push_back({a, b, c});
  }
  return out;
}

/// gmsh finds edges by how triangles are turned, so that it gets them back as they are oriented: numbered from 1.
void give_back(const Triangles& surface, double to_m) {
  gmsh::model::add("surface");
  const int face = gmsh::model::addDiscreteEntity(2);
  std::vector<std::size_t> nodes, cells, corners;
  std::vector<double> coordinates;
  for (std::size_t k = 0; k < surface.points.size(); ++k) {
    nodes.push_back(k + 1);
    for (int i = 0; i < 3; ++i) coordinates.push_back(surface.points[k](i) / to_m);
  }
  gmsh::model::mesh::addNodes(2, face, nodes, coordinates);
  for (std::size_t k = 0; k < surface.corners.size(); ++k) {
    cells.push_back(k + 1);
    for (const int corner : surface.corners[k]) corners.push_back(static_cast<std::size_t>(corner) + 1);
  }
  gmsh::model::mesh::addElementsByType(face, 2, cells, corners);
}

}  // namespace

gmsh::vectorpair import_surface(const Job& job, ResultRecord& result) {
  Triangles surface = take_triangles(job.path, job.to_m);
  orient(surface);
  const std::size_t given = surface.corners.size();
  result.solids = {describe_enclosed(surface)};
  // Needles, as CAD programs write them, are beyond gmsh's maps of the faces.
  double longest = job.size;
  for (std::size_t k = 3; k < job.sizes.size(); k += 4) longest = std::max(longest, job.sizes[k]);
  if (longest > 0) refine(surface, longest, kMostTriangles);
  give_back(surface, job.to_m);
  // The mesh follows the facets: nodes on edges between them would be pushed off curved ones that are not there.
  gmsh::option::setNumber("Mesh.SecondOrderLinear", 1);
  gmsh::model::mesh::classifySurfaces(kSharp, true, false, std::numbers::pi);
  // Of each face its triangles, before it has others.  gmsh numbers faces as it comes upon them, which may be another way
  // round once they are refined: here they go by the first triangle that the file has of them.
  gmsh::vectorpair entities;
  gmsh::model::getEntities(entities, 2);
  std::map<int, std::pair<int, std::vector<int>>> faces;  // entity and triangles
  for (const auto& entity : entities) {
    std::vector<std::size_t> cells, nodes;
    gmsh::model::mesh::getElementsByType(2, cells, nodes, entity.second);
    std::vector<int> which;
    int first = std::numeric_limits<int>::max();
    for (const std::size_t cell : cells) {
      which.push_back(static_cast<int>(cell) - 1);
      first = std::min(first, surface.origin[cell - 1]);
    }
    if (!which.empty()) faces[first] = {entity.second, std::move(which)};
  }
  std::map<int, std::vector<int>> shells;
  for (const auto& [first, face] : faces) {
    const auto& [entity, which] = face;
    shells[surface.piece[static_cast<std::size_t>(which.front())]].push_back(entity);
    result.faces.push_back(describe_facets(surface, which, static_cast<int>(result.faces.size()) + 1));
    result.faces.back().entity = entity;
    result.area += result.faces.back().area;
  }
  gmsh::model::mesh::createGeometry();
  std::vector<int> loops;
  for (const auto& [shell, of] : shells) loops.push_back(gmsh::model::geo::addSurfaceLoop(of));
  const int volume = gmsh::model::geo::addVolume(loops);
  gmsh::model::geo::synchronize();
  result.kept = {1};
  result.volume = result.solids.front().volume;
  result.centroid = result.solids.front().centroid;
  result.messages.push_back("a surface of " + std::to_string(given) + " triangles, cut into " +
                            std::to_string(result.faces.size()) +
                            " faces at edges of more than 40 degrees; the part is what the facets enclose");
  return {{3, volume}};
}

}  // namespace flexura::mesh
