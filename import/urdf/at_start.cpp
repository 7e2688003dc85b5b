// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/urdf/at_start.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

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
Matrix6d spatial_inertia(const MassProperties& inertial, const Pose& X_WL) {
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
    case JointKind::floating:
    case JointKind::spherical: {
      std::vector<Vector6d> all;
      for (int k = 0; k < 3; ++k) all.push_back(turn(Vector3d::Unit(k)));
      if (joint.kind == JointKind::floating)
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

Pose motion_of(const Joint& joint, double q) {
  Pose motion;
  if (turns(joint)) motion.R = mbs::rotation_exp(q * joint.axis);
  if (joint.kind == JointKind::prismatic) motion.p = q * joint.axis;
  return motion;
}

void fix(Joint& joint, double& q) {
  joint.X_PJ = joint.X_PJ * motion_of(joint, q);
  joint.kind = JointKind::fixed;
  joint.mimic.reset();
  joint.limit.reset();
  q = 0.0;
}

std::vector<Pose> link_poses(const Robot& robot, const std::vector<double>& q) {
  std::vector<Pose> X_WL(robot.links.size());
  for (const int j : robot.order) {
    const auto i = static_cast<std::size_t>(j);
    const Joint& joint = robot.joints[i];
    X_WL[static_cast<std::size_t>(joint.child)] =
        X_WL[static_cast<std::size_t>(joint.parent)] * joint.X_PJ * motion_of(joint, q[i]);
  }
  return X_WL;
}

StartMass start_mass(const Robot& robot, const std::vector<double>& q) {
  const std::vector<Pose> X_WL = link_poses(robot, q);
  std::vector<std::vector<int>> columns(robot.joints.size());
  std::vector<Vector6d> S;
  StartMass out;
  for (const int j : robot.order) {
    const auto i = static_cast<std::size_t>(j);
    const Joint& joint = robot.joints[i];
    if (joint.is_driven) continue;
    for (const Vector6d& s : twists(joint, X_WL[static_cast<std::size_t>(joint.parent)] * joint.X_PJ)) {
      columns[i].push_back(static_cast<int>(S.size()));
      S.push_back(s);
      out.joint_of.push_back(j);
    }
  }
  std::vector<Matrix6d> composite(robot.links.size(), Matrix6d::Zero());
  for (std::size_t l = 0; l < robot.links.size(); ++l)
    if (robot.links[l].inertial) composite[l] = spatial_inertia(*robot.links[l].inertial, X_WL[l]);
  std::vector<Matrix6d> size = composite;
  for (Matrix6d& M : size) M = M.cwiseAbs();
  for (auto at = robot.order.rbegin(); at != robot.order.rend(); ++at) {
    const Joint& joint = robot.joints[static_cast<std::size_t>(*at)];
    const auto parent = static_cast<std::size_t>(joint.parent), child = static_cast<std::size_t>(joint.child);
    composite[parent] += composite[child];
    size[parent] += size[child];
  }
  const auto n = static_cast<Eigen::Index>(S.size());
  out.H = Eigen::MatrixXd::Zero(n, n);
  out.size = Eigen::VectorXd::Zero(n);
  for (std::size_t j = 0; j < robot.joints.size(); ++j)
    for (const int i : columns[j]) {
      const auto child = static_cast<std::size_t>(robot.joints[j].child);
      const Vector6d& s = S[static_cast<std::size_t>(i)];
      const Vector6d momentum = composite[child] * s;
      out.size[i] = s.cwiseAbs().dot(size[child] * s.cwiseAbs());
      for (int at = static_cast<int>(j); at >= 0;) {
        for (const int k : columns[static_cast<std::size_t>(at)])
          out.H(i, k) = out.H(k, i) = momentum.dot(S[static_cast<std::size_t>(k)]);
        at = robot.links[static_cast<std::size_t>(robot.joints[static_cast<std::size_t>(at)].parent)]
                 .parent_joint;
      }
    }
  return out;
}

// The coordinates that mimic others are not free: H in those that are must be positive definite.  Scaled to
// a unit diagonal; a rank that is missing leaves a pivot of round-off, n 1e-16, against which 1e-10 is wide:
// a robot's lightest link turns with 1e-6 or more of what hangs on its joint.
std::vector<Idle> idle_joints(const Robot& robot, const std::vector<double>& q, bool alone) {
  const StartMass start = start_mass(robot, q);
  const auto n = start.H.rows();
  std::vector<Eigen::Index> free;
  Eigen::MatrixXd T = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    double factor = 1.0;
    int joint = start.joint_of[static_cast<std::size_t>(i)];
    while (!alone && robot.joints[static_cast<std::size_t>(joint)].mimic) {
      const Mimic& mimic = *robot.joints[static_cast<std::size_t>(joint)].mimic;
      factor *= mimic.multiplier;
      joint = mimic.joint;
    }
    if (joint == start.joint_of[static_cast<std::size_t>(i)]) {
      free.push_back(i);
      T(i, i) = 1.0;
    } else if (const auto leader = std::ranges::find(start.joint_of, joint); leader != start.joint_of.end()) {
      T(i, leader - start.joint_of.begin()) = factor;  // of one that is driven: held with it
    }
  }
  const Eigen::MatrixXd H = (T.transpose() * start.H * T)(free, free);
  const Eigen::VectorXd size = (T.cwiseAbs2().transpose() * start.size)(free);
  std::vector<Idle> out;
  const auto add = [&](Eigen::Index i, bool moves_nothing) {
    const int joint = start.joint_of[static_cast<std::size_t>(free[static_cast<std::size_t>(i)])];
    if (out.empty() || out.back().joint != joint) out.push_back({joint, moves_nothing});
  };
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(H.rows());
  for (Eigen::Index i = 0; i < H.rows(); ++i)
    if (H(i, i) > 1e-13 * size[i]) scale[i] = 1.0 / std::sqrt(H(i, i));
  Eigen::MatrixXd L = scale.asDiagonal() * H * scale.asDiagonal();
  for (Eigen::Index k = 0; k < L.rows(); ++k) {  // Cholesky, column by column
    if (!(L(k, k) > 1e-10)) {
      add(k, scale[k] == 0.0);
      L.col(k).tail(L.rows() - k).setZero();
      continue;
    }
    L.col(k).tail(L.rows() - k) /= std::sqrt(L(k, k));
    for (Eigen::Index j = k + 1; j < L.rows(); ++j)
      L.col(j).tail(L.rows() - j) -= L(j, k) * L.col(k).tail(L.rows() - j);
  }
  return out;
}

}  // namespace flexura::import::urdf
