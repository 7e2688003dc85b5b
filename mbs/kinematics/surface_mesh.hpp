// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <vector>

#include "mbs/base/math/spatial.hpp"

namespace flexura::mbs {

/// Triangles of a body's surface as the body's modes deform it, and how near two of them come to each other.
///
/// A tree of balls over the triangles moves and grows with the modal coordinates without being refitted, as that of SurfacePatch does
/// (surface_patch.hpp); two trees are descended together, the nearer balls first (P. Jimenez, F. Thomas, C. Torras, Computers &
/// Graphics 25 (2001) 269).
class SurfaceMesh {
 public:
  /// Vertices in B [m], undeformed, and triangles of their indices. Rigid until set_shapes().
  SurfaceMesh(const Eigen::Matrix3Xd& x, const Eigen::Matrix3Xi& triangles);
  /// Rows 3 j ... 3 j + 2: vertex j. Throws std::invalid_argument for another number of rows.
  void set_shapes(const Eigen::MatrixXd& Phi);

  int m() const { return static_cast<int>(Phi_.cols()); }

  struct Gap {
    double distance = 0.0;                                    ///< 0 where they cross
    Vector3d p_A = Vector3d::Zero(), p_B = Vector3d::Zero();  ///< nearest points, both in A
  };
  /// X_AB: the pose of b's frame in a's; modal coordinates may be null: undeformed.
  static Gap between(const SurfaceMesh& a, const double* s_a, const SurfaceMesh& b, const double* s_b,
                     const Pose& X_AB);

 private:
  static constexpr int kLeaf = 4;
  struct Group {
    int begin = 0, end = 0;     ///< triangles, in the order of the tree
    int left = -1, right = -1;  ///< of an inner one
    Vector3d c;
    double r = 0.0;
  };
  struct Ball {
    Vector3d c;
    double r;
  };
  struct Search;
  using Shapes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  int build(int begin, int end);
  Ball ball(int group, const double* s) const;
  Vector3d vertex(int j, const double* s) const;

  Eigen::Matrix3Xd x_;
  std::vector<Eigen::Vector3i> triangles_;  ///< in the order of the tree
  std::vector<Group> groups_;
  Shapes Phi_, mean_, spread_;  ///< of vertices; of each group 3 rows, 1 row
};

}  // namespace flexura::mbs
