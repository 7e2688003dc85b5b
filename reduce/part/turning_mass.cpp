// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "reduce/part/read_matrices.hpp"

namespace flexura::reduce {

void scale(GivenMatrices& matrices, double unit_mass, double unit_length) {
  for (std::vector<Eigen::Matrix3d>* list : {&matrices.u.K, &matrices.u.D})  // force per length: M T^-2
    for (Eigen::Matrix3d& block : *list) block *= unit_mass;
  for (double& m : matrices.u.m) m *= unit_mass;
  for (FrameElement& frame : matrices.frames)
    for (Eigen::MatrixXd* matrix : {&frame.K, &frame.D})
      for (Eigen::Index i = 0; i < matrix->rows(); ++i)
        for (Eigen::Index j = 0; j < matrix->cols(); ++j)
          (*matrix)(i, j) *= unit_mass * (i % 6 < 3 ? 1.0 : unit_length) * (j % 6 < 3 ? 1.0 : unit_length);
  for (TurningMass& of : matrices.turning) {
    of.moment_of_first *= unit_mass * unit_length;
    of.moment_of_second *= unit_mass * unit_length;
    of.inertia *= unit_mass * unit_length * unit_length;
  }
}

namespace {

// Points beside the nodes that carry the rotary inertia exactly: at x + h e_k, moving by u + theta x h e_k.  With
// C = tr(J)/2 1 - J^T of a pair's inertia
//
//     theta_a . J theta_b = sum over i, j of C_ij (theta_a x e_i) . (theta_b x e_j),   theta x h e_k = u_k - u_0,
//
// so that J becomes masses between nodes and points, as do the moments; inertia integrals need no more.
void add_turning_masses(const std::vector<TurningMass>& turning, Part& part) {
  if (turning.empty()) return;
  NodalMatrices& matrices = part.matrices.value();
  // Any reach will do; that of the inertia itself keeps masses of one size.
  double mass = 0.0, inertia = 0.0;
  for (const double m : matrices.m) mass += std::abs(m);
  for (const TurningMass& of : turning) inertia += of.inertia.cwiseAbs().sum();
  const double reach = mass > 0.0 && inertia > 0.0 ? std::sqrt(inertia / mass) : 1.0;
  std::map<mesh::Index, mesh::Index> first;  // of the three points of a node
  mesh::Mesh& mesh = part.mesh;
  const mesh::Index before = mesh.n_nodes();
  for (const TurningMass& of : turning)
    for (const mesh::Index node : of.nodes)
      first.try_emplace(node, before + 3 * static_cast<mesh::Index>(first.size()));
  mesh.points.conservativeResize(before + 3 * static_cast<Eigen::Index>(first.size()), 3);
  if (!mesh.node_label.empty()) mesh.node_label.resize(static_cast<std::size_t>(mesh.points.rows()), -1);
  for (const auto& [node, at] : first)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d r = reach * Eigen::Vector3d::Unit(k);
      mesh.points.row(at + k) = mesh.points.row(node) + r.transpose();
      Eigen::Matrix<double, 3, 6> C;
      C << Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Zero();
      for (int d = 0; d < 3; ++d) C.col(3 + d) = Eigen::Vector3d::Unit(d).cross(r);
      part.followers.push_back({.point = at + k, .from = {{node, C}}});
    }
  const auto add = [&](mesh::Index a, mesh::Index b, double m) {
    if (m == 0.0) return;
    matrices.pairs.push_back({std::min(a, b), std::max(a, b)});
    matrices.K.push_back(Eigen::Matrix3d::Zero());
    if (!matrices.D.empty()) matrices.D.push_back(Eigen::Matrix3d::Zero());
    matrices.m.push_back(m);
  };
  for (const TurningMass& of : turning) {
    const auto& [a, b] = of.nodes;
    const Eigen::Matrix3d C =
        (0.5 * of.inertia.trace() * Eigen::Matrix3d::Identity() - of.inertia.transpose()) / (reach * reach);
    const Eigen::Vector3d of_a = of.moment_of_first / reach - C.rowwise().sum(),
                          of_b = of.moment_of_second / reach - C.colwise().sum().transpose();
    // u_a . u_b loses what the points have.
    add(a, b, C.sum() - (of.moment_of_first + of.moment_of_second).sum() / reach);
    for (int k = 0; k < 3; ++k) {
      if (a != b) add(first.at(a) + k, b, of_a(k));
      add(a, first.at(b) + k, of_b(k));
      for (int j = a == b ? k : 0; j < 3; ++j) add(first.at(a) + k, first.at(b) + j, C(k, j));
    }
  }
}

}  // namespace

void take_in(GivenMatrices&& given, Part& part) {
  mesh::Mesh& mesh = part.mesh;
  for (mesh::CellBlock& block : mesh.shells)
    mesh.boundary.push_back({.type = block.type, .nodes = std::move(block.nodes)});
  if (!mesh.shells.empty()) mesh.boundary_face.clear();
  mesh.shells.clear();
  part.matrices = std::move(given.u);
  part.frames = std::move(given.frames);
  add_turning_masses(given.turning, part);
}

}  // namespace flexura::reduce
