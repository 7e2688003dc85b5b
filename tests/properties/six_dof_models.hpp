// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "reduce/part/part_input.hpp"
#include "tests/mbs/random/chance.hpp"

/// Random models of nodes with three or six dofs, and the text in which FE programs write their matrices.
namespace flexura::properties {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mbs::chance::Chance;
using superelement::Superelement;

/// Nodes with numbers, and matrices of six rows each; zero where a node does not turn.
struct Model {
  std::vector<Vector3d> x;
  std::vector<std::int64_t> label;
  std::vector<char> turns;
  MatrixXd K, M, D;
  double mass = 0.0;
  Vector3d S_x = Vector3d::Zero();
  Eigen::Matrix3d S_xx = Eigen::Matrix3d::Zero();

  Index n() const { return static_cast<Index>(x.size()); }
  /// The rows that are dofs.
  std::vector<Index> dofs() const {
    std::vector<Index> all;
    for (Index a = 0; a < n(); ++a)
      for (int d = 0; d < (turns[static_cast<std::size_t>(a)] != 0 ? 6 : 3); ++d) all.push_back(6 * a + d);
    return all;
  }
  MatrixXd of_dofs(const MatrixXd& A) const { return A(dofs(), dofs()); }
};

Model random_model(Chance& chance);

enum class Format { market, coordinate, nodes, small, large, free };

/// The matrix as the format writes it, one triangle or both.
std::string written(const Model& model, const MatrixXd& A, Format format, const char* name, Chance& chance);

/// A row a line, to the last digit.
std::string dense(const MatrixXd& A);

/// In units of length [m] and mass [kg] of the file, seconds: rows of rotations count in radians.
MatrixXd in_units(const MatrixXd& A, double length, double mass);

/// Number, x, y, z of each, in a unit of length [m].
std::string table_of_nodes(const Model& model, double length);

/// A sheet of shells with normals either way, offsets and warp, as an Abaqus deck: n by across - 1 places.
std::string random_sheet(Chance& chance, int n, int across);

/// All of K and M of a part of ours, without its interfaces.
Model full_model(const reduce::PartInput& input);

VectorXd eigenvalues(const MatrixXd& A, const MatrixXd& B);
void expect_close(const VectorXd& found, const VectorXd& right, double tolerance, const char* what);

}  // namespace flexura::properties
