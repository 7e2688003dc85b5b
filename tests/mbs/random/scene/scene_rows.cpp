// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// Joints, constraints and drives as rows on poses.
namespace flexura::mbs::chance {

namespace {

// What a joint's or constraint's rows on X_FM are: lengths along axes of F, and products of axes of F and M.
struct PoseRows {
  std::vector<int> along;                   // p_i = 0
  std::vector<std::pair<int, int>> across;  // R_ij = 0
  bool no_twist = false;                    // R_10 = R_01
};

const PoseRows& pose_rows(const std::string& type) {
  static const std::vector<std::pair<int, int>> axis = {{0, 2}, {1, 2}}, turn = {{0, 1}, {1, 2}, {2, 0}};
  static const std::map<std::string, PoseRows> table = {{"revolute", {{0, 1, 2}, axis}},
                                                        {"prismatic", {{0, 1}, turn}},
                                                        {"cylindrical", {{0, 1}, axis}},
                                                        {"screw", {{0, 1}, axis}},
                                                        {"planar", {{2}, axis}},
                                                        {"spherical", {{0, 1, 2}, {}}},
                                                        {"universal", {{0, 1, 2}, {{0, 1}}}},
                                                        {"constant_velocity", {{0, 1, 2}, {}, true}},
                                                        {"fixed", {{0, 1, 2}, turn}},
                                                        {"free", {}},
                                                        {"orientation", {{}, turn}},
                                                        {"parallel", {{}, axis}},
                                                        {"perpendicular", {{}, {{2, 2}}}},
                                                        {"point_on_line", {{0, 1}, {}}},
                                                        {"point_on_plane", {{2}, {}}}};
  return table.at(type);
}

}  // namespace

void ScenePhysics::list_rows() {
  const Scene& scene = scene_;
  const auto add = [&](const std::string& name, const PoseRows& rows) {
    for (const int i : rows.along)
      names_.push_back(fmt::format("{}.{}", name, "xyz"[i])), is_length_.push_back(true);
    for (const auto& [i, j] : rows.across)
      names_.push_back(fmt::format("{}.axes_{}{}", name, "xyz"[i], "xyz"[j])), is_length_.push_back(false);
    if (rows.no_twist) names_.push_back(name + ".twist"), is_length_.push_back(false);
  };
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const SceneJoint& joint = scene.joints[j];
    const auto& coordinates = coordinates_of(joint.type);
    add(fmt::format("j{}", j), pose_rows(joint.type));
    if (joint.type == "screw") names_.push_back(fmt::format("j{}.thread", j)), is_length_.push_back(true);
    for (const SceneDrive& drive : joint.drives) {
      names_.push_back(fmt::format("j{}.{}.drive", j, coordinates[drive.coordinate].name));
      is_length_.push_back(!coordinates[drive.coordinate].is_angle());
      is_integrated_.resize(names_.size());
      is_integrated_.back() = drive.derivative > 0;
    }
    turns_.emplace_back(coordinates.size(), 0.0);
  }
  for (std::size_t c = 0; c < scene.constraints.size(); ++c) {
    const SceneConstraint& constraint = scene.constraints[c];
    const std::string name = fmt::format("c{}", c);
    if (constraint.type == "distance") {
      names_.push_back(name + ".length"), is_length_.push_back(true);
    } else if (constraint.type == "rolling_disc") {
      names_.push_back(name + ".height"), is_length_.push_back(true);
      for (const char* row : {".slip_x", ".slip_y"}) {
        slip_rows_.push_back(n_rows());
        names_.push_back(name + row), is_length_.push_back(true);
      }
    } else if (constraint.type == "point_on_curve") {
      for (const char* row : {".side", ".up"}) names_.push_back(name + row), is_length_.push_back(true);
    } else if (!constraint.terms.empty()) {
      const auto& term = constraint.terms[0];
      names_.push_back(name + ".ratio");
      is_length_.push_back(!coordinates_of(scene.joints[term.joint].type)[term.coordinate].is_angle());
    } else {
      add(name, pose_rows(constraint.type));
    }
  }
  is_integrated_.resize(names_.size());
}

double ScenePhysics::value(int j, int i, const Places& X) const {
  const SceneJoint& joint = scene_.joints[j];
  const NamedCoordinate& c = coordinates_of(joint.type)[i];
  const double q = coordinate_value(joint, c, marker(joint.F, X).inverse() * marker(joint.M, X));
  if (!c.is_angle()) return q;
  const double turn = 2.0 * std::numbers::pi;
  return q + turn * std::rint((turns_[j][i] - q) / turn);
}
double ScenePhysics::coordinate(int j, int i, const Places& X) const {
  return value(j, i, X);
}

