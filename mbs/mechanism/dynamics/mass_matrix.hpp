// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/mechanism/dynamics/inverse_dynamics.hpp"
#include "mbs/mechanism/topology/coordinates.hpp"

namespace flexura::mbs {

/// What MassMatrix leaves of one configuration.
struct Inertias {
  using Columns6 = Eigen::Matrix<double, 6, Eigen::Dynamic>;
  /// The composite body: this one and all outboard of it with joints and modes at rest, in W about Bo.
  struct Body {
    Matrix6d I_c = Matrix6d::Zero();
    Columns6 C_c;         ///< 6 x m: wrench for unit s''
    Eigen::MatrixXd M_c;  ///< m x m
  };
  /// What articulated.cpp keeps of a body: see there.
  struct Articulated {
    Vector3d r = Vector3d::Zero();  ///< from the parent's origin to this one
    Columns6 K, U, N;               ///< 6 x n_b, 6 x n_b, 6 x m of the parent
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
        L;  ///< Cholesky factor of D, n_b x n_b
    Vector6d p = Vector6d::Zero(), V = Vector6d::Zero();
    Eigen::VectorXd q;  ///< m
  };
  std::vector<Body> bodies;
  std::vector<Articulated> articulated;
  // Columns of the mass matrix under way to the root: twists of a body for unit velocities of its own
  // coordinates, the wrench they need and the modal forces.
  std::vector<Columns6> K;
  Columns6 H;
};

/// The mass matrix, whole and factored.
class MassMatrix {
 public:
  explicit MassMatrix(const Topology& tree) : tree_(tree) {}
  void size(Inertias& inertias) const;

  /// Every body by itself, and its twists for unit velocities of its own coordinates; after
  /// InverseDynamics::set_deformations().
  void own_inertia(const Motion& motion, const Wrenches& wrenches, Inertias& inertias) const;
  /// M (n_v x n_v), dense; after own_inertia().
  void fill(const Motion& motion, Inertias& inertias, MatrixRef M) const;
  /// Prepares solve() in O(n), after own_inertia(); false where M is not positive definite.
  bool factor(const Motion& motion, Inertias& inertias) const;
  /// x <- M^-1 x (n_v), in O(n).
  void solve(Inertias& inertias, VectorRef x) const;
  /// Throws std::invalid_argument where nothing with inertia moves along a coordinate; M is used up.
  void check(MatrixRef M, const Coordinates& coordinates) const;

 private:
  const Topology& tree_;
};

}  // namespace flexura::mbs
