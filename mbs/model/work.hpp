// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/model/mechanism.hpp"

/// Private to the sources of Mechanism: its scratch.
namespace flexura::mbs {

/// [1 0; -[r]x 1]: takes the twist of a point to the point that lies r further on the same body.
inline Matrix6d transport_twist(const Vector3d& r) {
  Matrix6d X = Matrix6d::Identity();
  X.bottomLeftCorner<3, 3>() = -skew(r);
  return X;
}

struct Mechanism::Work final : public Equations::Scratch {
  struct Body {
    Pose X_WB;
    Spatial V, A;  ///< twist and acceleration of B, in W
    Spatial F;     ///< wrench on the body about Bo that its motion needs, in W, less what is applied
    FlexibleBody::Work flexible;
    Eigen::VectorXd no_acceleration;
    Eigen::VectorXd one_way;  ///< m modal forces that a one-way body's motion needs, less what is applied

    // The tree joint, from the parent's marker frame (in) to this body's (out), expressed in the former.
    Pose X_in_out;
    MotionMatrix S;
    Vector6d bias = Vector6d::Zero();
    Spatial through_joint;  ///< wrench on this body about the outer marker's origin, in W

    // The composite body: this one and all outboard of it with joints and modes at rest, in W about Bo.
    Matrix6d I_c = Matrix6d::Zero();
    Eigen::Matrix<double, 6, Eigen::Dynamic> C_c;  ///< 6 x m: wrench for unit s''
    Eigen::MatrixXd M_c;                           ///< m x m
  };
  /// What articulated.cpp keeps of a body: see there.
  struct Articulated {
    Vector3d r = Vector3d::Zero();                     ///< from the parent's origin to this one
    Eigen::Matrix<double, 6, Eigen::Dynamic> K, U, N;  ///< 6 x n_b, 6 x n_b, 6 x m of the parent
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
        L;  ///< Cholesky factor of D, n_b x n_b
    Vector6d p = Vector6d::Zero(), V = Vector6d::Zero();
    Eigen::VectorXd q;  ///< m
  };
  /// A marker on a node of a flexible body, relative to its body and expressed there.
  struct LocalMarker {
    Pose X_BP;
    NodeMotion motion;  ///< of the marker: its node's, taken to the marker's origin; no map on rigid bodies
  };

  Kinematics kin;
  std::vector<Body> bodies;
  std::vector<Articulated> articulated;
  std::vector<LocalMarker> local;  ///< of every marker; map is empty on rigid bodies
  Eigen::VectorXd r;               ///< n_v: forces along the velocity coordinates
  Eigen::VectorXd rows_x, rows_g;  ///< one entry for each constraint row, redundant ones included
  Eigen::VectorXd signals;
  Eigen::VectorXd zero_v;
  std::vector<int> switches;  ///< positions of all of them
  Eigen::VectorXd algebraic;
  Eigen::VectorXd inputs;        ///< what is added to them
  std::vector<double> contacts;  ///< of each constraint, where it has one: see OwnStates::contact
  // Columns of the mass matrix under way to the root: twists of a body for unit velocities of its own
  // coordinates, the wrench they need and the modal forces.
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> K;
  Eigen::Matrix<double, 6, Eigen::Dynamic> H;
};

/// Takes loads into the scratch, times `factor`.
class Mechanism::BodyLoads final : public Loads {
 public:
  BodyLoads(const Mechanism& mechanism, Work& work, double factor)
      : mechanism_(mechanism), work_(work), factor_(factor) {}
  using Loads::apply;
  void apply(int marker, const Spatial& wrench_W) override;
  void apply(CoordinateRef c, double force) override;

 private:
  const Mechanism& mechanism_;
  Work& work_;
  double factor_;
};

}  // namespace flexura::mbs
