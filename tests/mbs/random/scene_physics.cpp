// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/scene_physics.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "mbs/base/math/rotation.hpp"

namespace flexura::mbs::chance {

namespace {

constexpr double kRankLost = 1e-7;

// What a joint's or constraint's rows on X_FM are: lengths along axes of F, and products of axes of F and M.
struct PoseRows {
  std::vector<int> along;                      // p_i = 0
  std::vector<std::pair<int, int>> across;     // R_ij = 0
  bool no_twist = false;                       // R_10 = R_01
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

ScenePhysics::ScenePhysics(const Scene& scene) : scene_(scene), n_(static_cast<int>(scene.bodies.size()) - 1) {
  const std::vector<Pose> X = scene.poses();
  std::vector<Vector3d> points;
  for (int m = 0; m < static_cast<int>(scene.markers.size()); ++m) points.push_back(marker(m, X).p);
  for (int b = 1; b <= n_; ++b) points.push_back(X[b].p), points.push_back(X[b] * scene.bodies[b].center);
  size_ = 0.1;
  for (const Vector3d& p : points)
    for (const Vector3d& q : points) size_ = std::max(size_, (p - q).norm());
  const auto add = [&](const std::string& name, const PoseRows& rows) {
    for (const int i : rows.along) names_.push_back(fmt::format("{}.{}", name, "xyz"[i])), is_length_.push_back(true);
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
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    for (std::size_t i = 0; i < turns_[j].size(); ++i)
      turns_[j][i] = coordinate_value(scene.joints[j], coordinates_of(scene.joints[j].type)[i],
                                      marker(scene.joints[j].F, X).inverse() * marker(scene.joints[j].M, X));
}

double ScenePhysics::value(int j, int i, const std::vector<Pose>& X) const {
  const SceneJoint& joint = scene_.joints[j];
  const NamedCoordinate& c = coordinates_of(joint.type)[i];
  const double q = coordinate_value(joint, c, marker(joint.F, X).inverse() * marker(joint.M, X));
  if (!c.is_angle()) return q;
  const double turn = 2.0 * std::numbers::pi;
  return q + turn * std::rint((turns_[j][i] - q) / turn);
}
double ScenePhysics::coordinate(int j, int i, const std::vector<Pose>& X) const { return value(j, i, X); }

void ScenePhysics::count_turns_from(const std::vector<BodyMotion>& motion, double) {
  std::vector<Pose> X;
  for (const BodyMotion& body : motion) X.push_back(body.X_WB);
  for (std::size_t j = 0; j < turns_.size(); ++j)
    for (std::size_t i = 0; i < turns_[j].size(); ++i)
      turns_[j][i] = value(static_cast<int>(j), static_cast<int>(i), X);
}

namespace {
// From a disc's centre to its lowest point over the xy plane of F: in its plane, as far down as that goes.
Vector3d lowest(const Pose& X_FM) {
  const Vector3d axis = X_FM.R.col(2), down = -Vector3d::UnitZ();
  return (down - axis * axis.dot(down)).normalized();
}
}  // namespace

Eigen::VectorXd ScenePhysics::slip(const std::vector<Pose>& X, const Eigen::VectorXd& v) const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(slip_rows_.size()));
  Eigen::Index k = 0;
  for (const SceneConstraint& c : scene_.constraints) {
    if (c.type != "rolling_disc") continue;
    const Pose X_F = marker(c.F, X), X_M = marker(c.M, X);
    const Vector3d at = X_M.p + c.length * (X_F.R * lowest(X_F.inverse() * X_M));
    const auto velocity = [&](int b) {
      if (b == 0) return Vector3d(Vector3d::Zero());
      const Vector3d w = v.segment<3>(6 * b - 6), u = v.segment<3>(6 * b - 3);
      return Vector3d(u + w.cross(at - X[b] * scene_.bodies[b].center));
    };
    const Vector3d slides =
        X_F.R.transpose() * (velocity(scene_.markers[c.M].body) - velocity(scene_.markers[c.F].body));
    out(k++) = slides.x();
    out(k++) = slides.y();
  }
  return out;
}

Eigen::VectorXd ScenePhysics::rows(const std::vector<Pose>& X, double t) const {
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
          (8.0 * (curve.at(s + h) - curve.at(s - h)) - (curve.at(s + 2 * h) - curve.at(s - 2 * h))).normalized();
      const Vector3d side = Vector3d::UnitZ().cross(along).normalized();
      g(k++) = side.dot(P - curve.at(s));
      g(k++) = along.cross(side).dot(P - curve.at(s));
    } else if (c.type == "gear") {
      g(k++) = value(c.terms[0].joint, c.terms[0].coordinate, X) +
               (c.internal ? -1.0 : 1.0) * c.teeth_2 / c.teeth_1 * value(c.terms[1].joint, c.terms[1].coordinate, X) -
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

// Each body by d = (turn, displacement of its centre of mass).
std::vector<Pose> ScenePhysics::moved(const std::vector<Pose>& X, const Eigen::VectorXd& d) const {
  std::vector<Pose> out = X;
  for (int b = 1; b <= n_; ++b) {
    const Vector3d centre = X[b] * scene_.bodies[b].center + d.segment<3>(6 * (b - 1) + 3);
    out[b].R = rotation_exp(d.segment<3>(6 * (b - 1))) * X[b].R;
    out[b].p = centre - out[b].R * scene_.bodies[b].center;
  }
  return out;
}

namespace {
// Differences of order four: with values up to 1, derivatives grow by 1 / h's scale; errors 1e-13 and 1e-9.
constexpr double kFirst = 1e-3, kSecond = 3e-3;
template <class F>
auto first_difference(F&& f, double h) {
  return Eigen::VectorXd((8.0 * (f(h) - f(-h)) - (f(2.0 * h) - f(-2.0 * h))) / (12.0 * h));
}
template <class F>
auto second_difference(F&& f, double h) {
  return Eigen::VectorXd(
      (16.0 * (f(h) + f(-h)) - (f(2.0 * h) + f(-2.0 * h)) - 30.0 * f(0.0)) / (12.0 * h * h));
}
std::vector<Pose> poses_of(const std::vector<BodyMotion>& motion) {
  std::vector<Pose> X;
  for (const BodyMotion& body : motion) X.push_back(body.X_WB);
  return X;
}
}  // namespace

Eigen::MatrixXd ScenePhysics::jacobian(const std::vector<Pose>& X, double t, Eigen::VectorXd* g_t) const {
  Eigen::MatrixXd G(n_rows(), 6 * n_);
  Eigen::VectorXd d = Eigen::VectorXd::Zero(6 * n_);
  for (int i = 0; i < 6 * n_; ++i) {
    G.col(i) = first_difference(
        [&](double h) {
          d(i) = i % 6 < 3 ? h : h * size_;
          return rows(moved(X, d), t);
        },
        kFirst);
    if (i % 6 >= 3) G.col(i) /= size_;
    d(i) = 0.0;
    if (slip_rows_.empty()) continue;
    const Eigen::VectorXd slides = slip(X, Eigen::VectorXd::Unit(6 * n_, i));
    for (std::size_t k = 0; k < slip_rows_.size(); ++k) G(slip_rows_[k], i) = slides(static_cast<Eigen::Index>(k));
  }
  if (g_t) *g_t = first_difference([&](double h) { return rows(X, t + h); }, kFirst);
  return G;
}

namespace {
Eigen::VectorXd velocities_of(const std::vector<BodyMotion>& motion) {
  Eigen::VectorXd v(6 * (motion.size() - 1));
  for (std::size_t b = 1; b < motion.size(); ++b) v.segment<6>(6 * (b - 1)) = motion[b].V.vector();
  return v;
}
// Differences in time take steps that turn and move no body far.
double calm(const Eigen::VectorXd& v, double size) {
  double fastest = 1.0;
  for (Eigen::Index i = 0; i < v.size(); i += 6)
    fastest = std::max({fastest, v.segment<3>(i).norm(), v.segment<3>(i + 3).norm() / size});
  return 1.0 / fastest;
}
}  // namespace

Eigen::VectorXd ScenePhysics::rates(const std::vector<BodyMotion>& motion, double t) const {
  const std::vector<Pose> X = poses_of(motion);
  const Eigen::VectorXd v = velocities_of(motion);
  Eigen::VectorXd out =
      first_difference([&](double h) { return rows(moved(X, h * v), t + h); }, kFirst * calm(v, size_));
  const Eigen::VectorXd slides = slip(X, v);
  for (std::size_t k = 0; k < slip_rows_.size(); ++k) out(slip_rows_[k]) = slides(static_cast<Eigen::Index>(k));
  return out;
}

Eigen::VectorXd ScenePhysics::gamma(const std::vector<BodyMotion>& motion, double t) const {
  const std::vector<Pose> X = poses_of(motion);
  const Eigen::VectorXd v = velocities_of(motion);
  Eigen::VectorXd out =
      second_difference([&](double h) { return rows(moved(X, h * v), t + h); }, kSecond * calm(v, size_));
  if (slip_rows_.empty()) return out;
  const Eigen::VectorXd slides =
      first_difference([&](double h) { return slip(moved(X, h * v), v); }, kFirst * calm(v, size_));
  for (std::size_t k = 0; k < slip_rows_.size(); ++k) out(slip_rows_[k]) = slides(static_cast<Eigen::Index>(k));
  return out;
}

double ScenePhysics::speed(int j, int i, const std::vector<BodyMotion>& motion) const {
  const std::vector<Pose> X = poses_of(motion);
  const Eigen::VectorXd v = velocities_of(motion);
  return first_difference(
      [&](double h) { return Eigen::VectorXd::Constant(1, value(j, i, moved(X, h * v))); },
      kFirst * calm(v, size_))(0);
}

Matrix3d ScenePhysics::inertia(int b, const Pose& X) const {
  return X.R * scene_.bodies[b].inertia * X.R.transpose();
}

Eigen::MatrixXd ScenePhysics::inverse_root_mass(const std::vector<Pose>& X) const {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(6 * n_, 6 * n_);
  for (int b = 1; b <= n_; ++b) {
    D.block<3, 3>(6 * b - 6, 6 * b - 6) =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(inertia(b, X[b])).operatorInverseSqrt();
    D.block<3, 3>(6 * b - 3, 6 * b - 3) = Matrix3d::Identity() / std::sqrt(scene_.bodies[b].mass);
  }
  return D;
}

Eigen::VectorXd ScenePhysics::row_scale() const {
  Eigen::VectorXd scale(n_rows());
  for (int k = 0; k < n_rows(); ++k) scale(k) = is_length_[k] ? 1.0 / size_ : 1.0;
  return scale;
}

namespace {
ScenePhysics::Rank rank_of(const Eigen::VectorXd& sigma) {
  ScenePhysics::Rank rank;
  if (sigma.size() == 0 || sigma(0) == 0.0) return rank;
  for (const double s : sigma) {
    if (s > kRankLost * sigma(0)) {
      ++rank.rank;
      rank.smallest = s / sigma(0);
    } else {
      rank.next = std::max(rank.next, s / sigma(0));
    }
  }
  return rank;
}
// Rows of one length each: a gear of 100 teeth is no better row than one of 10.
void normalise(Eigen::MatrixXd& G, Eigen::VectorXd& right) {
  const double largest = G.size() > 0 ? G.rowwise().norm().maxCoeff() : 0.0;
  for (Eigen::Index k = 0; k < G.rows(); ++k) {
    const double norm = G.row(k).norm();
    if (!(norm > 1e-6 * largest)) continue;
    G.row(k) /= norm;
    right(k) /= norm;
  }
}
}  // namespace

ScenePhysics::Rank ScenePhysics::rank(const std::vector<Pose>& X, double t) const {
  if (n_rows() == 0) return {};
  Eigen::MatrixXd G = row_scale().asDiagonal() * jacobian(X, t) * inverse_root_mass(X);
  Eigen::VectorXd none = Eigen::VectorXd::Zero(n_rows());
  normalise(G, none);
  return rank_of(Eigen::JacobiSVD<Eigen::MatrixXd>(G).singularValues());
}

Eigen::VectorXd ScenePhysics::forces(const std::vector<BodyMotion>& motion, double t) const {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(6 * n_);
  const std::vector<Pose> X = poses_of(motion);
  const auto centre = [&](int b) { return Vector3d(X[b] * scene_.bodies[b].center); };
  const auto put = [&](int b, const Vector3d& at, const Vector3d& force, const Vector3d& torque) {
    if (b == 0) return;
    f.segment<3>(6 * b - 6) += torque + (at - centre(b)).cross(force);
    f.segment<3>(6 * b - 3) += force;
  };
  const auto velocity = [&](int b, const Vector3d& at) {
    return b == 0 ? Vector3d(Vector3d::Zero())
                  : Vector3d(motion[b].V.linear + motion[b].V.angular.cross(at - centre(b)));
  };
  for (int b = 1; b <= n_; ++b) {
    const Matrix3d I = inertia(b, X[b]);
    const Vector3d& w = motion[b].V.angular;
    put(b, centre(b), scene_.bodies[b].mass * scene_.gravity, -w.cross(I * w));
  }
  const Vector3d none = Vector3d::Zero();
  for (const SceneForce& force : scene_.forces) {
    if (force.type == "spring_damper") {
      const int A = scene_.markers[force.F].body, B = scene_.markers[force.M].body;
      const Vector3d P = marker(force.F, X).p, Q = marker(force.M, X).p, r = Q - P, e = r.normalized();
      const double tension = force.stiffness * (r.norm() - force.rest) +
                             force.damping * e.dot(velocity(B, Q) - velocity(A, P));
      put(A, P, tension * e, none);
      put(B, Q, -tension * e, none);
    } else if (force.type == "bushing") {
      const int A = scene_.markers[force.F].body, B = scene_.markers[force.M].body;
      for (const int b : {A, B})
        for (int i = 0; b > 0 && i < 6; ++i) {
          Eigen::VectorXd d = Eigen::VectorXd::Zero(6 * n_);
          f(6 * b - 6 + i) -= first_difference(
              [&](double h) {
                d(6 * b - 6 + i) = h;
                return Eigen::VectorXd::Constant(1, bushing_energy(force, moved(X, d)));
              },
              kFirst)(0);
        }
      const Vector3d at = marker(force.M, X).p;
      const auto turn = [&](int b) { return b == 0 ? none : Vector3d(motion[b].V.angular); };
      const Vector3d pull = -force.damping * (velocity(B, at) - velocity(A, at)),
                     twist = -force.turn_damping * (turn(B) - turn(A));
      put(B, at, pull, twist);
      put(A, at, -pull, -twist);
    } else if (force.type == "contact") {
      const Vector3d n = marker(force.F, X).R.col(2), at = marker(force.M, X).p - force.radius * n;
      const double push = contact_push(force, motion);
      put(scene_.markers[force.M].body, at, push * n, none);
      put(scene_.markers[force.F].body, at, -push * n, none);
    } else if (force.is_along_joint()) {
      const SceneJoint& joint = scene_.joints[force.joint];
      const NamedCoordinate& c = coordinates_of(joint.type)[force.coordinate];
      const int A = scene_.markers[joint.F].body, B = scene_.markers[joint.M].body;
      const Matrix3d R_WF = marker(joint.F, X).R;
      const double q = value(force.joint, force.coordinate, X), rate = speed(force.joint, force.coordinate, motion);
      const double size = force.type == "joint_spring_damper" ? -force.stiffness * (q - force.rest) - force.damping * rate
                          : force.type == "joint_friction"
                              ? -force.coulomb * std::tanh(rate / force.transition) - force.damping * rate
                          : force.type == "actuator" ? force.actuator_force(t)
                                                     : force.level[q > force.at ? 1 : 0];
      const Vector3d at = marker(joint.M, X).p;
      if (c.is_angle()) {
        put(B, at, none, size * R_WF.col(2));
        put(A, at, none, -size * R_WF.col(2));
      } else {
        const Vector3d along = R_WF.col(c.what == Coordinate::slide_x ? 0 : c.what == Coordinate::slide_y ? 1 : 2);
        put(B, at, size * along, none);
        put(A, at, -size * along, none);
      }
    } else {
      const Vector3d value(force.law[0].value(t), force.law[1].value(t), force.law[2].value(t));
      const bool turns = force.type == "torque";
      put(scene_.markers[force.M].body, marker(force.M, X).p, turns ? none : value, turns ? value : none);
    }
  }
  return f;
}

double ScenePhysics::bushing_energy(const SceneForce& force, const std::vector<Pose>& X) const {
  const Pose X_FM = marker(force.F, X).inverse() * marker(force.M, X);
  return 0.5 * force.stiffness * X_FM.p.squaredNorm() +
         0.5 * force.turn_stiffness * rotation_log(X_FM.R).squaredNorm();
}

double ScenePhysics::gap(const SceneForce& force, const std::vector<Pose>& X) const {
  return (marker(force.F, X).inverse() * marker(force.M, X)).p.z() - force.radius;
}

double ScenePhysics::contact_push(const SceneForce& force, const std::vector<BodyMotion>& motion) const {
  const std::vector<Pose> X = poses_of(motion);
  const double deep = -gap(force, X);
  if (deep <= 0.0) return 0.0;
  const Eigen::VectorXd v = velocities_of(motion);
  const double rate = -first_difference(
      [&](double h) { return Eigen::VectorXd::Constant(1, gap(force, moved(X, h * v))); }, kFirst * calm(v, size_))(0);
  return std::max(0.0, force.stiffness * std::pow(deep, force.exponent) + force.damping * rate);
}

bool ScenePhysics::stands_at_switch(const std::vector<BodyMotion>& motion, double t) const {
  constexpr double kNear = 1e-5;
  const std::vector<Pose> X = poses_of(motion);
  // A spline's third derivative jumps at its knots, over which differences look.
  const bool at_knot = std::ranges::any_of(scene_.constraints, [&](const SceneConstraint& c) {
    if (c.type != "point_on_curve") return false;
    const SceneCurve curve(c.points);
    const double s = curve.foot((marker(c.F, X).inverse() * marker(c.M, X)).p);
    return std::ranges::any_of(curve.knots(), [&](double knot) { return std::abs(s - knot) < 0.02 * size_; });
  });
  return at_knot || std::ranges::any_of(scene_.forces, [&](const SceneForce& force) {
    return (force.type == "contact" && std::abs(gap(force, X)) < kNear * size_) ||
           (force.type == "joint_force" && std::abs(value(force.joint, force.coordinate, X) - force.at) < kNear) ||
           (force.type == "actuator" && std::abs(t - force.at) < kNear);
  });
}

ScenePhysics::Gauss ScenePhysics::accelerations(const std::vector<BodyMotion>& motion, double t) const {
  const std::vector<Pose> X = poses_of(motion);
  const Eigen::MatrixXd D = inverse_root_mass(X);  // M^-1/2
  const Eigen::VectorXd free = D * (D * forces(motion, t));
  Gauss out{free, 0.0, {}};
  if (n_rows() == 0) return out;
  const Eigen::VectorXd scale = row_scale();
  const Eigen::MatrixXd G = scale.asDiagonal() * jacobian(X, t);
  const Eigen::VectorXd gamma_now = scale.cwiseProduct(gamma(motion, t));
  Eigen::VectorXd wanted = -gamma_now - G * free;
  Eigen::MatrixXd GD = G * D;
  const Eigen::VectorXd before = wanted;
  normalise(GD, wanted);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(GD, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& sigma = svd.singularValues();
  out.rank = rank_of(sigma);
  Eigen::VectorXd y = svd.matrixU().transpose() * wanted;
  for (Eigen::Index i = 0; i < sigma.size(); ++i) y(i) = i < out.rank.rank ? y(i) / sigma(i) : 0.0;
  const Eigen::VectorXd step = svd.matrixV() * y;
  out.a += D * step;
  out.contradiction = (GD * step - wanted).cwiseAbs().maxCoeff();
  return out;
}

double ScenePhysics::kinetic(const std::vector<BodyMotion>& motion) const {
  double T = 0.0;
  for (int b = 1; b <= n_; ++b) {
    const Spatial& V = motion[b].V;
    T += 0.5 * scene_.bodies[b].mass * V.linear.squaredNorm() +
         0.5 * V.angular.dot(inertia(b, motion[b].X_WB) * V.angular);
  }
  return T;
}

double ScenePhysics::potential(const std::vector<BodyMotion>& motion) const {
  const std::vector<Pose> X = poses_of(motion);
  double U = 0.0;
  for (int b = 1; b <= n_; ++b)
    U -= scene_.bodies[b].mass * scene_.gravity.dot(X[b] * scene_.bodies[b].center);
  for (const SceneForce& force : scene_.forces) {
    double stretch = 0.0;
    if (force.type == "bushing") U += bushing_energy(force, X);
    if (force.type == "contact")
      // A surface that is left faster than it comes back keeps nothing.
      if (contact_push(force, motion) > 0.0)
        U += force.stiffness / (force.exponent + 1.0) * std::pow(-gap(force, X), force.exponent + 1.0);
    if (force.type == "spring_damper")
      stretch = (marker(force.M, X).p - marker(force.F, X).p).norm() - force.rest;
    else if (force.type == "joint_spring_damper")
      stretch = value(force.joint, force.coordinate, X) - force.rest;
    U += 0.5 * force.stiffness * stretch * stretch;
  }
  return U;
}

Vector3d ScenePhysics::momentum(const std::vector<BodyMotion>& motion) const {
  Vector3d p = Vector3d::Zero();
  for (int b = 1; b <= n_; ++b) p += scene_.bodies[b].mass * motion[b].V.linear;
  return p;
}
Vector3d ScenePhysics::angular_momentum(const std::vector<BodyMotion>& motion) const {
  Vector3d L = Vector3d::Zero();
  for (int b = 1; b <= n_; ++b)
    L += (motion[b].X_WB * scene_.bodies[b].center).cross(scene_.bodies[b].mass * motion[b].V.linear) +
         inertia(b, motion[b].X_WB) * motion[b].V.angular;
  return L;
}
double ScenePhysics::mass() const {
  double m = 0.0;
  for (int b = 1; b <= n_; ++b) m += scene_.bodies[b].mass;
  return m;
}
Vector3d ScenePhysics::centre(const std::vector<BodyMotion>& motion) const {
  Vector3d c = Vector3d::Zero();
  for (int b = 1; b <= n_; ++b) c += scene_.bodies[b].mass * (motion[b].X_WB * scene_.bodies[b].center);
  return c / mass();
}

double ScenePhysics::close(std::vector<Pose>& X, double t) const {
  const Eigen::VectorXd scale = row_scale();
  double left = 0.0;
  for (int pass = 0; pass < 12; ++pass) {
    const Eigen::VectorXd g = scale.cwiseProduct(rows(X, t));
    left = g.size() > 0 ? g.cwiseAbs().maxCoeff() : 0.0;
    if (left < 1e-13) break;
    const Eigen::MatrixXd D = inverse_root_mass(X);
    const Eigen::MatrixXd G = scale.asDiagonal() * jacobian(X, t) * D;
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(G, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(kRankLost);
    X = moved(X, D * svd.solve(-g));
  }
  return left;
}

ScenePhysics::Nature ScenePhysics::nature(std::string* why) const {
  const auto say = [&](std::string text, Nature nature) {
    if (why) *why = std::move(text);
    return nature;
  };
  std::vector<Pose> X = scene_.poses();
  if (n_rows() == 0) return say("no rows", Nature::moves);
  const double open = row_scale().cwiseProduct(rows(X, 0.0)).cwiseAbs().maxCoeff();
  if (open > 1e-6) {
    if (close(X, 0.0) > 1e-9) return say("its rows do not close", Nature::unclear);
  }
  const Rank here = rank(X, 0.0);
  if (!here.is_clear())
    return say(fmt::format("singular values {:.1e} and {:.1e}", here.smallest, here.next), Nature::unclear);
  // A little later, and a little elsewhere along a freedom.
  const double dt = 0.01;
  std::vector<Pose> later = X;
  const double left = close(later, dt);
  if (left > 1e-7) return say(fmt::format("rows are open by {:.1e} at {} s", left, dt), Nature::contradicts);
  if (rank(later, dt).rank != here.rank) return say("its rank changes at once", Nature::unclear);
  const Eigen::MatrixXd D = inverse_root_mass(X);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(row_scale().asDiagonal() * jacobian(X, 0.0) * D, Eigen::ComputeFullV);
  for (int i = here.rank; i < 6 * n_; ++i) {
    const Eigen::VectorXd along = D * svd.matrixV().col(i);
    std::vector<Pose> beside = moved(X, 0.03 / along.norm() * along);
    if (close(beside, 0.0) > 1e-10) return say("a freedom of the instant alone", Nature::unclear);
    if (rank(beside, 0.0).rank != here.rank) return say("its rank changes beside", Nature::unclear);
  }
  return say("", Nature::moves);
}

}  // namespace flexura::mbs::chance
