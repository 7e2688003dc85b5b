// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "reduce/assembly/input/part.hpp"
#include "reduce/estimate/mesh_error.hpp"
#include "reduce/linalg/dense/progress.hpp"

/// The mesh's error by what the next degree would add.
///
/// A shape u that vibrates with omega^2 = lambda under forces F on the interfaces leaves, tested with functions w that the
/// mesh lacks (enrichment.hpp),
///
///     r(w) = lambda m(u, w) - a(u, w) + F(w),
///
/// F(w) the work of the traction that an averaging tie makes of F.  The answer e, a(e, w) = r(w), has the energy that
/// the enriched space gains over the mesh's own, which is nearly all that is missing where the exact solution is smooth
/// (R. E. Bank, A. Weiser, Math. Comp. 44 (1985), 283; M. Ainsworth, J. T. Oden, A Posteriori Error Estimation in Finite
/// Element Analysis, chapter 5).  e is sought among all functions of the enriched mesh: r does not load the mesh's own
/// (the shape is in equilibrium there), but without them thin elements could not bend.  A few steps of conjugate
/// gradients, preconditioned by the cells' own inverses with shared functions weighted by their stiffness, come from
/// below to within a few per cent: r is rough, so that no coarse problem is needed.  The degrees after the next add
/// about a fifth more to cells of second degree (measured, docs/mesh_error.md), and along sharp edges what theory says of the
/// rate there.  Functions on faces of rigid ties are
/// left out.
namespace flexura::reduce {

/// Whether the cells' enrichments are known and the elements are displacement elements with full integration.
bool enrichment_suits(const Part& part);

/// a(e, e) of each of k states: displacements U (3 n_nodes x k), lambda [rad^2/s^2] (k, 0 for statics), forces on the interface
/// dofs (n_b x k, or empty).
MeshEnergy enriched_energy(const Part& part, const Eigen::MatrixXd& U, const Eigen::VectorXd& lambda,
                           const Eigen::MatrixXd& force, const linalg::Progress& progress);

}  // namespace flexura::reduce
