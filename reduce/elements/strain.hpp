// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <vector>

#include "reduce/elements/solid.hpp"

/// The strains that an element's stiffness is made of, strain = B u with u its 3 n displacements: those of its shape functions
/// and what its formulation makes of them.  With b_a the mean of the shape gradients N_a,x over the volume V,
///
///     mean_volume   B* = B + 1/3 (1 1 1 0 0 0)^T (b - tr B)                the change of volume is its mean
///     uniform       B* = B(b)                                              all of it is the mean
///     at_points     B* = sum_q L_q(xi) B(xi_q)                             L_q of Lagrange through the points xi_q of the rule
///     bubbles       B* = B - B_a K_aa^-1 K_au                              solid.hpp
///
/// Stresses D B* u are the element's own: its nodal forces are integral B^T D B* u dV, but for what holds hourglasses.
namespace flexura::reduce {

using StrainMatrix = Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, 3 * kMaxNodes>;

class StrainField {
 public:
  /// Positions [m] and elasticity [Pa].
  StrainField(const Element& element, const NodePositions& x, const Matrix6& D);

  /// B* (6 x 3 n) at a point, whose functions are tabulated; returns det J there, or what is not positive where B* asks
  /// for points at which the element is inverted; then B is that of the shape functions.
  double at(const TabulatedRule::Point& point, StrainMatrix& B) const;
  /// Whether it is more than the shape functions' own strains.
  bool is_plain() const {
    return element_.strains == Strains::whole && element_.enhancement == Enhancement::none;
  }

  /// Mean gradients (n x 3) and the volume, of elements with the mean of something.
  const NodePositions& mean_gradients() const { return mean_; }
  double volume() const { return volume_; }

 private:
  const Element& element_;
  NodePositions x_;
  double inverted_ = std::numeric_limits<double>::infinity();  ///< a det J that is not positive
  double volume_ = 0.0;
  NodePositions mean_;
  Eigen::Matrix3d centre_;   ///< bubbles: J_0
  Eigen::MatrixXd bubbles_;  ///< 9 x 3 n: alpha = bubbles u
  std::vector<StrainMatrix> at_points_;
};

/// Strains of the shape functions alone, from their gradients (n x 3).
void fill_strain_matrix(const NodePositions& gradients, StrainMatrix& B);

/// Strains of the nine bubbles' amplitudes at a point where det J is `det`, J_0 being that of the centre.
void fill_bubble_matrix(const TabulatedRule::Point& point, const Eigen::Matrix3d& J_0, double det,
                        StrainMatrix& B);

}  // namespace flexura::reduce
