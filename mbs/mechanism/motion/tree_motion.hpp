// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/kinematics/kinematics.hpp"
#include "mbs/mechanism/topology/topology.hpp"

/// The sweep outwards: poses, twists and accelerations of all bodies and markers, where a joint may sit on markers that
/// move with the deformation of either body.  Every body's twist is (w_WB, v_WBo) expressed in W.
namespace flexura::mbs {

/// [1 0; -[r]x 1]: takes the twist of a point to the point that lies r further on the same body.
inline Matrix6d transport_twist(const Vector3d& r) {
  Matrix6d X = Matrix6d::Identity();
  X.bottomLeftCorner<3, 3>() = -skew(r);
  return X;
}

/// What TreeMotion leaves of one state.
struct Motion {
  struct Body {
    Pose X_WB;
    Spatial V, A;  ///< twist and acceleration of B, in W
    // The tree joint, from the parent's marker frame (in) to this body's (out), expressed in the former.
    Pose X_in_out;
    MotionMatrix S;
    Vector6d bias = Vector6d::Zero();
  };
  /// A marker relative to its body and expressed there.
  struct LocalMarker {
    Pose X_BP;
    NodeMotion node;  ///< of the marker: its node's, taken to the marker's origin; no map on rigid bodies
  };
  Kinematics kin;
  std::vector<Body> bodies;
  std::vector<LocalMarker> local;  ///< of every marker
};

class TreeMotion {
 public:
  enum class Level { position, velocity, acceleration };

  explicit TreeMotion(const Topology& tree) : tree_(tree) {}
  void size(Motion& motion) const;

  /// To `level`, from p (n_p), v and v_dot (n_v); null beyond the level.  Keeps the pointers.
  void forward(Level level, double t, const double* p, const double* v, const double* v_dot,
               Motion& motion) const;
  /// After forward() on level velocity, with kin.c: the markers on deformations that do not act back where these take
  /// them.
  void show_following(Motion& motion) const;
  /// The box around all markers and centres of mass: corner to corner, at least a micrometre [m].
  double extent(const Motion& motion) const;

 private:
  void move_through_joint(int body, Level level, Motion& motion) const;
  void place_markers(int body, Level level, Motion& motion) const;
  void place_on_node(int marker, const double* s, const double* s_dot, const double* s_ddot,
                     Motion& motion) const;

  const Topology& tree_;
};

}  // namespace flexura::mbs
