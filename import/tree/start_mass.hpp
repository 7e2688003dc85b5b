// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "import/model/findings.hpp"
#include "import/tree/tree.hpp"

namespace flexura::import::tree {

/// The mass matrix in the coordinates of the joints at the start, by composite bodies: H_ij = S_i^T I_c S_j with the composite inertia
/// I_c behind the outer one of i and j (Featherstone, Rigid Body Dynamics Algorithms, section 6.2), and armatures on
/// its diagonal.  Links that hang on the ground apart from each other have blocks of their own.
class StartMass {
 public:
  using Row = std::vector<std::pair<int, double>>;  ///< (coordinate, factor)

  explicit StartMass(const Tree& tree);

  /// Adds a fault for each joint that moves what has no inertia apart from the joints before it.
  void require_inertia(Findings& findings) const;

  /// First coordinate of the joint; free: three turns, then three slides.
  int first(int joint) const { return first_[static_cast<std::size_t>(joint)]; }
  double carried(int joint) const { return diagonal(first(joint)); }  ///< H_ii of its first coordinate
  double diagonal(int coordinate) const;
  /// J H^-1 J^T; 0 where that is not finite.
  double compliance(const Row& row) const;
  /// How the point at x (world), fixed in the link, moves along the direction n by each coordinate.
  Row moves(int link, const Vector3d& x, const Vector3d& n) const;

 private:
  struct Block {
    std::vector<int> coordinates;
    Eigen::MatrixXd H, L;  ///< L: Cholesky's factor as far as it goes
    int rank = 0;
  };

  const Tree& tree_;
  std::vector<int> first_, joint_of_, block_of_, index_in_block_, joint_to_;
  std::vector<Eigen::Matrix<double, 6, 1>> twists_;
  std::vector<Block> blocks_;
};

}  // namespace flexura::import::tree
