// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cctype>
#include <numbers>

#include "import/mjcf/model.hpp"
#include "import/xml/values.hpp"
#include "mbs/base/math/rotation.hpp"

namespace flexura::import::mjcf {
namespace {

double radians(double angle, const Compiler& compiler) {
  return compiler.degree ? angle * std::numbers::pi / 180.0 : angle;
}

std::vector<double> wanted(const Node& element, const char* attribute, std::size_t n, Findings& findings) {
  std::vector<double> values = xml::numbers(element, attribute, findings);
  if (values.size() != n) {
    xml::fault(findings, element,
               fmt::format("{} of <{}> has {} numbers, {} are wanted; correct it", attribute,
                           shown(element.tag), values.size(), n));
    values.assign(n, 0.0);
    values[0] = 1.0;
  }
  return values;
}

Matrix3d orientation_of(const Node& element, const Compiler& compiler, Findings& findings) {
  const auto no_direction = [&](const char* attribute) {
    xml::fault(findings, element,
               fmt::format("{} of <{}> is \"{}\", which has no direction; correct it", attribute,
                           shown(element.tag), shown(element.get(attribute))));
    return Matrix3d(Matrix3d::Identity());
  };
  if (element.has("euler"))
    return rotation_by_euler(xml::vector(element, "euler", Vector3d::Zero(), findings), compiler);
  if (element.has("axisangle")) {
    const std::vector<double> a = wanted(element, "axisangle", 4, findings);
    const Vector3d axis(a[0], a[1], a[2]);
    if (!(axis.norm() > 0.0)) return no_direction("axisangle");
    return mbs::rotation_exp(radians(a[3], compiler) * axis.normalized());
  }
  if (element.has("xyaxes")) {
    const std::vector<double> a = wanted(element, "xyaxes", 6, findings);
    const Vector3d x(a[0], a[1], a[2]), y(a[3], a[4], a[5]), z = x.cross(y);
    if (!(z.norm() > 0.0)) return no_direction("xyaxes");
    Matrix3d R;
    R.col(0) = x.normalized();
    R.col(2) = z.normalized();
    R.col(1) = R.col(2).cross(R.col(0));
    return R;
  }
  if (element.has("zaxis")) {
    const Vector3d z = xml::vector(element, "zaxis", Vector3d::UnitZ(), findings);
    if (!(z.norm() > 0.0)) return no_direction("zaxis");
    return Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), z).toRotationMatrix();
  }
  if (element.has("quat")) {
    const std::vector<double> q = wanted(element, "quat", 4, findings);
    if (!(Eigen::Vector4d(q[0], q[1], q[2], q[3]).norm() > 0.0)) return no_direction("quat");
    return mbs::rotation_of_quaternion(q.data());
  }
  return Matrix3d::Identity();
}

}  // namespace

// Small letters turn about the axes as turned before, large ones about those that stand.
Matrix3d rotation_by_euler(const Vector3d& angles, const Compiler& compiler) {
  Matrix3d R = Matrix3d::Identity();
  for (int k = 0; k < 3; ++k) {
    const char letter = compiler.euler_sequence[static_cast<std::size_t>(k)];
    const int axis = (letter | 0x20) - 'x';
    const Matrix3d turn = mbs::rotation_exp(radians(angles[k], compiler) * Vector3d::Unit(axis));
    R = letter >= 'a' ? Matrix3d(R * turn) : Matrix3d(turn * R);
  }
  return R;
}

Pose pose_of(const Node& element, const Compiler& compiler, Findings& findings) {
  return {orientation_of(element, compiler, findings),
          xml::vector(element, "pos", Vector3d::Zero(), findings)};
}

}  // namespace flexura::import::mjcf
