// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "reduce/cms/result/load_case.hpp"
#include "reduce/cms/result/reduction.hpp"

namespace flexura::reduce {

/// Section forces of the bars of a deck, at 0, l/3, 2 l/3 and l of each.  With q the motion of its ends and a the acceleration
/// less gravity of its mass points, the bar's ends bear
///
///     f = K q + sum of m C^T a,     (N, V_y, V_z, T, M_y, M_z) = -f_1 at its first end, f_2 at its second
///
/// which is in balance with all that acts on either side.  Between the ends N, V and T are linear, moments the cubic of their
/// values and of their slopes V (exact without inertia of the bar; what lies on it by less than the cube of its length).  q is that of
/// the shapes and of what they lack (SectionForces::of_acceleration and of_loads); the inertia of a deformation that turns with
/// the body is in balance, but what it deforms further is not counted, as it is of higher order.
///
/// Empty without bars.  What the shapes lack is not known of all reductions (Reduction::bars); then it is left out, and so are the
/// groups that need it.
std::optional<superelement::SectionForces> bar_sections(const Part& part, const Reduction& reduction,
                                                        const std::vector<LoadField>& loads);

}  // namespace flexura::reduce
