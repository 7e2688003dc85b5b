// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_curves.hpp"

#include <gmsh.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>

#include "mesh/gmsh/worker/read_mesh.hpp"

namespace flexura::mesh {
namespace {

constexpr int kSamples = 257;  // along a curve, to measure its length and how it turns

std::vector<Eigen::Vector3d> values(int curve, const std::vector<double>& parameters) {
  std::vector<double> xyz;
  gmsh::model::getValue(1, curve, parameters, xyz);
  std::vector<Eigen::Vector3d> points;
  for (std::size_t k = 0; k + 2 < xyz.size(); k += 3) points.emplace_back(xyz[k], xyz[k + 1], xyz[k + 2]);
  return points;
}

// Points on the curve at equal lengths; as many as its turning asks for, two for a straight one.
std::vector<Eigen::Vector3d> divide(int curve, double turn) {
  std::vector<double> low, high, parameters;
  gmsh::model::getParametrizationBounds(1, curve, low, high);
  for (int k = 0; k < kSamples; ++k) parameters.push_back(low[0] + (high[0] - low[0]) * k / (kSamples - 1));
  const std::vector<Eigen::Vector3d> fine = values(curve, parameters);
  std::vector<double> length = {0.0};
  double turning = 0.0;
  for (int k = 1; k < kSamples; ++k) {
    const Eigen::Vector3d step = fine[k] - fine[k - 1];
    length.push_back(length.back() + step.norm());
    if (k + 1 < kSamples && step.norm() > 0.0) {
      const Eigen::Vector3d next = fine[k + 1] - fine[k];
      turning += std::atan2(step.cross(next).norm(), step.dot(next));
    }
  }
  if (!(length.back() > 0.0)) return {};
  // Chords of the fine polygon see all but one part in kSamples of the turning.
  turning *= static_cast<double>(kSamples - 1) / (kSamples - 2);
  const int n = std::max(1, static_cast<int>(std::ceil(turning / turn - 1e-6)));
  if (n == 1) return {fine.front(), fine.back()};
  std::vector<double> chosen;
  int at = 1;
  for (int k = 0; k <= n; ++k) {
    const double wanted = length.back() * k / n;
    while (at + 1 < kSamples && length[at] < wanted) ++at;
    const double share = (wanted - length[at - 1]) / (length[at] - length[at - 1]);
    chosen.push_back(parameters[at - 1] + share * (parameters[at] - parameters[at - 1]));
  }
  return values(curve, chosen);
}

void add_point(Arrays& arrays, const Eigen::Vector3d& p, double to_m) {
  for (int i = 0; i < 3; ++i) arrays.points.push_back(p(i) * to_m);
}

void add_line_elements(int curve, double to_m, std::map<std::size_t, std::int64_t>& number, Arrays& arrays) {
  for (const int type : {1, 8}) {  // lines of two and of three nodes, ends first
    std::vector<std::size_t> cells, nodes;
    gmsh::model::mesh::getElementsByType(type, cells, nodes, curve);
    const std::size_t n = type == 1 ? 2 : 3;
    for (std::size_t c = 0; c < cells.size(); ++c) {
      for (std::size_t end = 0; end < 2; ++end) {
        const std::size_t node = nodes[n * c + end];
        const auto [it, added] = number.insert({node, static_cast<std::int64_t>(arrays.points.size() / 3)});
        if (added) {
          std::vector<double> xyz, parameters;
          gmsh::model::mesh::getNode(node, xyz, parameters);
          add_point(arrays, {xyz[0], xyz[1], xyz[2]}, to_m);
        }
        arrays.integers.push_back(it->second);
      }
      arrays.integers.push_back(curve);
    }
  }
}

}  // namespace

void collect_curves(const Job& job, ResultRecord& result, Arrays& arrays) {
  if (job.format == "msh") {
    merge_msh(job.path);
  } else if (job.format == "geo") {
    gmsh::merge(job.path);
  } else {
    gmsh::vectorpair imported;
    gmsh::model::occ::importShapes(job.path, imported, true, job.format);
    for (const auto& [dimension, tag] : imported)
      if (dimension > 1)
        throw std::runtime_error(
            "holds faces or solids, whose edges are no beams; export the members' axes as curves");
    gmsh::model::occ::synchronize();
  }
  gmsh::vectorpair curves;
  gmsh::model::getEntities(curves, 1);
  std::map<std::size_t, std::int64_t> number;
  for (const auto& [dimension, curve] : curves) {
    if (job.format == "msh") {
      add_line_elements(curve, job.to_m, number, arrays);
      continue;
    }
    const std::vector<Eigen::Vector3d> points = divide(curve, job.turn);
    for (std::size_t k = 0; k < points.size(); ++k) {
      add_point(arrays, points[k], job.to_m);
      if (k == 0) continue;
      const auto here = static_cast<std::int64_t>(arrays.points.size() / 3 - 1);
      arrays.integers.insert(arrays.integers.end(), {here - 1, here, curve});
    }
  }
  if (arrays.integers.empty()) throw std::runtime_error("holds no curves; export the beams' centre lines");
  result.blocks.push_back({0, arrays.integers.size() / 3});

  gmsh::vectorpair groups;
  gmsh::model::getPhysicalGroups(groups, 1);
  for (const auto& [dimension, tag] : groups) {
    std::string name;
    gmsh::model::getPhysicalName(dimension, tag, name);
    if (name.empty()) name = "group " + std::to_string(tag);
    std::vector<int> members;
    gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, members);
    for (const int curve : members) arrays.integers.push_back(curve);
    result.groups.push_back({name, members.size()});
  }
}

}  // namespace flexura::mesh
