// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "beam/section/section.hpp"

/// Any section: the Saint-Venant problems (stretch, two bendings, torsion, two flexures) on a mesh of
/// six-node triangles, one or several materials, isotropic or orthotropic plies.
///
/// The section's points move by its rigid motion and a warping g(x, y, z) in all three directions,
///
///     strain = Phi e + B g + S g',   Phi e: the rigid section's strains, B and S: derivatives across and along
///
///     E = int B^T Q B,     C = int B^T Q S,     M = int S^T Q S,
///     R = int B^T Q Phi,   L = int S^T Q Phi,   A = int Phi^T Q Phi
///
/// Far from the ends resultants are s(x) = (1 + x D) s_0 (D as in beam/element), and e = (Y + x Y_1) s_0,
/// g = (X + x X_1) s_0 solve, order by order in x,
///
///     [E   R] [X_1]   [0]        [E   R] [X]   [(C^T - C) X_1 + L Y_1]
///     [R^T A] [Y_1] = [D],       [R^T A] [Y] = [1 - L^T X_1          ]
///
/// and the flexibility is the energy per length, f = (X, X_1, Y)^T [E C R; C^T M L; R^T L^T A] (X, X_1, Y).
/// In-plane warping is included, so sigma_yy = sigma_zz = 0 comes out and E A needs no correction for nu.
/// V. Giavotto, M. Borri, P. Mantegazza, G. Ghiringhelli, V. Carmaschi, G. C. Maffioli, F. Mussi, Anisotropic
/// beam theory and applications, Comput. Struct. 16 (1983) 403-413; J. P. Blasques, M. Stolpe, Compos.
/// Struct. 94 (2012) 3278-3289.
namespace flexura::beam {

/// A mesh of the section, y and z in m.  Corners counter-clockwise about x, then the mid-side nodes of 01,
/// 12, 20.
struct SectionMesh {
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> points;  ///< n x 2: y, z
  Eigen::Matrix<int, Eigen::Dynamic, 6, Eigen::RowMajor> triangles;  ///< m x 6
  std::vector<int> ply;             ///< m, index into the plies; empty = all 0
  std::vector<double> plane_angle;  ///< m, added to the ply's plane angle [rad]; empty = 0 (curved laminates)
};

/// Elastic constants in material axes 1, 2, 3.
struct PlyMaterial {
  std::string name;
  double rho = 0.0;
  double E_1 = 0.0, E_2 = 0.0, E_3 = 0.0;
  double G_12 = 0.0, G_13 = 0.0, G_23 = 0.0;
  double nu_12 = 0.0, nu_13 = 0.0, nu_23 = 0.0;  ///< nu_ij: contraction along j of a pull along i
};
PlyMaterial ply_of(const Material& isotropic);

/// A material as it lies in the section.  Axis 1 is along the beam's x turned by `fibre_angle` about the
/// ply's normal (towards the ply's direction in the section), that direction is y turned by `plane_angle`
/// about x.
struct Ply {
  PlyMaterial material;
  double fibre_angle = 0.0;  ///< [rad]
  double plane_angle = 0.0;  ///< [rad]
};

/// 6x6 stiffness of the ply in section axes, order xx, yy, zz, yz, xz, xy (engineering shear).  Throws
/// std::invalid_argument, naming the material, unless it is positive definite.
Matrix6d stiffness_of(const Ply& ply, double extra_plane_angle = 0.0);

/// What the solver finds.  Moments weighted by E/E_ref (E along the beam), E_ref and G_ref those of the first
/// ply; for one isotropic material they are the plain constants.
struct SectionProperties {
  double E_ref = 0.0, G_ref = 0.0;
  double area = 0.0;                                   ///< plain [m^2]
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();  ///< of the area (y, z) [m]
  Eigen::Vector2d mass_centre = Eigen::Vector2d::Zero();
  Eigen::Vector2d tension_centre = Eigen::Vector2d::Zero();  ///< of E dA: a force there does not bend
  Eigen::Vector2d shear_centre = Eigen::Vector2d::Zero();    ///< a cross force there does not twist
  double A = 0.0;                                            ///< int E/E_ref dA
  double I_y = 0.0, I_z = 0.0, I_yz = 0.0;                   ///< about the tension centre; I_yz = -int y z
  double I_1 = 0.0, I_2 = 0.0;                               ///< principal, I_1 >= I_2
  double principal_angle = 0.0;   ///< from y to the axis of I_1 [rad], in (-pi/2, pi/2]
  double I_t = 0.0;               ///< G_ref I_t = T / kappa_x
  double A_sy = 0.0, A_sz = 0.0;  ///< G_ref A_s = V / gamma with no twist, along y and z
  double shear_coupling = 0.0;  ///< flexibility V_y - V_z over the root of both (0: y, z principal in shear)
  double I_w = 0.0;             ///< warping constant about the shear centre [m^6]
  bool couples = false;         ///< stretch or bending couples with shear or twist (anisotropic plies)
  double size = 0.0;            ///< largest extent [m]
  double decay_length = 0.0;    ///< sqrt(E I_w / (G I_t)) [m]

  /// Warping u_x per unit twist rate about the shear centre, at each mesh node [m^2].
  Eigen::VectorXd warping;

  /// (sigma_xx, tau_xy, tau_xz) by the six resultants at each point of section.outline, its loops one after the other.
  std::vector<Eigen::Matrix<double, 3, 6>> outline_stress;

  Section section;  ///< 6x6, inertia, outline, stress points; open_thin_walled where decay_length exceeds the
                    ///< size
};

/// Solves the section.  Memory and time in proportion to a sparse factor of 3 n unknowns.  Throws
/// std::invalid_argument for a mesh without area, in several pieces, with bad indices or inverted triangles,
/// or plies that do not exist.  `name` goes into the section and the messages.
SectionProperties solve_section(const std::string& name, const SectionMesh& mesh,
                                const std::vector<Ply>& plies);

}  // namespace flexura::beam
