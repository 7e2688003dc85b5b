// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "reduce/beams/numbering.hpp"
#include "reduce/beams/statics.hpp"
#include "reduce/cms/craig_bampton.hpp"

/// Craig-Bampton reduction of a structure of beams, with solids or without (craig_bampton.hpp has the
/// equations; here a node has six dofs and the mass matrix is the beams' own).  With T on all nodal dofs the
/// inertia integrals are
///
///     S_phi = S_u T,   S_xphi = S_xu T,   S_phiphi(ab) = T^T S_uu(ab) T,   M_se = S_phiphi(xx) + (yy) + (zz)
///
/// with the sums of beam/model/mesh.hpp, which hold the sections' rotation.
namespace flexura::reduce {

struct BeamReduction {
  Reduction reduction;  ///< shapes at the vertices of the structure's picture
  Eigen::MatrixXd T;    ///< n_dofs x n: dofs of the structure from the superelement's, for recovery
  /// F_rs P = (K_ii^-1 - Phi Omega^-2 Phi^T) P_i on all dofs, the interfaces at rest: how far the structure gives way to
  /// loads P (n_dofs x k) beyond what T shows.  Needs a linalg::Session.
  std::function<Eigen::MatrixXd(const Eigen::MatrixXd& P)> left_out;
};

/// Reduces the structure.  `options.shape_nodes` is not used; shapes are given at the structure's picture.
/// The static answers to preloads among `cases` become shapes, too; with stiffening all of them have their terms.
/// Needs a linalg::Session.  Throws std::invalid_argument for no interface, an interface at a node twice or
/// that does not exist, interfaces that leave a motion free (names the node and direction where it shows),
/// beams without mass where modes are wanted; std::runtime_error when a computation fails.
/// Where the interfaces leave rigid motions free (or there are none): the node of members that lies nearest to the
/// middle and is no interface, as one more, "body", which takes them; with six directions it stiffens nothing.
/// Empty where they hold the structure, or no node is left.
std::optional<BeamInterface> body_interface(const Structure& structure,
                                            const std::vector<BeamInterface>& interfaces);

BeamReduction reduce_beams(const Structure& structure, const std::vector<BeamInterface>& interfaces,
                           const ReductionOptions& options, const std::vector<LoadCase>& cases = {});

}  // namespace flexura::reduce
