// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/planar.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <stdexcept>

#include "mesh/gmsh/ask.hpp"
#include "mesh/gmsh/cad_file.hpp"

namespace flexura::mesh {

PlanarMesh mesh_planar(const PlanarOptions& options, const Progress& progress) {
  Job job;
  job.task = "planar";
  job.size = options.size;
  job.parent = getpid();
  if (!options.cad.empty()) {
    job.path = std::filesystem::absolute(options.cad).string();
    job.format = inspect_cad_file(options.cad).format;
  }
  for (const PlaneRegion& region : options.regions) {
    std::vector<std::vector<double>> loops;
    std::vector<const PlaneLoop*> all = {&region.outer};
    for (const PlaneLoop& hole : region.holes) all.push_back(&hole);
    for (const PlaneLoop* loop : all) {
      if (loop->size() < 3)
        throw std::invalid_argument(
            fmt::format("a polygon has {} corners; at least 3 are needed", loop->size()));
      std::vector<double>& numbers = loops.emplace_back();
      for (const auto& [y, z] : *loop) numbers.insert(numbers.end(), {y, z});
    }
    job.regions.push_back(std::move(loops));
  }
  Answer answer;
  try {
    answer = ask_worker(options.worker, job, options.time_limit_s, progress);
  } catch (const TryFailed& error) {
    throw std::invalid_argument(std::string("the section cannot be meshed: it ") + error.what());
  }
  PlanarMesh mesh;
  mesh.messages = answer.record.messages;
  mesh.points.resize(static_cast<Eigen::Index>(answer.record.n_points), 2);
  for (Eigen::Index k = 0; k < mesh.points.rows(); ++k)
    mesh.points.row(k) << answer.arrays.points[3 * k], answer.arrays.points[3 * k + 1];
  const auto& integers = answer.arrays.integers;  // six nodes and the region of each triangle
  mesh.triangles.resize(static_cast<Eigen::Index>(integers.size() / 7), 6);
  for (Eigen::Index c = 0; c < mesh.triangles.rows(); ++c) {
    std::array<int, 6> nodes;
    for (int k = 0; k < 6; ++k) nodes[k] = static_cast<int>(integers[7 * c + k]);
    const Eigen::RowVector2d a = mesh.points.row(nodes[1]) - mesh.points.row(nodes[0]);
    const Eigen::RowVector2d b = mesh.points.row(nodes[2]) - mesh.points.row(nodes[0]);
    if (a(0) * b(1) < a(1) * b(0)) {  // turned over
      std::swap(nodes[1], nodes[2]);
      std::swap(nodes[3], nodes[5]);
    }
    for (int k = 0; k < 6; ++k) mesh.triangles(c, k) = nodes[k];
    mesh.region.push_back(static_cast<int>(integers[7 * c + 6]));
  }
  return mesh;
}

}  // namespace flexura::mesh
