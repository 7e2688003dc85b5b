// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/bodies/read_pose.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>

#include "mbs/base/math/rotation.hpp"
#include "mbs/base/math/rotation_sequences.hpp"

namespace flexura::mbs {

using input::Section;

namespace {

// As near as they are written: the rotation nearest to them.
Matrix3d turned_by_cosines(const Section& s) {
  const std::vector<Vector3d> axes = s.vectors3("direction_cosines");
  if (axes.size() != 3) s.refuse("direction_cosines", "is not three vectors", "write the x, y and z axes");
  Matrix3d given;
  for (int i = 0; i < 3; ++i) given.col(i) = axes[static_cast<std::size_t>(i)];
  constexpr double kAsWritten = 1e-3;  // three digits
  const double off = (given.transpose() * given - Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(off <= kAsWritten))
    s.refuse(
        "direction_cosines",
        fmt::format("these axes are not of length 1 and at right angles, by {:.2g} where {:g} is allowed",
                    off, kAsWritten),
        "write three unit vectors");
  if (given.determinant() < 0.0)
    s.refuse("direction_cosines", "these axes are left-handed", "turn one of them round");
  const Eigen::JacobiSVD<Matrix3d> svd(given, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Matrix3d read_rotation(const Section& s) {
  std::string given;
  for (const char* key : {"axis", "rotation", "quaternion", "angles", "direction_cosines"})
    if (s.has(key)) {
      if (!given.empty()) s.refuse("", fmt::format("has both {} and {}", given, key), "keep one");
      given = key;
    }
  if (s.has("x_axis") && given != "axis")
    s.refuse("x_axis", "goes with axis only", "give the z axis by axis");
  if (s.has("sequence") && given != "angles")
    s.refuse("sequence", "goes with angles only", "give the angles");
  if (given == "rotation") return rotation_exp(s.vector3("rotation"));
  if (given == "quaternion") {
    const Eigen::Vector4d q = s.quaternion("quaternion");
    return rotation_of_quaternion(q.data());
  }
  if (given == "angles") return rotation_by_angles(axes_of_sequence(s.text("sequence")), s.vector3("angles"));
  if (given == "direction_cosines") return turned_by_cosines(s);
  if (given.empty()) return Matrix3d::Identity();
  const Vector3d axis = s.vector3("axis");
  if (!(axis.norm() > 0.0)) s.refuse("axis", "has no length", "write for example [0, 0, 1]");
  Matrix3d R = frame_along(axis);
  if (s.has("x_axis")) {
    const Vector3d wanted = s.vector3("x_axis");
    const Vector3d x = wanted - wanted.dot(R.col(2)) * R.col(2);
    if (!(x.norm() > 1e-9 * wanted.norm())) s.refuse("x_axis", "is parallel to axis", "turn it away");
    R.col(0) = x.normalized();
    R.col(1) = R.col(2).cross(R.col(0));
  }
  return R;
}

}  // namespace

std::vector<input::Key> pose_keys(const std::string& of, const std::string& axes) {
  using namespace input;
  return {vector3("position", dim::length, "origin of " + of),
          vector3("axis", dim::none, "direction of the z axis, of any length, in " + axes),
          vector3("x_axis", dim::none, "beside axis: direction that the x axis leans to, in " + axes),
          vector3("rotation", dim::angle, "instead of axis: rotation vector, axis times angle, from " + axes),
          quaternion("quaternion", "instead of axis: (w, x, y, z)"),
          vector3("angles", dim::angle,
                  "instead of axis: turns about three axes, each turned by those before it, from " + axes),
          choice("sequence", rotation_sequences(),
                 "beside angles: the axes of the turns; xyz: Cardan angles, zxz: Euler angles")
              .or_default("xyz"),
          vectors3("direction_cosines", dim::none,
                   "instead of axis: directions of the x, y and z axes, in " + axes)};
}

const std::vector<std::string>& pose_key_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const input::Key& key : pose_keys("", "")) list.push_back(key.name);
    return list;
  }();
  return names;
}

bool has_pose(const Section& s) {
  return std::ranges::any_of(pose_key_names(), [&](const std::string& key) { return s.has(key); });
}

Pose read_pose(const Section& s) {
  return {read_rotation(s), s.has("position") ? s.vector3("position") : Vector3d::Zero()};
}

}  // namespace flexura::mbs
