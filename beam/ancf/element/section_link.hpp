// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "beam/ancf/element/ancf_element.hpp"
#include "beam/section/section.hpp"

/// ANCF constants from the cross-sections that all beams share.
namespace flexura::beam::ancf {

/// The full 6x6 stiffness with its couplings and the section's mass moments.  Throws std::invalid_argument
/// for a shear-rigid section.
BeamSection beam_section(const Section& section, double damping_time = 0.0);

/// Line that bends in the section's x-y plane (about z): EA, E I_z; eccentricities and shear are not part of
/// a line. Throws std::invalid_argument when stretch or another bending couples to it.
LineSection planar_line_section(const Section& section, double damping_time = 0.0);

/// Line that bends alike in all directions.  Throws std::invalid_argument when the two bending stiffnesses
/// differ by more than 1 % or couple to the stretch; such a section needs a beam.
LineSection spatial_line_section(const Section& section, double damping_time = 0.0);

}  // namespace flexura::beam::ancf
