// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <stdexcept>

#include "beam/element/element.hpp"

namespace flexura::beam {
namespace {

std::string print(const Eigen::Vector3d& v) {
  return fmt::format("({:g}, {:g}, {:g})", v.x(), v.y(), v.z());
}

}  // namespace

Matrix12d Placement::transform() const {
  Matrix12d transform = Matrix12d::Zero();
  const Eigen::Matrix3d R_EB = R_BE.transpose();
  for (int end = 0; end < 2; ++end) {
    // u_end = u_node + theta x offset
    Eigen::Matrix3d cross;
    const Eigen::Vector3d& o = offset_B[end];
    cross << 0, -o.z(), o.y(), o.z(), 0, -o.x(), -o.y(), o.x(), 0;
    transform.block<3, 3>(6 * end, 6 * end) = R_EB;
    transform.block<3, 3>(6 * end, 6 * end + 3) = -R_EB * cross;
    transform.block<3, 3>(6 * end + 3, 6 * end + 3) = R_EB;
  }
  return transform;
}

Eigen::Vector3d default_direction(const Eigen::Vector3d& axis) {
  const Eigen::Vector3d sideways = Eigen::Vector3d::UnitZ().cross(axis);
  return sideways.norm() > 1e-6 * axis.norm() ? sideways : Eigen::Vector3d::UnitY();
}

Placement place(const std::string& name, const Eigen::Vector3d& p_BoN1_B, const Eigen::Vector3d& p_BoN2_B,
                const Eigen::Vector3d& direction_B, const Eigen::Vector3d& offset_1_B,
                const Eigen::Vector3d& offset_2_B) {
  Placement placement;
  placement.offset_B = {offset_1_B, offset_2_B};
  placement.p_Bo1_B = p_BoN1_B + offset_1_B;
  const Eigen::Vector3d end_2 = p_BoN2_B + offset_2_B, axis = end_2 - placement.p_Bo1_B;
  placement.length = axis.norm();
  if (!(placement.length > 1e-9 * std::max(placement.p_Bo1_B.norm(), end_2.norm())) ||
      !(placement.length > 1e-12))  // no machine has such a member; its stiffness has 36 digits more
    throw std::invalid_argument(fmt::format(
        "{} has no length: its ends (with offsets) are both at {}; move a node or take the member out", name,
        print(placement.p_Bo1_B)));
  const Eigen::Vector3d x = axis / placement.length;
  const double size = direction_B.norm();
  const Eigen::Vector3d z = x.cross(direction_B);
  if (!(size > 0.0) || !(z.norm() > 1e-6 * size))
    throw std::invalid_argument(fmt::format(
        "{}: the direction {} is parallel to the member's axis {}; give a direction across the axis (it "
        "points to the side of the section's +y, the width)",
        name, print(direction_B), print(x)));
  placement.R_BE.col(0) = x;
  placement.R_BE.col(2) = z.normalized();
  placement.R_BE.col(1) = placement.R_BE.col(2).cross(x).normalized();
  return placement;
}

}  // namespace flexura::beam
