// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/scene/scene.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::mbs::chance {

double Law::value(double t) const {
  return a + b * t + c * std::sin(w * t + phi);
}
double Law::rate(double t) const {
  return b + c * w * std::cos(w * t + phi);
}
std::string Law::text(int derivative, double factor) const {
  const auto wave = [&](const char* function, double size) {
    return size == 0.0 ? "" : fmt::format(" + ({:.17g})*{}({:.17g}*t + ({:.17g}))", size, function, w, phi);
  };
  if (derivative == 0)
    return fmt::format("{:.17g} + ({:.17g})*t{}", factor * a, factor * b, wave("sin", factor * c));
  if (derivative == 1) return fmt::format("{:.17g}{}", factor * b, wave("cos", factor * c * w));
  return fmt::format("0{}", wave("sin", -factor * c * w * w));
}

// T F' = level - F.
double SceneForce::actuator_force(double t) const {
  const auto follow = [&](double from, double to, double dt) {
    return to + (from - to) * std::exp(-dt / time_constant);
  };
  return t <= at ? follow(start, level[0], t) : follow(follow(start, level[0], at), level[1], t - at);
}

SceneCurve::SceneCurve(const std::vector<Vector3d>& points) : r_(points), s_(points.size(), 0.0) {
  const auto n = static_cast<Eigen::Index>(points.size());
  for (std::size_t i = 1; i < points.size(); ++i) s_[i] = s_[i - 1] + (points[i] - points[i - 1]).norm();
  Eigen::MatrixXd A = Eigen::MatrixXd::Identity(n, n), b = Eigen::MatrixXd::Zero(n, 3);
  for (Eigen::Index i = 1; i + 1 < n; ++i) {
    const double h = s_[i] - s_[i - 1], k = s_[i + 1] - s_[i];
    A(i, i - 1) = h / 6.0, A(i, i) = (h + k) / 3.0, A(i, i + 1) = k / 6.0;
    b.row(i) = ((r_[i + 1] - r_[i]) / k - (r_[i] - r_[i - 1]) / h).transpose();
  }
  const Eigen::MatrixXd x = A.fullPivLu().solve(b);
  for (Eigen::Index i = 0; i < n; ++i) r_2_.emplace_back(x.row(i).transpose());
}

Vector3d SceneCurve::at(double s) const {
  const std::size_t n = s_.size();
  std::size_t i = 0;
  while (i + 2 < n && s > s_[i + 1]) ++i;
  const double h = s_[i + 1] - s_[i], in = std::clamp(s, s_.front(), s_.back());
  const double a = (s_[i + 1] - in) / h, b = (in - s_[i]) / h;
  Vector3d r =
      a * r_[i] + b * r_[i + 1] + h * h / 6.0 * ((a * a * a - a) * r_2_[i] + (b * b * b - b) * r_2_[i + 1]);
  if (in != s)
    r += (s - in) * ((r_[i + 1] - r_[i]) / h +
                     h / 6.0 * ((1.0 - 3.0 * a * a) * r_2_[i] + (3.0 * b * b - 1.0) * r_2_[i + 1]));
  return r;
}

double SceneCurve::foot(const Vector3d& p) const {
  const double length = s_.back();
  double best = 0.0, least = HUGE_VAL;
  for (int k = -20; k <= 120; ++k)
    if (const double d = (at(0.01 * k * length) - p).norm(); d < least) least = d, best = 0.01 * k * length;
  // Newton's method on (r - p) . r' by differences of order four.
  const double h = 1e-4 * length;
  for (int pass = 0; pass < 8; ++pass) {
    const Vector3d r_1 =
        (8.0 * (at(best + h) - at(best - h)) - (at(best + 2 * h) - at(best - 2 * h))) / (12.0 * h);
    const Vector3d r_2 = (at(best + h) - 2.0 * at(best) + at(best - h)) / (h * h), d = at(best) - p;
    best -= d.dot(r_1) / (r_1.squaredNorm() + d.dot(r_2));
  }
  return best;
}

Places Scene::places() const {
  Places places;
  for (const SceneBody& body : bodies) places.push_back({body.X_WB, Eigen::VectorXd::Zero(body.modes)});
  return places;
}

// A marker keeps its place beside the interface's node, which moves by u and turns by theta.
Pose Scene::marker(int i, const Places& places) const {
  const SceneMarker& marker = markers[i];
  const SceneBody& body = bodies[marker.body];
  const Place& place = places[marker.body];
  if (!body.part) return place.X_WB * marker.X_BP;
  const Vector3d node = body.part->interface_at(marker.interface);
  const Pose carried = body.part->carried(marker.interface, place.q);
  return place.X_WB * Pose{carried.R * marker.X_BP.R, node + carried.p + carried.R * (marker.X_BP.p - node)};
}

int Scene::add_marker(int body, const Pose& X_BP) {
  markers.push_back({body, X_BP});
  return static_cast<int>(markers.size()) - 1;
}