void ScenePhysics::count_turns_from(const Places& places) {
  for (std::size_t j = 0; j < turns_.size(); ++j)
    for (std::size_t i = 0; i < turns_[j].size(); ++i)
      turns_[j][i] = value(static_cast<int>(j), static_cast<int>(i), places);
}

namespace {
// From a disc's centre to its lowest point over the xy plane of F: in its plane, as far down as that goes.
Vector3d lowest(const Pose& X_FM) {
  const Vector3d axis = X_FM.R.col(2), down = -Vector3d::UnitZ();
  return (down - axis * axis.dot(down)).normalized();
}
}  // namespace

Eigen::VectorXd ScenePhysics::slip(const Places& X, const Eigen::VectorXd& v) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(slip_rows_.size()));
  Eigen::Index k = 0;
  for (const SceneConstraint& c : scene_.constraints) {
    if (c.type != "rolling_disc") continue;
    const Pose X_F = marker(c.F, X), X_M = marker(c.M, X);
    const Vector3d at = X_M.p + c.length * (X_F.R * lowest(X_F.inverse() * X_M));
    const auto velocity = [&](int m) {
      const Spatial V = marker_twist(m, X, v);
      return Vector3d(V.linear + V.angular.cross(at - marker(m, X).p));
    };
    const Vector3d slides = X_F.R.transpose() * (velocity(c.M) - velocity(c.F));
    out(k++) = slides.x();
    out(k++) = slides.y();
  }
  return out;
}

Eigen::VectorXd ScenePhysics::rows(const Places& X, double t) const {
  Eigen::VectorXd g(n_rows());
  int k = 0;
  const auto add = [&](const PoseRows& rows, const Pose& X_FM) {
    for (const int i : rows.along) g(k++) = X_FM.p(i);
    for (const auto& [i, j] : rows.across) g(k++) = X_FM.R(i, j);
    if (rows.no_twist) g(k++) = X_FM.R(1, 0) - X_FM.R(0, 1);
  };
  for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
    const SceneJoint& joint = scene_.joints[j];
    const Pose X_FM = marker(joint.F, X).inverse() * marker(joint.M, X);
    add(pose_rows(joint.type), X_FM);
    if (joint.type == "screw")
      g(k++) = X_FM.p.z() - joint.pitch / (2.0 * std::numbers::pi) * value(static_cast<int>(j), 0, X);
    for (const SceneDrive& drive : joint.drives)
      g(k++) = value(static_cast<int>(j), drive.coordinate, X) - drive.law.value(t);
  }
  for (const SceneConstraint& c : scene_.constraints) {
    if (c.type == "distance") {
      g(k++) = (marker(c.M, X).p - marker(c.F, X).p).norm() - c.length;
    } else if (c.type == "rolling_disc") {
      const Pose X_FM = marker(c.F, X).inverse() * marker(c.M, X);
      g(k++) = X_FM.p.z() + c.length * lowest(X_FM).z();
      g(k++) = 0.0;
      g(k++) = 0.0;
    } else if (c.type == "point_on_curve") {
      const Vector3d P = (marker(c.F, X).inverse() * marker(c.M, X)).p;
      const SceneCurve curve(c.points);
      const double s = curve.foot(P), h = 1e-4;
      const Vector3d along =
          (8.0 * (curve.at(s + h) - curve.at(s - h)) - (curve.at(s + 2 * h) - curve.at(s - 2 * h)))
              .normalized();
      const Vector3d side = Vector3d::UnitZ().cross(along).normalized();
      g(k++) = side.dot(P - curve.at(s));
      g(k++) = along.cross(side).dot(P - curve.at(s));
    } else if (c.type == "gear") {
      g(k++) = value(c.terms[0].joint, c.terms[0].coordinate, X) +
               (c.internal ? -1.0 : 1.0) * c.teeth_2 / c.teeth_1 *
                   value(c.terms[1].joint, c.terms[1].coordinate, X) -
               c.offset;
    } else if (c.type == "rack_and_pinion") {
      g(k++) = value(c.terms[0].joint, c.terms[0].coordinate, X) -
               c.length * value(c.terms[1].joint, c.terms[1].coordinate, X) - c.offset;
    } else if (c.type == "coupler") {
      double sum = -c.offset;
      for (const auto& term : c.terms) sum += term.factor * value(term.joint, term.coordinate, X);
      g(k++) = sum;
    } else {
      add(pose_rows(c.type), marker(c.F, X).inverse() * marker(c.M, X));
    }
  }
  return g;
}

}  // namespace flexura::mbs::chance
