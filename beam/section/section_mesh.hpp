// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "beam/section/solver.hpp"

namespace flexura::beam {

/// Refusals of solve_section for meshes and plies that are no section.
void check_section_mesh(const std::string& name, const SectionMesh& mesh, const std::vector<Ply>& plies);

/// Closed lines of edges that belong to one triangle only, mid-side nodes included; adds their nodes to
/// `nodes`.
std::vector<Loop> boundary_loops(const SectionMesh& mesh, std::vector<int>& nodes);

}  // namespace flexura::beam
