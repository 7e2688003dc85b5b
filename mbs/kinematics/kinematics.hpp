// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/base/math/spatial.hpp"
#include "mbs/bodies/body_load.hpp"
#include "mbs/joints/joint.hpp"

/// What joints' closures, constraints, forces and measures see of a mechanism at one state.
namespace flexura::mbs {

struct Jet;

/// A marker P in the world, all expressed in W: pose, (w_WP, v_WPo) and (alpha_WP, a_WPo).
struct MarkerState {
  Pose X_WP;
  Spatial V, A;
};

/// One frame M relative to another F, expressed in F: V = (w_FM_F, d/dt p_FoMo_F), A its derivative.
struct Relative {
  Pose X_FM;
  Vector6d V = Vector6d::Zero(), A = Vector6d::Zero();
};

/// A function y of the pose of M in F at one instant: y' = gradient . V, y'' = gradient . A + bias, the bias quadratic
/// in V.
struct PoseFunction {
  double value = 0.0;
  Vector6d gradient = Vector6d::Zero();
  double bias = 0.0;
};

/// Coordinate, speed or acceleration `index` of the joint `joint`.
struct CoordinateRef {
  int joint = -1;
  int index = 0;
};

/// Where a joint stands: in the tree (its coordinates are states) or closing a loop.
struct JointPlace {
  const Joint* joint = nullptr;
  int marker_F = -1, marker_M = -1;
  int i_p = -1, i_v = -1;  ///< first entries in p and v; -1 for a closure
  bool in_tree() const { return i_p >= 0; }
};

/// What loads that are spread over a body need of it.
struct BodyState {
  const std::vector<BodyLoad>* loads = nullptr;  ///< those of its superelement
  /// Modal coordinates and their rates (from level velocity on) of a body that deforms; null on a rigid body
  /// and on a one-way body, whose deformation its loads do not see.
  const double *s = nullptr, *s_dot = nullptr;
};

/// What one element has of its own at one state.
struct OwnStates {
  const double* c = nullptr;  ///< its dynamic states
  const double* a = nullptr;  ///< its algebraic states
  const int* root = nullptr;  ///< positions of its switches
  /// Of a constraint that sits on a curve: where its contact was last (NaN: unknown).  The constraint finds
  /// the contact from there and leaves it here; what it finds is a function of the positions alone.
  double* contact = nullptr;
  /// Of a constraint that follows signals: the value of its formula, from level velocity on with the first and on level
  /// acceleration with the second derivative by time.
  const Jet* followed = nullptr;
};

/// Positions are always set; V from level velocity on; A and v_dot on level acceleration only.
class Kinematics {
 public:
  double t = 0.0;
  const double* p = nullptr;
  const double* v = nullptr;
  const double* v_dot = nullptr;
  const double* c = nullptr;  ///< dynamic states of controls, where signals are evaluated
  OwnStates own;              ///< of the element that is being evaluated
  std::vector<MarkerState> markers;
  std::vector<BodyState> bodies;
  const std::vector<JointPlace>* joints = nullptr;

  const MarkerState& marker(int i) const { return markers[i]; }

  Pose relative_pose(int marker_F, int marker_M) const;
  /// Pose and twist.
  Relative relative_motion(int marker_F, int marker_M) const;
  /// Pose, twist and acceleration.
  Relative relative_acceleration(int marker_F, int marker_M) const;

  /// q_i, v_i, v_i' of a joint; of a closure from the relative motion of its frames (angles then within
  /// +-pi).
  double coordinate(CoordinateRef c) const;
  double speed(CoordinateRef c) const;
  double acceleration(CoordinateRef c) const;
};

/// Takes up what acts on bodies and coordinates.
class Loads {
 public:
  virtual ~Loads() = default;
  /// A wrench (torque, force at the marker's origin), expressed in W, on the marker's body.
  virtual void apply(int marker, const Spatial& wrench_W) = 0;
  /// A generalised force on a joint's speed; on a closure by the wrench between its frames that has this
  /// power.
  virtual void apply(CoordinateRef c, double force) = 0;
  /// factor * f on the modal coordinates of a body that deforms, one-way or both ways (m of them).
  virtual void apply_modal(int body, const Eigen::VectorXd& f, double factor) = 0;
  /// A wrench on marker M, about Mo, expressed in F, and its reaction on the body of F.
  void apply_between(const Kinematics& kin, int marker_F, int marker_M, const Vector6d& on_M_F);
};

}  // namespace flexura::mbs
