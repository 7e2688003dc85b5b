// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/tree/start_mass.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::import::tree {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

Matrix3d cross_matrix(const Vector3d& a) {
  Matrix3d A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

// About the world's origin, for twists (angular, linear of the point at the origin).
Matrix6d spatial_inertia(const Inertial& inertial, const Pose& X_WL) {
  const Matrix3d C = cross_matrix(X_WL * inertial.center);
  const Matrix3d I = X_WL.R * inertial.inertia * X_WL.R.transpose();
  Matrix6d M;
  M << I + inertial.mass * C * C.transpose(), inertial.mass * C, inertial.mass * C.transpose(),
      inertial.mass * Matrix3d::Identity();
  return M;
}

Vector6d twist(const Vector3d& angular, const Vector3d& linear) {
  Vector6d S;
  S << angular, linear;
  return S;
}

// Of a joint whose marker M stands at X_WM.
std::vector<Vector6d> twists_of(const Joint& joint, const Pose& X_WM) {
  const Vector3d z = X_WM.R.col(2);
  switch (joint.kind) {
    case JointKind::fixed:
      return {};
    case JointKind::revolute:
      return {twist(z, X_WM.p.cross(z))};
    case JointKind::screw:
      return {twist(z, X_WM.p.cross(z) + joint.pitch / (2.0 * std::numbers::pi) * z)};
    case JointKind::prismatic:
      return {twist(Vector3d::Zero(), z)};
    default:
      break;
  }
  std::vector<Vector6d> all;
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = X_WM.R.col(k);
    all.push_back(twist(axis, X_WM.p.cross(axis)));
  }
  if (joint.kind == JointKind::free)
    for (int k = 0; k < 3; ++k) all.push_back(twist(Vector3d::Zero(), Vector3d::Unit(k)));
  return all;
}

}  // namespace

Pose start_motion(const Joint& joint) {
  switch (joint.kind) {
    case JointKind::revolute:
      return {mbs::rotation_exp({0.0, 0.0, joint.start}), Vector3d::Zero()};
    case JointKind::prismatic:
      return {Matrix3d::Identity(), {0.0, 0.0, joint.start}};
    case JointKind::screw:
      return {mbs::rotation_exp({0.0, 0.0, joint.start}),
              {0.0, 0.0, joint.start * joint.pitch / (2.0 * std::numbers::pi)}};
    case JointKind::fixed:
      return {};
    default:
      return joint.X_FM;
  }
}

std::vector<Pose> start_poses(const Tree& tree) {
  std::vector<Pose> X_WL(tree.links.size());
  for (const Joint& joint : tree.joints) {
    if (joint.closes_loop) continue;
    const Pose X_WI = joint.inner() < 0 ? Pose{} : X_WL[static_cast<std::size_t>(joint.inner())];
    const Pose X_PC = joint.X_PF * start_motion(joint) * joint.X_CM.inverse();
    X_WL[static_cast<std::size_t>(joint.outer())] = X_WI * (joint.reversed ? X_PC.inverse() : X_PC);
  }
  return X_WL;
}

