// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/shared_assembly.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/linalg/dense/progress.hpp"
#include "reduce/linalg/eigen/eigen_problem.hpp"

/// Full models, nothing reduced, with the same mesh and ties: what a reduction is measured against.
namespace flexura::reduce {

/// The lowest `count` elastic modes of the free body and its six rigid ones (6 + count pairs).  All interface
/// nodes are free.  `omega2_scale` > 0 [rad^2/s^2] is the size of the first elastic eigenvalue: K +
/// omega2_scale M is factorised, and the rigid eigenvalues come out as zero to about 1e-9 of it.
/// `tolerance`: relative residual asked for; slender meshes of thin cells do not keep 1e-9.
linalg::EigenPairs full_free_modes(const Part& part, int count, double omega2_scale,
                                   const linalg::Progress& progress = {}, double tolerance = 1e-9);

/// The lowest elastic modes of the free body (and its six rigid ones) as motions of nodes and interfaces.
struct FreeModes {
  linalg::EigenPairs pairs;             ///< without Phi
  Eigen::MatrixXd U;                    ///< 3 n_nodes x k
  Eigen::MatrixXd rotations;            ///< 3 n_rotations x k
  std::vector<Eigen::MatrixXd> motion;  ///< of each interface node, 6 x k
};
/// `request` counts the rigid modes, too; `omega2_scale` as above.  With this rank's `share` of the part it is collective: a
/// team's ranks share the work, U is of the nodes here, and `part` is read on rank 0 alone.
FreeModes free_modes_on_nodes(const Part& part, const linalg::EigenRequest& request, double omega2_scale,
                              const linalg::Progress& progress = {}, const PartShare* share = nullptr);

/// The lowest modes with one interface clamped (all six motions of its node) and the others free.
linalg::EigenPairs full_clamped_modes(const Part& part, const std::string& clamped, int count,
                                      const linalg::Progress& progress = {});

/// Motions of all interface nodes (6 n_interfaces x 6) under unit forces and moments on interface `loaded`
/// while interface `clamped` is held; row 6 k + d is direction d of interface k.
Eigen::MatrixXd full_static_compliance(const Part& part, const std::string& clamped,
                                       const std::string& loaded, const linalg::Progress& progress = {});

/// The same from a superelement with six directions at each interface.
Eigen::MatrixXd reduced_static_compliance(const Reduction& reduction, const std::string& clamped,
                                          const std::string& loaded);

/// Eigenvalues omega^2 of the free superelement, ascending; the first six are the rigid ones.
Eigen::VectorXd reduced_free_modes(const Reduction& reduction);

}  // namespace flexura::reduce
