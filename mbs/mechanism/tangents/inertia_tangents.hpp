// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <vector>

#include "mbs/mechanism/dynamics/mass_matrix.hpp"

namespace flexura::mbs {

/// What InertiaTangents leaves of one state, all about one origin for each branch of the tree, in W: see
/// inertia_tangents.cpp.
struct InertiaVariations {
  using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;
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
    Columns6 eta, D, E, E_v;  ///< of a marker on a node, its body held: 6 x m
  };
  std::vector<BranchOfBody> bodies;
  std::vector<MovedNode> markers;
  std::vector<DeformationTangents> deformations;  ///< of flexible bodies
  Columns6 G_p, G_v;
  Columns6 phi, D, E, E_v;   ///< of every velocity coordinate
  Columns6 row_E, H_p, H_v;  ///< the same
  Eigen::Matrix3Xd row_w;
  MotionDerivatives joint;
};

/// Derivatives of the inverse dynamics: z_q by the tangent coordinates of p, z_v by v (n_v columns, the first n_v rows).
class InertiaTangents {
 public:
  explicit InertiaTangents(const Topology& tree) : tree_(tree) {}
  void size(InertiaVariations& variations) const;

  /// phi, D, E of every joint coordinate, of the motion that the last forward() left.
  void vary_joints(const Motion& motion, InertiaVariations& variations) const;
  /// F, I and B of each body with all that is outboard, and of every coordinate the rows of (2); after vary_joints(),
  /// MassMatrix::own_inertia() and a backward() without the loads that are differenced.
  void vary_inertia(const Motion& motion, Wrenches& wrenches, const Inertias& inertias,
                    InertiaVariations& variations) const;
  /// All but the modal blocks of bodies themselves (mode_tangents.hpp), which come before; the elastic coordinates' columns where `with_modes`.
  void joint_columns(bool with_modes, const InertiaVariations& variations, Eigen::MatrixXd& z_q,
                     Eigen::MatrixXd& z_v) const;

 private:
  const Topology& tree_;
};

}  // namespace flexura::mbs
