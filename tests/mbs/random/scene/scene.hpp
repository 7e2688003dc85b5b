// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "tests/mbs/random/flexible_part.hpp"

/// A mechanism as the tests of random mechanisms know it: what is written into the file, and what scene_physics.hpp
/// judges runs by without the code under test.
namespace flexura::mbs::chance {

/// a + b t + c sin(w t + phi), in SI.
struct Law {
  double a = 0.0, b = 0.0, c = 0.0, w = 1.0, phi = 0.0;
  double value(double t) const;
  double rate(double t) const;
  /// The law or its first or second derivative, as a formula of the file, times `factor`.
  std::string text(int derivative, double factor) const;
};

struct SceneMarker {
  int body = 0;       ///< 0 is ground
  Pose X_BP;          ///< in the undeformed body
  int interface = 0;  ///< of a flexible body, carries the marker
};

/// A beam along x of its body, of a square section of one material.
struct SceneBeam {
  std::string fidelity;  ///< "ancf" or "segments"
  int elements = 2;
  double length = 0.3, mass = 0.2, side = 0.02;  ///< [m], [kg], [m]
  double bending = 1.0;                          ///< E I [N m^2]
  double damping_time = 0.0;                     ///< [s]
};

struct SceneBody {
  double mass = 1.0;
  Vector3d center = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Identity();  ///< about the centre of mass, in the body's axes
  Pose X_WB;                                ///< where it starts
  Vector3d velocity = Vector3d::Zero(), angular_velocity = Vector3d::Zero();  ///< of a body without a joint
  /// Of a flexible body, in place of mass, centre and inertia; modes of it that are kept, the lowest.
  std::shared_ptr<const FlexiblePart> part = {};
  int modes = 0;
  double damping = 0.0;                ///< ratio of each mode
  std::optional<SceneBeam> beam = {};  ///< beside its part, which knows of its ends alone
  int n_dofs() const { return 6 + modes; }
};

/// Where a body stands, and how it is deformed.
struct Place {
  Pose X_WB;
  Eigen::VectorXd q = {};  ///< modal coordinates
};
using Places = std::vector<Place>;

/// Of a joint, with how it is taken from X_FM.
enum class Coordinate { turn_z, slide_x, slide_y, slide_z, screw, universal_1, universal_2 };
struct NamedCoordinate {
  std::string name, speed, drive, drive_speed, drive_acceleration;
  Coordinate what;
  bool can_be_driven = true;
  bool is_angle() const { return what == Coordinate::turn_z || what >= Coordinate::screw; }
};

struct SceneDrive {
  int coordinate = 0;  ///< index among coordinates_of(type)
  Law law;
  int derivative = 0;  ///< 0: prescribes the position, 1: the speed, 2: the acceleration
};

struct SceneJoint {
  std::string type;
  int F = 0, M = 0;
  double pitch = 0.0;  ///< of a screw
  bool is_connection = false;
  bool closes = false;                         ///< a loop, as the scene was made
  bool cut = false;                            ///< the file says so
  std::vector<std::pair<int, double>> speeds;  ///< initial ones, by coordinate
  std::vector<SceneDrive> drives;
};

struct SceneConstraint {
  std::string type;
  int F = 0, M = 0;
  double length = 0.0;  ///< of a distance; radius of a rack and pinion or of a disc
  /// Of couplers: joint, coordinate, factor.
  struct Term {
    int joint, coordinate;
    double factor;
  };
  std::vector<Term> terms;
  double teeth_1 = 1.0, teeth_2 = 1.0;
  bool internal = false;
  double offset = 0.0;
  std::vector<Vector3d> points;  ///< of a curve
};

/// The natural cubic spline through points over the sum of their chords (C. de Boor, A Practical Guide to Splines), straight
/// on beyond its ends.
class SceneCurve {
 public:
  explicit SceneCurve(const std::vector<Vector3d>& points);
  Vector3d at(double s) const;
  double foot(const Vector3d& p) const;  ///< s of the nearest point
  const std::vector<double>& knots() const { return s_; }

 private:
  std::vector<Vector3d> r_, r_2_;  // values and second derivatives at the knots
  std::vector<double> s_;
};

struct SceneForce {
  std::string
      type;  ///< spring_damper, joint_spring_damper, force, torque, bushing, joint_friction, actuator, ...
  int F = 0, M = 0;
  int joint = 0, coordinate = 0;
  double stiffness = 0.0, damping = 0.0, rest = 0.0;
  Law law[3];
  double turn_stiffness = 0.0, turn_damping = 0.0;  ///< of a bushing
  double coulomb = 0.0, transition = 0.0;           ///< of friction along a joint
  double exponent = 1.0, radius = 0.0;              ///< of a contact
  /// Of actuators (by time) and forces along a joint (by its coordinate): level[1] beyond `at`, else level[0].
  double at = 0.0, level[2] = {0.0, 0.0}, time_constant = 0.0, start = 0.0;
  bool is_along_joint() const {
    return type == "joint_spring_damper" || type == "joint_friction" || type == "actuator" ||
           type == "joint_force";
  }
  bool is_between_markers() const {
    return type == "spring_damper" || type == "bushing" || type == "contact";
  }
  double actuator_force(double t) const;
};

/// How the file says where the mechanism starts.
enum class Start {
  joints,  ///< by the coordinates of the joints of the tree
  poses,   ///< by the poses of the bodies
  guess    ///< by poses that are a little off
};

struct Scene {
  std::string what;  ///< for whoever reads a failure
  Vector3d gravity = Vector3d::Zero();
  std::vector<SceneBody> bodies;  ///< [0] is ground
  std::vector<SceneMarker> markers;
  std::vector<SceneJoint> joints;
  std::vector<SceneConstraint> constraints;
  std::vector<SceneForce> forces;
  Start start = Start::joints;
  std::vector<Pose> guess;     ///< poses of the bodies for Start::guess
  int digits = 17;             ///< that markers were rounded to
  bool order_matters = false;  ///< another order of the bodies is another mechanism
  double end_time = 0.3, output_step = 0.01;

  Pose marker(int i, const Places& places) const;
  Places places() const;  ///< at the start, undeformed
  int add_marker(int body, const Pose& X_BP);
  bool has_loops() const;
  bool is_grounded() const;  ///< something other than gravity acts from ground
  bool is_flexible() const;
  bool has_beams() const;  ///< bodies of which no equations are known here
  bool is_conservative() const;
};

/// Names and meanings of a joint type's coordinates that can be driven and coupled; none for those of three
/// rotations.
const std::vector<NamedCoordinate>& coordinates_of(const std::string& joint_type);
/// Position of joint types whose coordinates are given at the start: "angle = 0.3\n"...
double coordinate_value(const SceneJoint& joint, const NamedCoordinate& coordinate, const Pose& X_FM);

/// The same mechanism in another file: units of length and mass (what was 1 m is written as `length`), bodies and
/// elements in another order.
struct Writing {
  double length = 1.0, mass = 1.0;
  bool bodies_backwards = false, joints_backwards = false;
  std::string solver;  ///< lines of [solver] beside the times
  std::string suffix;  ///< of the file's name
};
/// The files of flexible bodies are written into the folder.
std::string to_toml(const Scene& scene, const std::filesystem::path& folder, const Writing& writing = {});

}  // namespace flexura::mbs::chance
