// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/point_mass.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/input/rigid_motion.hpp"
#include "reduce/assembly/tied_model.hpp"
#include "reduce/linalg/dense/dense.hpp"

namespace flexura::reduce {

mesh::Index add_tied_node(Part& part, int interface, const Eigen::Vector3d& x) {
  InterfaceSpec& spec = part.interfaces[interface];
  if (spec.tie != Tie::rigid)
    throw std::invalid_argument(fmt::format(
        "interface '{}' is tied as {}: masses, springs and dampers on an interface node need a rigid tie",
        spec.name, name_of(spec.tie)));
  mesh::Mesh& mesh = part.mesh;
  const mesh::Index node = mesh.n_nodes();
  mesh.points.conservativeResize(node + 1, 3);
  mesh.points.row(node) = x.transpose();
  if (!mesh.node_label.empty()) mesh.node_label.push_back(-1);
  spec.set.nodes.push_back(node);  // the greatest number: still ascending
  return node;
}

namespace {

void require_mass(const PointMass& mass, const std::string& where) {
  if (mass.mass > 0.0 || (mass.mass == 0.0 && !mass.inertia.isZero(0.0))) return;
  throw std::invalid_argument(fmt::format("the mass on {} is {} kg{}", where, mass.mass,
                                          mass.mass == 0.0
                                              ? " and has no moments of inertia"
                                              : ", it must be above 0 (0 for a moment of inertia alone)"));
}

// Points (from the node) with masses that have the inertia of a rigid piece: its mass centre alone, or two points on
// each principal axis.  Of moments of inertia without mass the points weigh some M, which a point at the node takes away again;
// M is such that they stand about the size of the part away, where nothing is lost in round-off.
std::vector<std::pair<Eigen::Vector3d, double>> equal_points(const Part& part, const PointMass& mass,
                                                             const std::string& where) {
  require_mass(mass, where);
  if (mass.inertia.isZero(0.0)) return {{mass.offset, mass.mass}};
  const Eigen::Matrix3d C = 0.5 * mass.inertia.trace() * Eigen::Matrix3d::Identity() - mass.inertia;
  const linalg::DenseEigen axes = linalg::symmetric_eigen(C);
  // Figures come with five digits and more: a plate's zero may come out negative by as much.
  if (axes.values(0) < -1e-5 * axes.values(2))
    throw std::invalid_argument(fmt::format(
        "the moments of inertia on {} belong to no body: the greatest exceeds the sum of the other two",
        where));
  const auto& x = part.mesh.points;
  const double size = (x.colwise().maxCoeff() - x.colwise().minCoeff()).norm();
  const double M = mass.mass > 0.0 ? mass.mass : 3.0 * axes.values(2) / (size * size);
  std::vector<std::pair<Eigen::Vector3d, double>> points;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d reach = std::sqrt(3.0 * std::max(axes.values(k), 0.0) / M) * axes.vectors.col(k);
    for (const double side : {-1.0, 1.0}) points.emplace_back(mass.offset + side * reach, M / 6.0);
  }
  if (mass.mass == 0.0) points.emplace_back(mass.offset, -M);
  return points;
}

}  // namespace

void add_mass_to_interface(Part& part, int interface, const PointMass& mass) {
  const std::string name = part.interfaces[interface].name;
  const Eigen::Vector3d node = part.interfaces[interface].point;
  for (const auto& [arm, share] : equal_points(part, mass, fmt::format("interface '{}'", name)))
    part.masses.push_back({add_tied_node(part, interface, node + arm), share, mass.alpha});
}

void add_mass_to_average(Part& part, const InterfaceSpec& average, const PointMass& mass) {
  const Eigen::Matrix<double, 6, Eigen::Dynamic> map = averaging_map(part.mesh, average);
  for (const auto& [arm, share] : equal_points(part, mass, average.name)) {
    mesh::Mesh& mesh = part.mesh;
    const mesh::Index point = mesh.n_nodes();
    const Eigen::Vector3d x = average.point + arm;
    mesh.points.conservativeResize(point + 1, 3);
    mesh.points.row(point) = x.transpose();
    if (!mesh.node_label.empty()) mesh.node_label.push_back(-1);
    part.followers.push_back(follower_of(point, motion_at(arm), average, map));
    part.masses.push_back({point, share, mass.alpha});
  }
}

void add_mass_to_node(Part& part, const PointMass& mass) {
  const auto label = part.mesh.node_label.empty() ? mass.node + 1 : part.mesh.node_label[mass.node];
  require_mass(mass, fmt::format("node {}", label));
  if (!mass.offset.isZero(0.0) || !mass.inertia.isZero(0.0)) {
    if (nodes_with_rotations(part)[mass.node] != 0) {
      for (const auto& [arm, share] : equal_points(part, mass, fmt::format("node {}", label))) {
        mesh::Mesh& mesh = part.mesh;
        const mesh::Index point = mesh.n_nodes();
        const Eigen::Vector3d x = mesh.points.row(mass.node).transpose() + arm;
        mesh.points.conservativeResize(point + 1, 3);
        mesh.points.row(point) = x.transpose();
        if (!mesh.node_label.empty()) mesh.node_label.push_back(-1);
        part.followers.push_back({point, {{mass.node, motion_at(arm)}}});
        part.masses.push_back({point, share, mass.alpha});
      }
      return;
    }
    throw std::invalid_argument(fmt::format(
        "the point mass on node {} has an offset or moments of inertia, but solid elements have no "
        "rotations there: put it on a rigid interface",
        label));
  }
  part.masses.push_back({mass.node, mass.mass, mass.alpha});
}

}  // namespace flexura::reduce
