// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/superelement/superelement.hpp"

/// Natural modes of a superelement, (K_se - omega^2 M_se) phi = 0, with chosen interfaces held.
///
/// Rigid motions are known, not searched for: of the six motions R (translations along, rotations about the
/// axes of B through the mass centre) those that the held interfaces leave free are taken out by rank, r = 6
/// - rank R_held, and the elastic modes are sought in their mass-orthogonal complement, by
///
///     M phi = mu (K + sigma M) phi,   mu = 1 / (omega^2 + sigma),   phi^T M phi = 1
///
/// with a Cholesky factor of K + sigma M: exact count of rigid modes, no threshold on frequencies, massless dofs
/// allowed.  With sigma amid the omega^2 the lowest and the highest are known alike, to round-off times the ratio of their
/// frequencies.
///
/// A body that hinges within itself has more motions without strain.  They are the eigenvectors of K beside the rigid motions whose
/// eigenvalues, with K scaled to a unit diagonal, are round-off (below 1e-10, and 1e4 below the next): mechanisms, which come between the rigid and
/// the elastic modes with omega = 0.
///
/// Effective mass of a mode for the rigid motion r_c of the body,
///
///     m_eff,c = (phi^T M_se r_c)^2 / (phi^T M_se phi),
///
/// is the mass (translations, kg) or moment of inertia (rotations, kg m^2) that takes part when the held
/// interfaces are shaken along or about c.  For a fixed-interface analysis it adds up to the body's mass less
/// what rides on the interfaces.  Elastic modes of a free body have none: they are mass-orthogonal to rigid
/// motion.
namespace flexura::superelement {

struct Mode {
  bool rigid = false;
  bool mechanism = false;  ///< strains nothing, and is no motion of the whole body
  double omega2 = 0.0;     ///< [rad^2/s^2]; 0 for a rigid mode and a mechanism
  double frequency_hz = 0.0;
  /// Of a constraint mode its dof, "base.u_x", and K_se there [N/m, N m/rad]; it moves by 1 m or 1 rad.
  std::string dof = {};
  double stiffness = 0.0;
  double damping = 0.0;  ///< ratio to critical: phi^T D_se phi / (2 omega), or modal_damping without D_se
  Eigen::Matrix<double, 6, 1> effective_mass;  ///< [kg] along x, y, z, [kg m^2] about x, y, z
  Eigen::VectorXd u_se;                        ///< n, phi^T M_se phi = 1
};

struct ModeAnalysis {
  std::vector<std::string> held;  ///< names of the interfaces held
  std::vector<Mode> modes;        ///< rigid ones first, then mechanisms, then by frequency
  int n_rigid = 0, n_mechanisms = 0;
  Eigen::Vector3d mass_centre = Eigen::Vector3d::Zero();  ///< in B [m]
  double mass = 0.0;                                      ///< [kg]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();      ///< about the mass centre [kg m^2]
};

/// Modes with the named interfaces held (none: the free body), at most n_elastic elastic ones (negative:
/// all). Needs the matrices and the inertia integrals.  Throws std::invalid_argument for an unknown
/// interface, when K_se has negative eigenvalues, and when a motion has neither stiffness nor mass.
ModeAnalysis natural_modes(const Superelement& se, const std::vector<std::string>& held, int n_elastic = -1);

/// The constraint modes: the part's static answer to 1 m or 1 rad of each interface dof, all others at rest.  Their strain energy
/// is half the stiffness.
ModeAnalysis constraint_modes(const Superelement& se);

/// "rigid", "mechanism", "elastic", "constraint".
const char* kind_of(const Mode& mode);

/// The names of all interfaces: what natural_modes() holds for fixed-interface modes.
std::vector<std::string> interface_names(const Superelement& se);

}  // namespace flexura::superelement
