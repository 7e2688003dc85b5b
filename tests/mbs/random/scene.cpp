// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/scene.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include <Eigen/LU>

#include "mbs/base/math/rotation.hpp"

namespace flexura::mbs::chance {

double Law::value(double t) const { return a + b * t + c * std::sin(w * t + phi); }
double Law::rate(double t) const { return b + c * w * std::cos(w * t + phi); }
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
  const auto follow = [&](double from, double to, double dt) { return to + (from - to) * std::exp(-dt / time_constant); };
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
  Vector3d r = a * r_[i] + b * r_[i + 1] + h * h / 6.0 * ((a * a * a - a) * r_2_[i] + (b * b * b - b) * r_2_[i + 1]);
  if (in != s)
    r += (s - in) * ((r_[i + 1] - r_[i]) / h + h / 6.0 * ((1.0 - 3.0 * a * a) * r_2_[i] + (3.0 * b * b - 1.0) * r_2_[i + 1]));
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
    const Vector3d r_1 = (8.0 * (at(best + h) - at(best - h)) - (at(best + 2 * h) - at(best - 2 * h))) / (12.0 * h);
    const Vector3d r_2 = (at(best + h) - 2.0 * at(best) + at(best - h)) / (h * h), d = at(best) - p;
    best -= d.dot(r_1) / (r_1.squaredNorm() + d.dot(r_2));
  }
  return best;
}

