// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"

namespace flexura::mbs {

/// (N, V_y, V_z, T, M_y, M_z) on the section that looks along +x of its member, in the member's axes [N, N
/// m].
using SectionForce = Eigen::Matrix<double, 6, 1>;

/// Section forces of a beam part in motion, S(p) Y s, at places of which the whole history is wanted: each
/// the nearest one that the superelement knows.
class SectionPoints {
 public:
  struct Point {
    std::string name;
    double distance = 0.0;  ///< from where it was wanted [m]
  };

  /// `Y` n_se x m.
  SectionPoints(const superelement::SectionForces& forces, const Eigen::MatrixXd& Y)
      : forces_(forces), Y_(Y) {}
  /// `wanted` [m] in B.
  void add_point(const std::string& name, const Eigen::Vector3d& wanted);
  const std::vector<Point>& points() const { return points_; }

  SectionForce at(int point, const double* s) const;

 private:
  superelement::SectionForces forces_;
  Eigen::MatrixXd Y_;
  std::vector<Point> points_;
  std::vector<Eigen::MatrixXd> of_modes_;  // 6 x m each
};

}  // namespace flexura::mbs
