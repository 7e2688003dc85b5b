// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/superelement/superelement.hpp"
#include "reduce/cms/result/reduction.hpp"
#include "reduce/part/part_input.hpp"

namespace flexura::reduce {

/// Copies a reduction into the struct that is written to the file.  `stress_vertices` are the places of its
/// stress modes among the surface's vertices.
superelement::Superelement to_superelement(const ReductionRequest& input, Reduction&& reduction,
                                           superelement::Surface&& surface, std::string report_json,
                                           std::vector<std::int32_t> stress_vertices = {});

/// What is estimated of the mesh, as the file keeps it; `nodes` of the surface's vertices, ascending.
superelement::MeshError to_mesh_error(const MeshShare& share, const Part& part,
                                      const std::vector<mesh::Index>& nodes);

/// Motions of all nodes, by the numbers of the mesh's file.
superelement::NodalMotions to_nodal_motions(const NodeMotions& motions, const mesh::Mesh& mesh,
                                            bool double_precision);

/// The materials' compliances at the stress modes' places, which are these nodes.
void add_compliance(const Part& part, const std::vector<mesh::Index>& nodes,
                    superelement::StressModes& stress);

}  // namespace flexura::reduce