bool Scene::has_loops() const {
  return !constraints.empty() || std::ranges::any_of(joints, [](const SceneJoint& j) { return j.closes; });
}

bool Scene::is_grounded() const {
  const auto on_ground = [&](int marker) { return markers[marker].body == 0; };
  return std::ranges::any_of(joints, [&](const SceneJoint& j) { return on_ground(j.F) || on_ground(j.M); }) ||
         std::ranges::any_of(constraints,
                             [&](const SceneConstraint& c) {
                               return c.terms.empty() && (on_ground(c.F) || on_ground(c.M));
                             }) ||
         std::ranges::any_of(forces, [&](const SceneForce& f) {
           return f.type == "force" || f.type == "torque" ||
                  (f.is_between_markers() && (on_ground(f.F) || on_ground(f.M)));
         });
}

bool Scene::is_flexible() const {
  return std::ranges::any_of(bodies, [](const SceneBody& body) { return body.part != nullptr; });
}

bool Scene::has_beams() const {
  return std::ranges::any_of(bodies, [](const SceneBody& body) { return body.beam.has_value(); });
}

bool Scene::is_conservative() const {
  return std::ranges::none_of(bodies,
                              [](const SceneBody& body) {
                                return (body.part && body.damping > 0.0) ||
                                       (body.beam && body.beam->damping_time > 0.0);
                              }) &&
         std::ranges::none_of(joints, [](const SceneJoint& j) { return !j.drives.empty(); }) &&
         std::ranges::none_of(forces, [](const SceneForce& f) {
           return f.damping != 0.0 || f.turn_damping != 0.0 || f.type == "force" || f.type == "torque" ||
                  f.type == "joint_friction" || f.type == "actuator" || f.type == "joint_force";
         });
}

const std::vector<NamedCoordinate>& coordinates_of(const std::string& type) {
  using C = Coordinate;
  static const NamedCoordinate turn = {"angle",  "speed", "drive", "drive_speed", "drive_acceleration",
                                       C::turn_z};
  static const NamedCoordinate slides[] = {{"x", "v_x", "drive_x", "drive_v_x", "drive_a_x", C::slide_x},
                                           {"y", "v_y", "drive_y", "drive_v_y", "drive_a_y", C::slide_y},
                                           {"z", "v_z", "drive_z", "drive_v_z", "drive_a_z", C::slide_z}};
  static const NamedCoordinate turn_beside = {
      "angle", "speed", "drive_angle", "drive_speed", "drive_acceleration", C::turn_z};
  const auto undriven = [](NamedCoordinate c) {
    c.can_be_driven = false;
    return c;
  };
  static const std::map<std::string, std::vector<NamedCoordinate>> lists = {
      {"revolute", {turn}},
      {"prismatic", {{"position", "speed", "drive", "drive_speed", "drive_acceleration", C::slide_z}}},
      {"screw", {{"angle", "speed", "drive", "drive_speed", "drive_acceleration", C::screw}}},
      {"cylindrical",
       {{"angle", "angular_speed", "drive_angle", "drive_angular_speed", "drive_angular_acceleration",
         C::turn_z},
        {"position", "speed", "drive_position", "drive_speed", "drive_acceleration", C::slide_z}}},
      {"planar", {slides[0], slides[1], turn_beside}},
      {"parallel", {turn_beside, slides[0], slides[1], slides[2]}},
      {"orientation", {slides[0], slides[1], slides[2]}},
      {"universal",
       {{"angle_1", "speed_1", "drive_angle_1", "drive_speed_1", "drive_acceleration_1", C::universal_1},
        {"angle_2", "speed_2", "drive_angle_2", "drive_speed_2", "drive_acceleration_2", C::universal_2}}},
      {"point_on_line", {undriven(slides[2])}},
      {"point_on_plane", {undriven(slides[0]), undriven(slides[1])}}};
  static const std::vector<NamedCoordinate> none;
  const auto found = lists.find(type);
  return found == lists.end() ? none : found->second;
}

double coordinate_value(const SceneJoint& joint, const NamedCoordinate& coordinate, const Pose& X) {
  const double turn = 2.0 * std::numbers::pi, angle = std::atan2(X.R(1, 0), X.R(0, 0));
  switch (coordinate.what) {
    case Coordinate::turn_z:
      return angle;
    case Coordinate::slide_x:
      return X.p.x();
    case Coordinate::slide_y:
      return X.p.y();
    case Coordinate::slide_z:
      return X.p.z();
    case Coordinate::screw:
      return angle + turn * std::rint(X.p.z() / joint.pitch - angle / turn);
    // R = R_x(1) R_y(2): y of M lies in the plane across x of F.
    case Coordinate::universal_1:
      return std::atan2(X.R(2, 1), X.R(1, 1));
    case Coordinate::universal_2:
      return std::atan2(X.R(0, 2), X.R(0, 0));
  }
  return 0.0;
}

}  // namespace flexura::mbs::chance
