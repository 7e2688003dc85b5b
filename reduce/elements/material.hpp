// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace flexura::reduce {

/// What a material adds to the damping matrix of its elements: alpha M_e + beta K_e, and structurally K_e (1 + i loss).
struct MaterialDamping {
  double alpha = 0.0;  ///< [1/s]
  double beta = 0.0;   ///< [s]
  double loss = 0.0;   ///< loss factor
  bool any() const { return alpha != 0.0 || beta != 0.0 || loss != 0.0; }
};

/// A layer of a shell's section, of the elasticity of a Material.
struct Ply {
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
  double density = 0.0;    ///< [kg/m^3]
  double thickness = 0.0;  ///< [m]
};

/// A linear elastic material.  D maps strain to stress [Pa]; both are ordered (xx, yy, zz, xy, yz, zx) with
/// engineering shear strains gamma = 2 epsilon.
struct Material {
  std::string name;
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Zero();
  double density = 0.0;  ///< [kg/m^3]
  MaterialDamping damping = {};
  /// Of a shell whose section has unlike layers: from the side against its normal to the other.  D and density are their
  /// means then.
  std::vector<Ply> plies = {};
  Eigen::Vector3d ply_axis = Eigen::Vector3d::Zero();  ///< the first axis of the section
};

/// Unlike layers of a shell, whose first axis is `axis` (of the mesh).  std::invalid_argument without layers or where one is
/// not thicker than 0.
Material laminate(std::string name, std::vector<Ply> plies, const Eigen::Vector3d& axis);

/// Hooke's law of an isotropic material.  E [Pa] > 0, -1 < nu < 0.5, density [kg/m^3] > 0; otherwise
/// std::invalid_argument that names the material, the value and the rule.
Material isotropic(std::string name, double E, double nu, double density);

/// Engineering constants of an orthotropic material whose axes are those of the mesh frame B.
/// nu_ij is the contraction along j when pulled along i: nu_ij / E_i = nu_ji / E_j.
struct OrthotropicConstants {
  double E_x, E_y, E_z;        ///< [Pa]
  double nu_xy, nu_yz, nu_zx;  ///< [-]
  double G_xy, G_yz, G_zx;     ///< [Pa]
};

/// The material with its axes along the columns of R (a rotation) instead of the mesh frame's:
/// D'_ijkl = R_ip R_jq R_kr R_ls D_pqrs.
Material turned(Material material, const Eigen::Matrix3d& R);

/// Throws std::invalid_argument where the constants have no positive definite stiffness.
Material orthotropic(std::string name, const OrthotropicConstants& constants, double density);

}  // namespace flexura::reduce
