// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/cms/result/reduction.hpp"

/// One form for every set of modes.
///
/// Whatever vectors z_j span the reduced space (free modes, attachment modes, what is left after modes were
/// struck out), there is a basis of the same space in which the interface dofs are coordinates,
///
///     Y = [ P  E ],   P_b = 1,   E_b = 0,   E^T M E = 1,   E^T K E = Omega^2,   E^T K P = 0,
///
/// provided that the vectors move all interface dofs independently.  Rigid motions in the space are P R_b
/// exactly: they are strain-free, and E^T K P = 0 leaves them no part in E.  So every superelement has
/// K_se = diag(K_bb, Omega^2) and interface dofs by name, and the runtime need not know how it was made.
namespace flexura::reduce {

/// A vector is dropped as dependent where less than this share of its length (in the mass norm) stands
/// upright on those before it: its own round-off (1e-10 and less) would otherwise become a shape.
inline constexpr double kDependent = 1e-5;

struct CanonicalShapes {
  Eigen::MatrixXd Y;         ///< m x (n_b + n_q): the new shapes as combinations of the given vectors
  Eigen::VectorXd omega2;    ///< n_q, ascending
  std::vector<int> dropped;  ///< given vectors that depend on earlier ones
};

/// `K`, `M` (m x m) are the given vectors' stiffness and mass, `B` (n_b x m) their interface dofs.  Throws
/// std::invalid_argument where they do not move all interface dofs independently.
CanonicalShapes canonical_shapes(const Eigen::MatrixXd& K, const Eigen::MatrixXd& M,
                                 const Eigen::MatrixXd& B);

/// A direction of an interface is no dof of its own where less than this share of its motion (by the vectors, in the mass norm)
/// differs from what the chosen ones say: vectors are known to 1e-8 and worse (their own solves, digits that were printed), and the
/// stiffness of a dof that hardly moves by itself loses twice the digits.
inline constexpr double kSameMotion = 1e-5;

/// Which of the interface dofs (rows of `B`) the vectors move independently: as many as there are, the most independent ones.
std::vector<int> independent_dofs(const Eigen::MatrixXd& M, const Eigen::MatrixXd& B);

/// Few vectors move fewer dofs independently than the interfaces have: leaves the interfaces the dofs `own` (rows of `B`, the
/// dofs of all interfaces by the shapes) and makes the others follow.  Returns their names, "tip theta_x".
std::vector<std::string> let_others_follow(Reduction& reduction, const Eigen::MatrixXd& B,
                                           const std::vector<int>& own);

/// Replaces the shapes T by T Y in everything that the reduction holds.  The error estimate, which is that of
/// Craig and Bampton's basis, goes.
void change_shapes(Reduction& reduction, const CanonicalShapes& shapes);

struct StruckModes {
  std::vector<double> frequencies;  ///< [Hz] of the modes that went
  Eigen::MatrixXd Y;                ///< the shapes that are left, by those that were there
  double interface_stiffer = 0.0;   ///< greatest relative gain of the interface's static stiffness
};

/// Strikes out natural modes of the free body by number, as `flexura modes --free` counts them: 1 to 6 are
/// the rigid ones, which must stay.  Throws std::invalid_argument for numbers that there are not and where
/// the rest cannot move all interface dofs.
StruckModes strike_modes(Reduction& reduction, const std::vector<int>& numbers);

}  // namespace flexura::reduce
