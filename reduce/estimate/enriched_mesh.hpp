// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "reduce/assembly/input/part.hpp"

/// The functions that a mesh gains (enrichment.hpp), numbered: cells that share an edge or a face share its function.
namespace flexura::reduce {

class EnrichedMesh {
 public:
  explicit EnrichedMesh(const Part& part);

  struct Cell {
    int block;
    Eigen::Index row;
    std::size_t first_function;  ///< in the lists of the cells' functions
    int n_functions;
  };
  /// In the order of the blocks.
  const std::vector<Cell>& cells() const { return cells_; }
  int n_functions() const { return n_functions_; }
  /// Of the cells' functions, ascending where they first appear; -1: follows a rigid interface, left out.
  const std::vector<int>& numbers() const { return numbers_; }
  /// Of the cells' functions: -1 where the edge runs the other way than its numbers say.
  const std::vector<float>& signs() const { return sign_; }
  /// Whether a node follows a rigid interface.
  bool held(mesh::Index node) const { return held_[static_cast<std::size_t>(node)] != 0; }

  /// What the linear tractions that averaging ties make of forces (n_b x k) do on the functions of their faces.
  struct Load {
    int function;
    Eigen::Matrix<double, 3, Eigen::Dynamic> work;  ///< 3 x k
  };
  std::vector<Load> tractions(const Eigen::MatrixXd& force) const;

 private:
  void leave_out_rigid_faces();

  const Part& part_;
  std::vector<Cell> cells_;
  std::vector<int> numbers_;
  std::vector<float> sign_;
  std::vector<char> held_;  // of the nodes
  int n_functions_ = 0;
};

}  // namespace flexura::reduce
