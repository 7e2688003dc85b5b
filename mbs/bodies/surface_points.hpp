// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace flexura::mbs {

/// Single nodes of a superelement's surface whose motion is wanted: x + Phi(x) s in the body's frame.
class SurfacePoints {
 public:
  struct Point {
    std::string name;
    Eigen::Vector3d x;    ///< the node nearest to where it was wanted, undeformed [m]
    Eigen::MatrixXd Phi;  ///< 3 x m; without columns on a rigid body
  };
  void add(Point point) { points_.push_back(std::move(point)); }
  const std::vector<Point>& points() const { return points_; }

  /// In B [m]; `s` (m) may be null on a rigid body.
  Eigen::Vector3d displacement(std::size_t point, const double* s) const {
    const Eigen::MatrixXd& Phi = points_[point].Phi;
    if (Phi.cols() == 0) return Eigen::Vector3d::Zero();
    return Phi * Eigen::Map<const Eigen::VectorXd>(s, Phi.cols());
  }

 private:
  std::vector<Point> points_;
};

}  // namespace flexura::mbs
