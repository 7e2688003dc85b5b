// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

/// How far points lie outside or inside a triangulated surface.
///
/// The sign is that of the angle-weighted pseudonormal where the nearest point lies (J. A. Baerentzen, H. Aanaes, IEEE Trans.
/// Visualization and Computer Graphics 11 (2005) 243-253): right for every closed surface that looks outwards.
namespace flexura::proximity {

using Eigen::Vector3d;

class PointTree {
 public:
  /// The vertices are looked at where they are, and must outlive this.
  PointTree(const Eigen::Matrix3Xd& vertices, const Eigen::Matrix3Xi& triangles);

  /// Vertices have moved.
  void refit();

  struct Nearest {
    double distance = 0.0;  ///< [m], negative inside
    Vector3d at = Vector3d::Zero();
  };
  Nearest nearest(const Vector3d& p) const;

  /// From the whole downwards: `enter` says of a box whether to look within, `leaf` gets the triangles of those that are no more parted.
  template <class Enter, class Leaf>
  void descend(const Enter& enter, const Leaf& leaf, int node = 0) const {
    const Node& n = nodes_[static_cast<std::size_t>(node)];
    if (!enter(n.box)) return;
    if (n.left >= 0) {
      descend(enter, leaf, n.left);
      descend(enter, leaf, n.right);
      return;
    }
    for (int k = n.begin; k < n.end; ++k) leaf(order_[static_cast<std::size_t>(k)]);
  }

  const Eigen::AlignedBox3d& box() const { return nodes_.front().box; }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    int left = -1, right = -1;  ///< of an inner node
    int begin = 0, end = 0;     ///< of a leaf, in order_
  };
  int build(int begin, int end);
  void find_edges();
  void find_normals();
  void look(int node, const Vector3d& p, double& square, int& triangle, int& feature, Vector3d& at) const;

  const Eigen::Matrix3Xd& vertices_;
  const Eigen::Matrix3Xi& triangles_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
  Eigen::Matrix3Xi edge_of_;  ///< of side k of a triangle, opposite of its corner k
  int n_edges_ = 0;
  Eigen::Matrix3Xd face_normals_, edge_normals_, vertex_normals_;
};

}  // namespace flexura::proximity
