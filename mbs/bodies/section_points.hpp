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

/// Section forces of a beam part in motion, S(p) Y s and those of preloads times their factors (as in stress_field.hpp), at
/// places of which the whole history is wanted: each the nearest one that the superelement knows.
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

  bool has_loads() const { return forces_.of_loads.size() > 0; }
  /// `factors` of the load cases; may be null.
  SectionForce at(int point, const double* s, const double* factors = nullptr) const;

 private:
  superelement::SectionForces forces_;
  Eigen::MatrixXd Y_;
  std::vector<Point> points_;
  std::vector<Eigen::MatrixXd> of_modes_;  // 6 x m each
  std::vector<Eigen::MatrixXd> of_loads_;  // 6 x load cases each
};

}  // namespace flexura::mbs
