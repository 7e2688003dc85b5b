// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_picture.hpp"

#include <gmsh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "mesh/gmsh/worker/worker_progress.hpp"

namespace flexura::mesh {
namespace {

// Enough to see what a face is: so many triangles along the part, and around a bore.
constexpr double kAlong = 20.0, kAround = 20.0;

double diagonal_of(const ResultRecord& result) {
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const FaceRecord& face : result.faces)
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], face.box[k]);
      high[k] = std::max(high[k], face.box[k + 3]);
    }
  return std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
}

}  // namespace

Arrays collect_picture(const Job& job, ResultRecord& result) {
  say(0.3, "drawing the faces");
  gmsh::option::setNumber("Mesh.Algorithm", 6);
  gmsh::option::setNumber("Mesh.MeshSizeMax", diagonal_of(result) / job.to_m / kAlong);
  gmsh::option::setNumber("Mesh.MeshSizeFromCurvature", kAround);
  try {
    if (job.format != "stl") gmsh::model::mesh::generate(2);  // whose facets are the picture
  } catch (...) {                                             // what was meshed until then is there
    result.messages.push_back("not every face is drawn: gmsh fails on one of them");
  }
  Arrays arrays;
  std::vector<std::size_t> tags, cells, nodes;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters, -1, -1, false, false);
  std::map<std::size_t, std::int32_t> number;
  for (std::size_t k = 0; k < tags.size(); ++k) {
    number[tags[k]] = static_cast<std::int32_t>(k);
    for (std::size_t i = 0; i < 3; ++i) arrays.points.push_back(coordinates[3 * k + i] * job.to_m);
  }
  for (const FaceRecord& face : result.faces) {
    cells.clear();
    nodes.clear();
    gmsh::model::mesh::getElementsByType(2, cells, nodes, face.entity > 0 ? face.entity : face.number);
    for (const std::size_t node : nodes) arrays.triangles.push_back(number.at(node));
    arrays.face.insert(arrays.face.end(), cells.size(), face.number);
  }
  cells.clear();
  nodes.clear();
  gmsh::model::mesh::getElementsByType(1, cells, nodes);
  for (const std::size_t node : nodes) arrays.integers.push_back(number.at(node));
  return arrays;
}

}  // namespace flexura::mesh
