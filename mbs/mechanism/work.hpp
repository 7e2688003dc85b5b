// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

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
    std::unique_ptr<FlexibleBody::Scratch> flexible;
    Eigen::VectorXd no_acceleration;  ///< of a deformation that does not act back

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
    Spatial load;       ///< all applied to it, about its origin, in W
    NodeMotion motion;  ///< of the marker: its node's, taken to the marker's origin; no map on rigid bodies
  };

  /// What inertia_tangents.cpp keeps, all about one origin for each branch of the tree, in W: see there.
  struct BranchOfBody {
    int depth = 0;
    Vector3d origin = Vector3d::Zero();
    Spatial F;                                         ///< on this body and all outboard
    Matrix6d I = Matrix6d::Zero();                     ///< of them
    Eigen::Matrix<double, 6, 3> B;                     ///< of them
    Eigen::Matrix<double, Eigen::Dynamic, 3> modal_w;  ///< scratch of the body's own
    std::array<std::array<Spatial, 6>, 6> own_turns;   ///< [j][i]: d phi_i / dq_j within one joint
  };
  /// Of a flexible body's own coordinates.
  struct MovedNode {
    Eigen::Matrix<double, 6, Eigen::Dynamic> eta, D, E, E_v;  ///< of a marker on a node, its body held: 6 x m
  };
  using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  struct Tangent {
    std::vector<BranchOfBody> bodies;
    std::vector<MovedNode> markers;
    std::vector<DeformationTangents> deformations;  ///< of flexible bodies
    Columns6 G_p, G_v;
    Columns6 phi, D, E, E_v;   ///< of every velocity coordinate
    Columns6 row_E, H_p, H_v;  ///< the same
    Eigen::Matrix3Xd row_w;
    Eigen::MatrixXd z_q, h_q;  ///< by the tangent coordinates of p
    MotionDerivatives joint;
    std::vector<bool> is_elastic;
    std::vector<int> kept;  ///< of all constraint rows, -1 for redundant ones
    State moved;
    Eigen::VectorXd z, z_plus, h, h_plus, step;
  };

  /// How a marker moves with the coordinates that it depends on: twists of a point of its body (or node),
  /// and D of (1) in inertia_tangents.cpp about that point; zero for all others.
  struct Reach {
    Columns6 twist, D;
    Columns6 rigid;         ///< twists without what the marker moves in its own body
    std::vector<int> list;  ///< from the body inwards
    std::size_t n_own = 0;  ///< those that not all markers of a load have in common come first
  };
  struct ElementTangent {
    Reach at, axes, reaction, seen_F, seen_M;
    std::pair<int, int> seen;  ///< markers of seen_F and seen_M
    std::vector<int> columns, seen_columns;
    std::vector<long> mark;
    long marks = 0;
    Eigen::Matrix<double, 12, Eigen::Dynamic> motion;  ///< of seen_M in seen_F, pose and twist by q
    // What the element does: rows of the target and their derivatives by its numbers (6 at most).
    std::vector<int> rows;
    Columns6 by_row;
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> signals;  ///< by (q, v, c, a)
  };

  Kinematics kin;
  Tangent tangent;
  ElementTangent element;
  std::vector<Body> bodies;
  std::vector<Articulated> articulated;
  std::vector<LocalMarker> local;  ///< of every marker; map is empty on rigid bodies
  Eigen::VectorXd r;  ///< n_v forces along the velocity coordinates, then those of deformations that do not act back
  /// What force elements put on the coordinate of a joint that closes a loop, on M about Mo in F: kept for
  /// each joint by evaluate(), empty elsewhere.
  std::vector<Vector6d> on_closure;
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
  void apply_modal(int body, const Eigen::VectorXd& f, double factor) override;

 private:
  const Mechanism& mechanism_;
  Work& work_;
  double factor_;
};

}  // namespace flexura::mbs
