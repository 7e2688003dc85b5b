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
  int n_vertices() const { return static_cast<int>(x_.cols()); }
  int n_triangles() const { return static_cast<int>(triangles_.size()); }
  /// In the order of the tree, by which visit() names them.
  const Eigen::Vector3i& triangle(int t) const { return triangles_[static_cast<std::size_t>(t)]; }
  /// Of vertex j: where it stands, s (m) may be null: undeformed; how fast it moves; its shapes.
  Vector3d vertex(int j, const double* s) const;
  Vector3d velocity(int j, const double* s_dot) const;
  auto shapes(int j) const { return Phi_.middleRows<3>(3 * j); }

  /// A ball around a group of the tree, deformed.
  struct Ball {
    Vector3d c;
    double r;
  };
  int n_groups() const { return static_cast<int>(groups_.size()); }
  Ball ball(int group, const double* s) const;

  /// triangle(t) of all triangles in balls ball_of(group) that enter(centre, radius, longest) lets in; `longest`: from the middle of a
  /// triangle of theirs to a corner, undeformed.
  template <class BallOf, class Enter, class Take>
  void visit(const BallOf& ball_of, const Enter& enter, const Take& take) const {
    visit(0, ball_of, enter, take);
  }

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
    double longest = 0.0;  ///< from the middle of a triangle to a corner
  };
  struct Search;
  using Shapes = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  int build(int begin, int end);
  template <class BallOf, class Enter, class Take>
  void visit(int group, const BallOf& ball_of, const Enter& enter, const Take& take) const {
    const Group& g = groups_[static_cast<std::size_t>(group)];
    const Ball& b = ball_of(group);
    if (!enter(b.c, b.r, g.longest)) return;
    if (g.left >= 0) {
      visit(g.left, ball_of, enter, take);
      visit(g.right, ball_of, enter, take);
      return;
    }
    for (int t = g.begin; t < g.end; ++t) take(t);
  }

  Eigen::Matrix3Xd x_;
  std::vector<Eigen::Vector3i> triangles_;  ///< in the order of the tree
  std::vector<Group> groups_;
  Shapes Phi_, mean_, spread_;  ///< of vertices; of each group 3 rows, 1 row
};

}  // namespace flexura::mbs
