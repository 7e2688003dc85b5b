// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/input/part.hpp"
#include "reduce/linalg/dense/progress.hpp"

/// What the mesh leaves of the energy, by recovered stresses.
///
/// For a shape u_h of the mesh and the exact u that it stands for, the difference e has the energy |e|^2, estimated
/// with recovered stresses s* (stress_recovery.hpp) in place of the exact ones (O. C. Zienkiewicz, J. Z. Zhu, Int. J.
/// Numer. Meth. Eng. 24 (1987), 337):
///
///     E = integral (s* - s)^T C (s* - s) dV,    C = D^-1.
///
/// A conforming mesh is too stiff by just this energy (Galerkin orthogonality):
///  - the eigenvalue of a mode with u^T M u = 1:  lambda_h - lambda = E  (G. Strang, G. J. Fix, An Analysis of the
///    Finite Element Method, chapter 6),
///  - the compliance under a unit load, u its answer:  C - C_h = E.
/// Rigid motions have no part in it.  Where the elements' enrichments are known, enriched_error.hpp is better.
namespace flexura::reduce {

/// Whether a material's bulk modulus is more than a hundred times its shear modulus (Poisson's ratio above 0.495): elements of
/// displacements lock there, and no estimate sees it.
bool is_nearly_incompressible(const Part& part);
/// Bulk over shear modulus, of an isotropic material.
double bulk_over_shear(const Material& material);

/// Displacements that are judged.
struct JudgedStates {
  Eigen::MatrixXd Y;       ///< n x k: combinations of the shapes
  Eigen::VectorXd lambda;  ///< k: omega^2 [rad^2/s^2], 0 for statics
  Eigen::MatrixXd
      force;  ///< n_b x k: on the interface dofs, in the order of the part's interfaces and directions
};

/// Energies [J] that the mesh leaves in k states, and the share of each cell, in the order of the blocks.
struct MeshEnergy {
  Eigen::VectorXd energy;   ///< k
  Eigen::MatrixXf by_cell;  ///< n_cells x k
  bool known() const { return energy.size() > 0; }
};

/// Of displacements U (3 n_nodes x k); not known where the part has no cells (matrices of another program).
MeshEnergy recovered_energy(const Part& part, const Eigen::MatrixXd& U, const linalg::Progress& progress);

}  // namespace flexura::reduce
