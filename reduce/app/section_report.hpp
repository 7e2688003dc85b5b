// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>
#include <string>

#include "beam/section/solver.hpp"

/// What `flexura section` hands out: a table and a drawing (its file for beam parts: reduce/file/section_result.hpp).
namespace flexura::reduce {

/// The same with zero for what is round-off: coordinates below 1e-6 of the section's size (a micrometre
/// beside a metre; the warping field of the solver leaves some 1e-8), products of inertia and angles
/// likewise.
beam::SectionProperties without_round_off(beam::SectionProperties properties);

void print_section(const beam::SectionProperties& properties, std::ostream& out);

/// The same figures as a JSON object, SI units.
std::string section_json(const beam::SectionProperties& properties);

/// A drawing with the outline, the centres and the principal axes; y to the right, z up.
std::string section_svg(const beam::SectionProperties& properties);

}  // namespace flexura::reduce