std::vector<Pose> Scene::poses() const {
  std::vector<Pose> X;
  for (const SceneBody& body : bodies) X.push_back(body.X_WB);
  return X;
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

bool Scene::is_conservative() const {
  return std::ranges::none_of(joints, [](const SceneJoint& j) { return !j.drives.empty(); }) &&
         std::ranges::none_of(forces, [](const SceneForce& f) {
           return f.damping != 0.0 || f.turn_damping != 0.0 || f.type == "force" || f.type == "torque" ||
                  f.type == "joint_friction" || f.type == "actuator" || f.type == "joint_force";
         });
}

const std::vector<NamedCoordinate>& coordinates_of(const std::string& type) {
  using C = Coordinate;
  static const NamedCoordinate turn = {"angle", "speed", "drive", "drive_speed", "drive_acceleration", C::turn_z};
  static const NamedCoordinate slides[] = {
      {"x", "v_x", "drive_x", "drive_v_x", "drive_a_x", C::slide_x},
      {"y", "v_y", "drive_y", "drive_v_y", "drive_a_y", C::slide_y},
      {"z", "v_z", "drive_z", "drive_v_z", "drive_a_z", C::slide_z}};
  static const NamedCoordinate turn_beside = {"angle", "speed", "drive_angle", "drive_speed", "drive_acceleration",
                                              C::turn_z};
  const auto undriven = [](NamedCoordinate c) {
    c.can_be_driven = false;
    return c;
  };
  static const std::map<std::string, std::vector<NamedCoordinate>> lists = {
      {"revolute", {turn}},
      {"prismatic", {{"position", "speed", "drive", "drive_speed", "drive_acceleration", C::slide_z}}},
      {"screw", {{"angle", "speed", "drive", "drive_speed", "drive_acceleration", C::screw}}},
      {"cylindrical",
       {{"angle", "angular_speed", "drive_angle", "drive_angular_speed", "drive_angular_acceleration", C::turn_z},
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

namespace {

std::string list(const Vector3d& x, int digits) {
  return fmt::format("[{:.{}g}, {:.{}g}, {:.{}g}]", x.x(), digits, x.y(), digits, x.z(), digits);
}

class Writer {
 public:
  Writer(const Scene& scene, const Writing& how) : s_(scene), how_(how), X_(scene.poses()) {
    if (s_.start == Start::guess) X_ = s_.guess;
  }

  std::string text() {
    say("# {}\n", s_.what);
    say("gravity = {}\n", list(how_.length * s_.gravity, 17));
    say("[solver]\nend_time = {:.17g}\noutput_step = {:.17g}\n{}", s_.end_time, s_.output_step, how_.solver);
    for (const int b : order(s_.bodies.size(), how_.bodies_backwards)) write_body(b);
    for (const int j : order(s_.joints.size(), how_.joints_backwards)) write_joint(j);
    for (const int c : order(s_.constraints.size(), how_.bodies_backwards)) write_constraint(c);
    for (const int f : order(s_.forces.size(), how_.bodies_backwards)) write_force(f);
    return out_;
  }

 private:
  template <class... Args>
  void say(fmt::format_string<Args...> format, Args&&... args) {
    out_ += fmt::format(format, std::forward<Args>(args)...);
  }
  static std::vector<int> order(std::size_t n, bool backwards) {
    std::vector<int> list(n);
    std::iota(list.begin(), list.end(), 0);
    if (backwards) std::ranges::reverse(list);
    return list;
  }
  std::string body_name(int b) const { return b == 0 ? "ground" : fmt::format("b{}", b); }
  std::string marker_name(int m) const { return fmt::format("{}.m{}", body_name(s_.markers[m].body), m); }
  std::string coordinate_name(int joint, int coordinate) const {
    return fmt::format("j{}.{}", joint, coordinates_of(s_.joints[joint].type)[coordinate].name);
  }
  void write_pose(const Pose& X, int digits) {
    const Eigen::Vector4d q = quaternion_of_rotation(X.R);
    say("position = {}\n", list(how_.length * X.p, digits));
    if (!X.R.isIdentity(0.0))
      say("quaternion = [{:.{}g}, {:.{}g}, {:.{}g}, {:.{}g}]\n", q(0), digits, q(1), digits, q(2), digits, q(3),
          digits);
  }
  bool is_alone(int body) const {
    return std::ranges::none_of(s_.joints, [&](const SceneJoint& j) {
      return s_.markers[j.F].body == body || s_.markers[j.M].body == body;
    });
  }

  void write_body(int b) {
    const std::string table = b == 0 ? "ground" : "body.b" + std::to_string(b);
    say("[{}]\n", table);
    if (b > 0) {
      const SceneBody& body = s_.bodies[b];
      const double J = how_.mass * how_.length * how_.length;
      const Matrix3d& I = body.inertia;
      say("mass = {:.17g}\ncenter = {}\n", how_.mass * body.mass, list(how_.length * body.center, 17));
      say("inertia = [{:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}, {:.17g}]\n", J * I(0, 0), J * I(1, 1), J * I(2, 2),
          J * I(0, 1), J * I(1, 2), J * I(2, 0));
      if (is_alone(b) || s_.start == Start::poses || s_.start == Start::guess) write_pose(X_[b], 17);
      if (is_alone(b))
        say("velocity = {}\nangular_velocity = {}\n", list(how_.length * body.velocity, 17),
            list(body.angular_velocity, 17));
    }
    for (const int m : order(s_.markers.size(), how_.bodies_backwards))
      if (s_.markers[m].body == b) {
        say("[{}.marker.m{}]\n", table, m);
        write_pose(s_.markers[m].X_BP, 17);
      }
  }

  void write_joint(int j) {
    const SceneJoint& joint = s_.joints[j];
    say("[{}.j{}]\ntype = \"{}\"\nfrom = \"{}\"\nto = \"{}\"\n", joint.is_connection ? "connection" : "joint", j,
        joint.type, marker_name(joint.F), marker_name(joint.M));
    if (joint.type == "screw") say("pitch = {:.17g}\n", how_.length * joint.pitch);
    if (joint.cut) say("cut = true\n");
    const Pose X = s_.marker(joint.F, X_).inverse() * s_.marker(joint.M, X_);
    const auto& coordinates = coordinates_of(joint.type);
    const bool given = s_.start == Start::joints && !joint.closes;
    const bool turns = joint.type == "spherical" || joint.type == "free" || joint.type == "point_on_line" ||
                       joint.type == "point_on_plane";
    if (given && turns) {
      const Eigen::Vector4d q = quaternion_of_rotation(X.R);
      say("qw = {:.17g}\nqx = {:.17g}\nqy = {:.17g}\nqz = {:.17g}\n", q(0), q(1), q(2), q(3));
    }
    if (given && joint.type == "free") {
      const char* names[] = {"x", "y", "z"};
      for (int i = 0; i < 3; ++i) say("{} = {:.17g}\n", names[i], how_.length * X.p(i));
    }
    if (joint.type == "free") {
      const SceneBody& body = s_.bodies[s_.markers[joint.M].body];
      for (int i = 0; i < 3 && !body.velocity.isZero(0.0); ++i)
        say("omega_{0} = {1:.17g}\nv_{0} = {2:.17g}\n", "xyz"[i], body.angular_velocity(i),
            how_.length * body.velocity(i));
    }
    if (given && joint.type == "constant_velocity") {
      const Vector3d bend = rotation_log(X.R);
      say("bend_x = {:.17g}\nbend_y = {:.17g}\n", bend.x(), bend.y());
    }
    for (int i = 0; i < static_cast<int>(coordinates.size()); ++i) {
      const auto drive = std::ranges::find_if(joint.drives, [&](const SceneDrive& d) { return d.coordinate == i; });
      const bool is_driven = drive != joint.drives.end();
      const double size = coordinates[i].is_angle() ? 1.0 : how_.length;
      if (is_driven) {
        const NamedCoordinate& c = coordinates[i];
        const std::string& key = drive->derivative == 0   ? c.drive
                                 : drive->derivative == 1 ? c.drive_speed
                                                          : c.drive_acceleration;
        say("{} = \"{}\"\n", key, drive->law.text(drive->derivative, size));
        if (drive->derivative >= 1) say("{} = {:.17g}\n", c.name, size * drive->law.value(0.0));
        if (drive->derivative == 2) say("{} = {:.17g}\n", c.speed, size * drive->law.rate(0.0));
      } else if (given) {
        say("{} = {:.17g}\n", coordinates[i].name, size * coordinate_value(joint, coordinates[i], X));
      }
    }
    for (const auto& [i, speed] : joint.speeds)
      say("{} = {:.17g}\n", coordinates[i].speed, (coordinates[i].is_angle() ? 1.0 : how_.length) * speed);
  }

  void write_constraint(int c) {
    const SceneConstraint& constraint = s_.constraints[c];
    say("[constraint.c{}]\ntype = \"{}\"\n", c, constraint.type);
    const auto& terms = constraint.terms;
    if (constraint.type == "gear") {
      say("joint_1 = \"{}\"\njoint_2 = \"{}\"\nteeth_1 = {:.17g}\nteeth_2 = {:.17g}\n",
          coordinate_name(terms[0].joint, terms[0].coordinate), coordinate_name(terms[1].joint, terms[1].coordinate),
          constraint.teeth_1, constraint.teeth_2);
      if (constraint.internal) say("internal = true\n");
      say("offset = {:.17g}\n", constraint.offset);
    } else if (constraint.type == "rack_and_pinion") {
      say("rack = \"{}\"\npinion = \"{}\"\nradius = {:.17g}\noffset = {:.17g}\n",
          coordinate_name(terms[0].joint, terms[0].coordinate), coordinate_name(terms[1].joint, terms[1].coordinate),
          how_.length * constraint.length, how_.length * constraint.offset);
    } else if (constraint.type == "coupler") {
      std::string joints, factors;
      for (const auto& term : terms) {
        joints += fmt::format("{}\"{}\"", joints.empty() ? "" : ", ", coordinate_name(term.joint, term.coordinate));
        factors += fmt::format("{}{:.17g}", factors.empty() ? "" : ", ", term.factor);
      }
      say("joints = [{}]\nfactors = [{}]\noffset = {:.17g}\n", joints, factors, constraint.offset);
    } else {
      say("from = \"{}\"\nto = \"{}\"\n", marker_name(constraint.F), marker_name(constraint.M));
      if (constraint.type == "rolling_disc") say("radius = {:.17g}\n", how_.length * constraint.length);
      if (constraint.type == "point_on_curve") {
        std::string points;
        for (const Vector3d& p : constraint.points)
          points += fmt::format("{}{}", points.empty() ? "" : ", ", list(how_.length * p, 17));
        say("points = [{}]\n", points);
      }
      if (constraint.type == "distance") say("length = {:.17g}\n", how_.length * constraint.length);
    }
  }

  void write_force(int f) {
    const SceneForce& force = s_.forces[f];
    const double N = how_.mass * how_.length, Nm = N * how_.length;
    say("[force.f{}]\ntype = \"{}\"\n", f, force.type);
    if (force.type == "spring_damper") {
      say("from = \"{}\"\nto = \"{}\"\nstiffness = {:.17g}\ndamping = {:.17g}\nfree_length = {:.17g}\n",
          marker_name(force.F), marker_name(force.M), how_.mass * force.stiffness, how_.mass * force.damping,
          how_.length * force.rest);
    } else if (force.type == "bushing") {
      const auto three = [](double x) { return fmt::format("[{0:.17g}, {0:.17g}, {0:.17g}]", x); };
      say("from = \"{}\"\nto = \"{}\"\nstiffness = {}\ndamping = {}\n", marker_name(force.F), marker_name(force.M),
          three(how_.mass * force.stiffness), three(how_.mass * force.damping));
      say("rotational_stiffness = {}\nrotational_damping = {}\n", three(Nm * force.turn_stiffness),
          three(Nm * force.turn_damping));
    } else if (force.type == "contact") {
      say("from = \"{}\"\nto = \"{}\"\nradius = {:.17g}\nstiffness = {:.17g}\nexponent = {:.17g}\ndamping = {:.17g}\n",
          marker_name(force.F), marker_name(force.M), how_.length * force.radius,
          force.stiffness * N / std::pow(how_.length, force.exponent), force.exponent, how_.mass * force.damping);
    } else if (force.is_along_joint() && force.type != "joint_spring_damper") {
      const NamedCoordinate& c = coordinates_of(s_.joints[force.joint].type)[force.coordinate];
      const double unit = c.is_angle() ? 1.0 : how_.length, size = N * how_.length / unit;
      say("joint = \"j{}\"\n", force.joint);
      if (coordinates_of(s_.joints[force.joint].type).size() > 1) say("coordinate = \"{}\"\n", c.name);
      if (force.type == "joint_friction")
        say("coulomb = {:.17g}\nviscous = {:.17g}\ntransition_speed = {:.17g}\n", size * force.coulomb,
            size / unit * force.damping, unit * force.transition);
      else if (force.type == "actuator")
        say("command = \"t > {:.17g} ? {:.17g} : {:.17g}\"\ntime_constant = {:.17g}\nstart = {:.17g}\n", force.at,
            size * force.level[1], size * force.level[0], force.time_constant, size * force.start);
      else
        say("value = \"{} > {:.17g} ? {:.17g} : {:.17g}\"\n", coordinate_name(force.joint, force.coordinate),
            unit * force.at, size * force.level[1], size * force.level[0]);
    } else if (force.type == "joint_spring_damper") {
      const NamedCoordinate& c = coordinates_of(s_.joints[force.joint].type)[force.coordinate];
      const double k = how_.mass * (c.is_angle() ? how_.length * how_.length : 1.0);
      say("joint = \"j{}\"\n", force.joint);
      if (coordinates_of(s_.joints[force.joint].type).size() > 1) say("coordinate = \"{}\"\n", c.name);
      say("stiffness = {:.17g}\ndamping = {:.17g}\nrest = {:.17g}\n", k * force.stiffness, k * force.damping,
          (c.is_angle() ? 1.0 : how_.length) * force.rest);
    } else {
      const char* axes[] = {"x", "y", "z"};
      say("marker = \"{}\"\n", marker_name(force.M));
      for (int i = 0; i < 3; ++i)
        say("{} = \"{}\"\n", axes[i], force.law[i].text(0, force.type == "torque" ? Nm : N));
    }
  }

  const Scene& s_;
  const Writing& how_;
  std::vector<Pose> X_;
  std::string out_;
};

}  // namespace

std::string to_toml(const Scene& scene, const Writing& writing) { return Writer(scene, writing).text(); }

}  // namespace flexura::mbs::chance
