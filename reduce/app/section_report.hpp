// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "beam/section/solver.hpp"
#include "mbs/base/documents/schema.hpp"

/// What `flexura section` hands out: a table, a drawing, and a file that beam parts read.
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

/// A TOML file for `type = "file"` in a beam part: stiffness and mass, what warnings need, stress points,
/// outline.
std::string section_result(const beam::SectionProperties& properties);

/// Schema of such a file.
const input::TableSchema& section_result_schema();

/// Reads it back.  Throws input::InputError for files that are no such thing, and for matrices that no
/// section has.
beam::Section read_section_result(const std::string& name, const std::filesystem::path& file);

}  // namespace flexura::reduce
