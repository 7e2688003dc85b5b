// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <string>
#include <vector>

/// The cross-section of a beam: what its element needs (a 6x6 stiffness and the section's inertia) and what
/// made it.
///
/// Section frame: origin O on the beam's axis, x along the axis, y the section's width, z its height.
/// A section moves as  u(x,y,z) = u_O + theta x (0, y, z), so with (u, v, w) = u_O
///
///     strains     e = (eps, gamma_y, gamma_z, kappa_x, kappa_y, kappa_z)
///                   = (u', v' - theta_z, w' + theta_y, theta_x', theta_y', theta_z')
///     resultants  s = (N, V_y, V_z, T, M_y, M_z) at O,   s = C e,   e = f s
///     N = int sigma dA,  T = int (y tau_xz - z tau_xy) dA,  M_y = int z sigma dA,  M_z = -int y sigma dA
///
/// Homogeneous sections (SIMBEAM type 10 and 11), static moments S_y = int z dA, S_z = int y dA, moments
/// about O, and the product of inertia with the sign of an inertia tensor, **I_yz = -int y z dA**
/// (SIMBEAM's):
///
///     [N  ]     [ A    S_y   -S_z ] [eps    ]
///     [M_y] = E [ S_y  I_y   I_yz ] [kappa_y]
///     [M_z]     [-S_z  I_yz  I_z  ] [kappa_z]
///
///     V_y = G A_sy gamma_y,   V_z = G A_sz gamma_z of the shear centre,   T + V_y z_cs - V_z y_cs = G I_t kappa_x
namespace flexura::beam {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Position of each strain and resultant in the vectors above.
enum Component : int { N = 0, V_y = 1, V_z = 2, T = 3, M_y = 4, M_z = 5 };

/// A homogeneous, isotropic material [Pa, kg/m^3].  G is kept apart from E and nu because SIMBEAM takes it
/// so.
struct Material {
  std::string name;
  double E = 0.0;
  double G = 0.0;
  double rho = 0.0;

  /// Poisson's ratio that E and G imply; shear factors use it.
  double nu() const { return E / (2.0 * G) - 1.0; }
};

/// G = E / (2 (1 + nu)).  Throws std::invalid_argument unless E > 0, -1 < nu < 0.5, rho >= 0.
Material isotropic(std::string name, double E, double nu, double rho);

/// Constants of a homogeneous section; lengths in m.  Types 1 to 7 fill it from their dimensions, type 10
/// (General Basic) leaves the second group at zero, type 11 (General Advanced) uses all of it.
struct Constants {
  double A = 0.0;               ///< area [m^2]
  double I_y = 0.0, I_z = 0.0;  ///< int z^2 dA, int y^2 dA about O [m^4]
  double I_t = 0.0;             ///< Saint-Venant torsion constant [m^4]
  double A_sy =
      std::numeric_limits<double>::infinity();  ///< shear areas kappa A [m^2]; infinite: shear-rigid
  double A_sz = std::numeric_limits<double>::infinity();

  double I_yz = 0.0;              ///< -int y z dA about O [m^4]
  double S_y = 0.0, S_z = 0.0;    ///< int z dA, int y dA about O [m^3]
  double y_cs = 0.0, z_cs = 0.0;  ///< shear centre [m]
  double y_cg = 0.0, z_cg = 0.0;  ///< centre of gravity [m]
};

/// Section integrals of the mass, per unit length.  They define the 6x6 section mass of (u, v, w, theta).
struct SectionInertia {
  double m = 0.0;                             ///< int dm [kg/m]
  double m_y = 0.0, m_z = 0.0;                ///< int y dm, int z dm [kg]
  double m_yy = 0.0, m_zz = 0.0, m_yz = 0.0;  ///< int y^2 dm, int z^2 dm, int y z dm [kg m]

  /// 2 x kinetic energy per length = (u', theta')^T matrix() (u', theta').
  Matrix6d matrix() const;
};

/// A point of the section where stresses are wanted: (sigma_xx, tau_xy, tau_xz) = S s [Pa], s the six
/// resultants.
struct StressPoint {
  std::string name;
  double y = 0.0, z = 0.0;
  Eigen::Matrix<double, 3, 6> S = Eigen::Matrix<double, 3, 6>::Zero();
};

/// A closed polygon of the outline; outer loops counter-clockwise about x, holes clockwise.
using Loop = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;

struct Section {
  std::string name;
  Matrix6d f = Matrix6d::Zero();  ///< flexibility, e = f s
  Matrix6d f_shear_rigid =
      Matrix6d::Zero();  ///< the same with the shear stiffness C_VV infinite (Euler-Bernoulli)
  SectionInertia inertia;

  std::optional<Constants> constants;  ///< of a homogeneous section
  std::optional<Material> material;
  double I_w = 0.0;               ///< warping constant [m^6], 0 where unknown
  bool open_thin_walled = false;  ///< restrained warping would matter: 12 dofs cannot carry it

  std::vector<StressPoint> points;
  std::vector<Loop> outline;  ///< for pictures; may be empty

  /// C = f^-1.  Throws std::invalid_argument when the section is shear-rigid (C has no finite entries there).
  Matrix6d stiffness() const;
};

/// Types 1 to 11.  Throws std::invalid_argument naming the section, the value and the rule for: non-positive
/// A, I_y, I_z, I_t, A_sy or A_sz; a stiffness or mass matrix that is not positive definite (moments that do
/// not belong to the static moments or the centre of gravity); non-positive E, G; negative rho; anything not
/// finite.
Section make_section(std::string name, const Constants& constants, const Material& material);

/// Type 12, Matrix Input: C is 6x6 in the order N, V_y, V_z, T, M_y, M_z [N, N m, N m^2]; mass is the 6x6
/// section mass [kg/m, kg, kg m].  Throws std::invalid_argument unless C is symmetric and positive definite
/// and the mass is that of a section that moves rigidly (M_11 = M_22 = M_33, M_44 = M_55 + M_66, ...),
/// positive semi-definite.
Section matrix_section(std::string name, const Matrix6d& C, const Matrix6d& mass);

/// The integrals in a 6x6 section mass; refusals as for matrix_section.
SectionInertia inertia_of(const std::string& name, const Matrix6d& mass);

/// f with the shear stiffness C_VV made infinite: in f = J^T diag(C_VV^-1, f_oo) J, J = [I 0; f_oo^-1 f_oV
/// I], the first term is dropped.  The shear centre stays where it is.
Matrix6d without_shear_flexibility(const Matrix6d& f);

/// Inverse of a symmetric positive definite 6x6 whose rows may differ by any factor of units: scaled to unit
/// diagonal, then Cholesky.  Diagonal matrices invert to round-off.  Throws std::invalid_argument "<what> is
/// not positive definite: ..." with the smallest eigenvalue of the scaled matrix.
Matrix6d inverse_spd(const Matrix6d& matrix, const std::string& what);

}  // namespace flexura::beam
