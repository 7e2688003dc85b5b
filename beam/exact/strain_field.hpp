// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// The strains of one element as a field of few coordinates: what the element can do, and all that makes a beam, a rod
/// or a cable of it.
///
/// Strains of a geometrically exact beam (J. C. Simo, Comput. Methods Appl. Mech. Eng. 49 (1985) 55): with E(x) the
/// section's axes and r(x) its place, E' = E kappa^, r' = E (e_1 + gamma),
///
///     eps = (gamma_x, gamma_y, gamma_z, kappa_x, kappa_y, kappa_z) less those of the stress-free shape = Phi(x) s
///
/// in the axes of the section.  Coordinates are strains, not places of nodes (F. Boyer, V. Lebastard, F. Candelier,
/// F. Renda, IEEE Trans. Robot. 37 (2021) 847): rigid motion has none, so the element is objective; what is not to be
/// strained has no coordinate, so nothing locks and no stiff mode is left; stiffness and damping are constant,
///
///     K = int Phi^T C Phi dx,    D = tau K.
namespace flexura::beam::exact {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// What a beam lets happen.
enum class Kind {
  beam,   ///< all six strains: ten coordinates
  rod,    ///< torsion and bending, six; neither stretch nor shear
  cable,  ///< stretch and bending, three, the same all along; neither shear nor torsion
};

struct StrainField {
  /// n x 3 each: of the curvatures at the start, of their slope [1/m], and of gamma at the start and its slope.
  /// Curvatures are linear along the element, kappa = k_0 + x k_1.
  Eigen::Matrix<double, 3, Eigen::Dynamic> k_0, k_1, g_0, g_1;
  Eigen::MatrixXd K;         ///< n x n [N m]
  bool is_constant = false;  ///< along the element: k_1 = g_1 = 0

  int n() const { return static_cast<int>(k_0.cols()); }
};

/// Of an element of length l with the section stiffness C (N, V_y, V_z, T, M_y, M_z).  A beam's strains are C^-1 times resultants
/// that are the same all along, and N, T, M_y and M_z that are linear besides.  So constant loads at the ends, M_y' = V_z and
/// M_z' = -V_y, are answered exactly whatever C couples, as by the linear element; the moments' slopes are coordinates of their
/// own, since in a section that twists or has bent far M' = -kappa x M - (e_1 + gamma) x (N, V), of which V is a part alone.
/// Shears that change along the element have no coordinates: they would cost a third more time, against an
/// error of EI / (GA L^2) of the deflection.  A rod's torque and moments are linear.  Coordinates are without dimension, of the
/// size of the strains, curvatures times l.  Throws std::invalid_argument where the strains that there are have no
/// positive stiffness; a cable needs none against bending.
StrainField strain_field(Kind kind, const Matrix6d& C, double l);

}  // namespace flexura::beam::exact
