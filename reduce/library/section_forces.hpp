// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "reduce/beams/beam_reduction.hpp"
#include "reduce/beams/beam_stiffening.hpp"

namespace flexura::reduce {

/// Section forces of more members than this would be most of the file.
inline constexpr std::size_t most_members = 1000;

/// A cut through a member.
struct CutPlace {
  int element = 0;  ///< of the mesh
  double x = 0.0;   ///< in it [m]
};

/// Section forces of a reduced beam part at places evenly along each member, nine or more and its elements' ends among
/// them, so that what lies between two follows by a cubic.  `most` places in all, but four of each member at least.
///
///     S_k = the resultants of the members deformed by T.col(k)
///
/// What a load p along the members adds is what it bears on the cut within its element, and the resultants of the
/// deformation F_rs p (BeamReduction::left_out) that the shapes lack: so for the load cases, and for the inertia of the
/// fields of acceleration e_b, x_a e_b and phi_k,a e_b, p = -integral of N_b (1, x_a, phi_k,a) dm.
///
/// `tensions`: those of unit loads, by which the deformed member bears on the cut.  The load N w' turns the member's slope:
/// on end 1 it is that of the element's geometric stiffness, and the cut at x has -integral of N w' from there (v' of M_z likewise).
superelement::SectionForces section_forces(const Structure& structure, const BeamReduction& beams,
                                           const std::vector<LoadCase>& cases, int most,
                                           const UnitTensions* tensions = nullptr);

/// The same at these places; of_stiffening with `tensions` alone, of_acceleration, of_deformation and turning `with_inertia` alone.
superelement::SectionForces section_forces_at(const Structure& structure, const BeamReduction& beams,
                                              const std::vector<LoadCase>& cases,
                                              const std::vector<CutPlace>& places, bool with_inertia,
                                              const UnitTensions* tensions = nullptr);

}  // namespace flexura::reduce
