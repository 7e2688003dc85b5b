// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>
#include <vector>

namespace flexura::mbs {

/// Nodes of a superelement's surface whose motion is wanted, single ones and the greatest of all: x + Phi(x) s in the body's
/// frame.
class SurfacePoints {
 public:
  struct Point {
    std::string name;
    Eigen::Vector3d x;    ///< the node nearest to where it was wanted, undeformed [m]
    Eigen::MatrixXd Phi;  ///< 3 x m; without columns on a rigid body
  };
  struct Greatest {
    double displacement = 0.0;  ///< [m]
    Eigen::Index node = 0;
  };
  void add(Point point) { points_.push_back(std::move(point)); }
  const std::vector<Point>& points() const { return points_; }

  /// In B [m]; `s` (m) may be null on a rigid body.
  Eigen::Vector3d displacement(std::size_t point, const double* s) const {
    const Eigen::MatrixXd& Phi = points_[point].Phi;
    if (Phi.cols() == 0) return Eigen::Vector3d::Zero();
    return Phi * Eigen::Map<const Eigen::VectorXd>(s, Phi.cols());
  }

  /// All nodes: 3 x n undeformed [m], and 3 n x m (without columns on a rigid body).
  void set_everywhere(Eigen::Matrix3Xd x, Eigen::MatrixXd Phi) {
    x_ = std::move(x);
    Phi_ = std::move(Phi);
  }
  bool has_everywhere() const { return x_.cols() > 0; }
  Eigen::Vector3d node(Eigen::Index i) const { return x_.col(i); }
  /// Of all nodes by deformation; `s` (m) may be null on a rigid body.
  Greatest greatest(const double* s) const {
    Greatest out;
    if (Phi_.cols() == 0) return out;
    const Eigen::VectorXd u = Phi_ * Eigen::Map<const Eigen::VectorXd>(s, Phi_.cols());
    const double squared = u.reshaped(3, x_.cols()).colwise().squaredNorm().maxCoeff(&out.node);
    out.displacement = std::sqrt(squared);
    return out;
  }

 private:
  std::vector<Point> points_;
  Eigen::Matrix3Xd x_;
  Eigen::MatrixXd Phi_;
};

}  // namespace flexura::mbs
