// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Sparse>
#include <utility>
#include <vector>

#include "reduce/elements/shell.hpp"
#include "tests/reduce/shells/shell_meshes.hpp"

/// Statics of a mesh of shells of one material and thickness.
namespace flexura::reduce::testing {

inline NodePositions corners(const ShellMesh& mesh, const std::vector<int>& cell) {
  NodePositions x(static_cast<Eigen::Index>(cell.size()), 3);
  for (std::size_t a = 0; a < cell.size(); ++a)
    x.row(static_cast<Eigen::Index>(a)) = mesh.points.row(cell[a]);
  return x;
}

// K u = f with prescribed dofs.
class Statics {
 public:
  Statics(ShellMesh mesh, const Material& material, double t)
      : mesh_(std::move(mesh)), n_(6 * static_cast<int>(mesh_.points.rows())), f_(Eigen::VectorXd::Zero(n_)) {
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd K;
    for (const auto& cell : mesh_.cells) {
      EXPECT_GT(shell_stiffness(corners(mesh_, cell), material, t, 0.0, K), 0.0);
      for (Eigen::Index i = 0; i < K.rows(); ++i)
        for (Eigen::Index j = 0; j < K.cols(); ++j)
          entries.emplace_back(6 * cell[i / 6] + i % 6, 6 * cell[j / 6] + j % 6, K(i, j));
    }
    K_.resize(n_, n_);
    K_.setFromTriplets(entries.begin(), entries.end());
  }
  const ShellMesh& mesh() const { return mesh_; }
  const Eigen::SparseMatrix<double>& K() const { return K_; }
  void hold(const std::vector<int>& nodes, std::initializer_list<int> directions, double value = 0.0) {
    for (const int node : nodes)
      for (const int d : directions) held_.emplace_back(6 * node + d, value);
  }
  void hold(int dof, double value) { held_.emplace_back(dof, value); }
  void push(int node, int direction, double force) { f_(6 * node + direction) += force; }
  // Force per area along `direction`, each corner a share of its cell.
  void spread(int direction, double per_area) {
    for (const auto& cell : mesh_.cells) {
      const double area = shell_frame(corners(mesh_, cell)).area;
      for (const int node : cell) push(node, direction, per_area * area / static_cast<double>(cell.size()));
    }
  }
  Eigen::VectorXd solve() const {
    std::vector<int> place(n_, 0);
    Eigen::VectorXd u = Eigen::VectorXd::Zero(n_);
    for (const auto& [dof, value] : held_) place[dof] = -1, u(dof) = value;
    int n = 0;
    for (int& p : place)
      if (p == 0) p = n++;
    std::vector<Eigen::Triplet<double>> entries;
    const Eigen::VectorXd r = f_ - K_ * u;
    Eigen::VectorXd rhs(n);
    for (int j = 0; j < n_; ++j) {
      if (place[j] < 0) continue;
      rhs(place[j]) = r(j);
      for (Eigen::SparseMatrix<double>::InnerIterator it(K_, j); it; ++it)
        if (place[it.row()] >= 0) entries.emplace_back(place[it.row()], place[j], it.value());
    }
    Eigen::SparseMatrix<double> K(n, n);
    K.setFromTriplets(entries.begin(), entries.end());
    const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(K);
    const Eigen::VectorXd x = factor.solve(rhs);
    for (int j = 0; j < n_; ++j)
      if (place[j] >= 0) u(j) = x(place[j]);
    return u;
  }

 private:
  ShellMesh mesh_;
  int n_;
  Eigen::VectorXd f_;
  Eigen::SparseMatrix<double> K_;
  std::vector<std::pair<int, double>> held_;
};

}  // namespace flexura::reduce::testing
