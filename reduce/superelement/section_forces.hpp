// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/model/mesh.hpp"
#include "mbs/superelement/superelement.hpp"

namespace flexura::reduce {

/// Section forces of every shape of a reduced beam part, at `places` evenly along each member:
///
///     S_k(place) = the resultants of beam::member_results for the displacements T.col(k)
///
/// T: dofs of the structure from the superelement's; its first rows are those of the beam mesh.
superelement::SectionForces section_forces(const beam::BeamMesh& mesh, const Eigen::MatrixXd& T, int places);

}  // namespace flexura::reduce
