// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "import/urdf/convert.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::urdf {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

// Spatial inertia about the world's origin, for twists (angular, linear of the point at the origin).
Matrix6d spatial_inertia(const Inertial& inertial, const Pose& X_WL) {
  const Matrix3d C = cross_matrix(X_WL * inertial.center);
  const Matrix3d I = X_WL.R * inertial.inertia * X_WL.R.transpose();
  Matrix6d M;
  M << I + inertial.mass * C * C.transpose(), inertial.mass * C, inertial.mass * C.transpose(),
      inertial.mass * Matrix3d::Identity();
  return M;
}

// Columns of unit twists of a joint in the world.
std::vector<Vector6d> twists(const Joint& joint, const Pose& X_WJ) {
  const Vector3d axis = X_WJ.R * joint.axis;
  const auto turn = [&](const Vector3d& a) {
    Vector6d S;
    S << a, X_WJ.p.cross(a);
    return S;
  };
  const auto slide = [&](const Vector3d& a) {
    Vector6d S;
    S << Vector3d::Zero(), a;
    return S;
  };
  switch (joint.kind) {
    case JointKind::revolute:
    case JointKind::continuous:
      return {turn(axis)};
    case JointKind::prismatic:
      return {slide(axis)};
    case JointKind::planar: {
      const Matrix3d R = mbs::frame_along(axis);
      return {slide(R.col(0)), slide(R.col(1)), turn(axis)};
    }
    case JointKind::floating: {
      std::vector<Vector6d> all;
      for (int k = 0; k < 3; ++k) all.push_back(turn(Vector3d::Unit(k)));
      for (int k = 0; k < 3; ++k) all.push_back(slide(Vector3d::Unit(k)));
      return all;
    }
    case JointKind::fixed:
      break;
  }
  return {};
}

}  // namespace

std::vector<double> start_coordinates(const Robot& robot) {
  std::vector<double> q(robot.joints.size(), 0.0);
  for (std::size_t j = 0; j < q.size(); ++j) {
    const Joint& joint = robot.joints[j];
    if (joint.limit && joint.kind != JointKind::continuous)
      q[j] = std::clamp(0.0, joint.limit->lower, joint.limit->upper);
  }
  // Chains of mimics are as long as there are joints at most.
  for (std::size_t round = 0; round < q.size(); ++round)
    for (std::size_t j = 0; j < q.size(); ++j)
      if (const auto& mimic = robot.joints[j].mimic)
        q[j] = mimic->multiplier * q[static_cast<std::size_t>(mimic->joint)] + mimic->offset;
  return q;
}

Eigen::MatrixXd start_mass_matrix(const Robot& robot, const std::vector<double>& q,
                                  std::vector<int>& joint_of) {
  std::vector<Pose> X_WL(robot.links.size());
  std::vector<std::vector<int>> columns(robot.joints.size());
  std::vector<Vector6d> S;
  joint_of.clear();
  for (const int j : robot.order) {
    const auto i = static_cast<std::size_t>(j);
    const Joint& joint = robot.joints[i];
    const Pose X_WJ = X_WL[static_cast<std::size_t>(joint.parent)] * joint.X_PJ;
    Pose motion;
    if (joint.kind == JointKind::revolute || joint.kind == JointKind::continuous)
      motion.R = mbs::rotation_exp(q[i] * joint.axis);
    if (joint.kind == JointKind::prismatic) motion.p = q[i] * joint.axis;
    X_WL[static_cast<std::size_t>(joint.child)] = X_WJ * motion;
    for (const Vector6d& s : twists(joint, X_WJ)) {
      columns[i].push_back(static_cast<int>(S.size()));
      S.push_back(s);
      joint_of.push_back(j);
    }
  }
  std::vector<Matrix6d> composite(robot.links.size(), Matrix6d::Zero());
  for (std::size_t l = 0; l < robot.links.size(); ++l)
    if (robot.links[l].inertial) composite[l] = spatial_inertia(*robot.links[l].inertial, X_WL[l]);
  for (auto j = robot.order.rbegin(); j != robot.order.rend(); ++j) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(*j)];
    composite[static_cast<std::size_t>(joint.parent)] += composite[static_cast<std::size_t>(joint.child)];
  }
  const auto n = static_cast<Eigen::Index>(S.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t j = 0; j < robot.joints.size(); ++j)
    for (const int i : columns[j]) {
      const Vector6d momentum =
          composite[static_cast<std::size_t>(robot.joints[j].child)] * S[static_cast<std::size_t>(i)];
      for (int at = static_cast<int>(j); at >= 0;) {
        for (const int k : columns[static_cast<std::size_t>(at)])
          H(i, k) = H(k, i) = momentum.dot(S[static_cast<std::size_t>(k)]);
        at = robot.links[static_cast<std::size_t>(robot.joints[static_cast<std::size_t>(at)].parent)]
                 .parent_joint;
      }
    }
  return H;
}

}  // namespace flexura::import::urdf
