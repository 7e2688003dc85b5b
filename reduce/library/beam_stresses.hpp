// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "reduce/beams/beam_reduction.hpp"

namespace flexura::reduce {

/// Stress modes of a reduced beam part at the vertices of its members' outlines: sigma = R (S(y, z) s_k) R^T with the resultants s_k
/// of each shape at the vertex' cut (section_forces.hpp) and the section's own solution S (outline_stress.hpp, or that of
/// `flexura section`).  Members whose section knows no stresses have none there, which is told in `notes`; empty where no member has.
std::optional<superelement::StressModes> beam_stresses(const Structure& structure, const BeamReduction& beams,
                                                       const std::vector<LoadCase>& cases,
                                                       bool double_precision,
                                                       std::vector<std::string>& notes);

}  // namespace flexura::reduce