StartMass::StartMass(const Tree& tree)
    : tree_(tree), first_(tree.joints.size(), -1), joint_to_(tree.links.size(), -1) {
  const std::vector<Pose> X_WL = start_poses(tree);
  std::vector<int> block_of_link(tree.links.size(), -1);
  for (std::size_t j = 0; j < tree.joints.size(); ++j) {
    const Joint& joint = tree.joints[j];
    if (joint.closes_loop) continue;
    const auto outer = static_cast<std::size_t>(joint.outer());
    joint_to_[outer] = static_cast<int>(j);
    int& block = block_of_link[outer];
    if (joint.inner() >= 0) block = block_of_link[static_cast<std::size_t>(joint.inner())];
    if (block < 0 && joint.freedoms() > 0) {
      block = static_cast<int>(blocks_.size());
      blocks_.emplace_back();
    }
    first_[j] = static_cast<int>(twists_.size());
    for (const Vector6d& S : twists_of(joint, X_WL[outer] * (joint.reversed ? joint.X_PF : joint.X_CM))) {
      Block& own = blocks_[static_cast<std::size_t>(block)];
      index_in_block_.push_back(static_cast<int>(own.coordinates.size()));
      own.coordinates.push_back(static_cast<int>(twists_.size()));
      block_of_.push_back(block);
      joint_of_.push_back(static_cast<int>(j));
      twists_.push_back(S);
    }
  }
  std::vector<Matrix6d> composite;
  for (std::size_t l = 0; l < tree.links.size(); ++l)
    composite.push_back(spatial_inertia(tree.links[l].inertial, X_WL[l]));
  for (auto joint = tree.joints.rbegin(); joint != tree.joints.rend(); ++joint)
    if (!joint->closes_loop && joint->inner() >= 0)
      composite[static_cast<std::size_t>(joint->inner())] +=
          composite[static_cast<std::size_t>(joint->outer())];
  for (Block& block : blocks_) {
    const auto n = static_cast<Eigen::Index>(block.coordinates.size());
    block.H = Eigen::MatrixXd::Zero(n, n);
  }
  for (std::size_t i = 0; i < twists_.size(); ++i) {
    const Joint& joint = tree.joints[static_cast<std::size_t>(joint_of_[i])];
    const Vector6d f = composite[static_cast<std::size_t>(joint.outer())] * twists_[i];
    Eigen::MatrixXd& H = blocks_[static_cast<std::size_t>(block_of_[i])].H;
    const int a = index_in_block_[i];
    for (int j = joint_of_[i]; j >= 0;) {
      const Joint& before = tree.joints[static_cast<std::size_t>(j)];
      for (int k = 0; k < before.freedoms(); ++k) {
        const auto other = static_cast<std::size_t>(first(j) + k);
        H(a, index_in_block_[other]) = H(index_in_block_[other], a) = twists_[other].dot(f);
      }
      j = before.inner() < 0 ? -1 : joint_to_[static_cast<std::size_t>(before.inner())];
    }
    H(a, a) += joint.armature;
  }
  // Scaled to a unit diagonal.  A rank that is missing leaves a pivot of round-off, n 1e-16, against which 1e-12 is
  // wide; the lightest link turns with some 1e-8 of what hangs on its joint.
  for (Block& block : blocks_) {
    const Eigen::Index n = block.H.rows();
    Eigen::VectorXd scale(n);
    for (Eigen::Index k = 0; k < n; ++k)
      scale(k) = block.H(k, k) > 0.0 ? 1.0 / std::sqrt(block.H(k, k)) : 0.0;
    block.L = scale.asDiagonal() * block.H * scale.asDiagonal();
    for (Eigen::Index k = 0; k < n; ++k) {  // column by column
      if (!(block.L(k, k) > 1e-12)) break;
      block.L.col(k).tail(n - k) /= std::sqrt(block.L(k, k));
      for (Eigen::Index j = k + 1; j < n; ++j)
        block.L.col(j).tail(n - j) -= block.L(j, k) * block.L.col(k).tail(n - j);
      ++block.rank;
    }
    for (Eigen::Index k = 0; k < n; ++k) block.L.row(k) /= scale(k) > 0.0 ? scale(k) : 1.0;
  }
}

void StartMass::require_inertia(Findings& findings) const {
  for (const Block& block : blocks_) {
    if (block.rank == static_cast<int>(block.coordinates.size())) continue;
    const int coordinate = block.coordinates[static_cast<std::size_t>(block.rank)];
    const Joint& joint =
        tree_.joints[static_cast<std::size_t>(joint_of_[static_cast<std::size_t>(coordinate)])];
    findings.fault(
        fmt::format("joint \"{}\" moves bodies without inertia{}, so its acceleration would be "
                    "anything; give the bodies behind it mass and inertia, or take the joint away",
                    shown(joint.name),
                    block.H(block.rank, block.rank) > 0.0 ? " apart from the joints before it" : ""),
        joint.line);
  }
}

double StartMass::diagonal(int coordinate) const {
  const auto c = static_cast<std::size_t>(coordinate);
  return blocks_[static_cast<std::size_t>(block_of_[c])].H(index_in_block_[c], index_in_block_[c]);
}

double StartMass::compliance(const Row& row) const {
  double sum = 0.0;
  for (std::size_t b = 0; b < blocks_.size(); ++b) {
    const Block& block = blocks_[b];
    Eigen::VectorXd x = Eigen::VectorXd::Zero(block.H.rows());
    bool any = false;
    for (const auto& [coordinate, factor] : row)
      if (block_of_[static_cast<std::size_t>(coordinate)] == static_cast<int>(b)) {
        x(index_in_block_[static_cast<std::size_t>(coordinate)]) += factor;
        any = true;
      }
    if (!any || block.rank < static_cast<int>(block.coordinates.size())) continue;
    sum += block.L.triangularView<Eigen::Lower>().solve(x).squaredNorm();
  }
  return std::isfinite(sum) ? sum : 0.0;
}

StartMass::Row StartMass::moves(int link, const Vector3d& x, const Vector3d& n) const {
  Row row;
  for (int j = link < 0 ? -1 : joint_to_[static_cast<std::size_t>(link)]; j >= 0;) {
    const Joint& joint = tree_.joints[static_cast<std::size_t>(j)];
    for (int k = 0; k < joint.freedoms(); ++k) {
      const Vector6d& S = twists_[static_cast<std::size_t>(first(j) + k)];
      row.emplace_back(first(j) + k, n.dot(S.tail<3>() + S.head<3>().cross(x)));
    }
    j = joint.inner() < 0 ? -1 : joint_to_[static_cast<std::size_t>(joint.inner())];
  }
  return row;
}

}  // namespace flexura::import::tree
