// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "beam/model/mesh.hpp"
#include "reduce/cms/craig_bampton.hpp"

/// Craig-Bampton reduction of a structure made of beams (craig_bampton.hpp has the equations; here a node has
/// six dofs and the mass matrix is the beams' own).  With T on all nodal dofs the inertia integrals are
///
///     S_phi = S_u T,   S_xphi = S_xu T,   S_phiphi(ab) = T^T S_uu(ab) T,   M_se = S_phiphi(xx) + (yy) + (zz)
///
/// with the sums of beam/model/mesh.hpp, which hold the sections' rotation.
namespace flexura::reduce {

/// An interface: a node of the beam model and the directions kept, 0-2 displacement, 3-5 rotation, ascending.
struct BeamInterface {
  std::string name;
  int node = -1;
  std::vector<int> directions = {0, 1, 2, 3, 4, 5};
};

struct BeamReduction {
  Reduction reduction;            ///< shapes at the vertices of `surface`
  beam::ExtrudedSurface surface;  ///< extruded sections, for pictures
  Eigen::MatrixXd T;  ///< 6 n_nodes x n: nodal dofs of the mesh from the superelement's, for recovery
};

/// Reduces the mesh.  `options.shape_nodes` is not used; shapes are given at the extruded surface.  Needs a
/// linalg::Session.  Throws std::invalid_argument for no interface, an interface at a node twice or that does
/// not exist, interfaces that leave a motion free (names the node and direction where it shows), beams
/// without mass where modes are wanted; std::runtime_error when a computation fails.
BeamReduction reduce_beams(const beam::BeamMesh& mesh, const std::vector<BeamInterface>& interfaces,
                           const ReductionOptions& options);

}  // namespace flexura::reduce
