// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <iosfwd>

#include "reduce/app/beam_file.hpp"
#include "reduce/app/reduce_part.hpp"

namespace flexura::reduce {

/// The road from a beam part to a superelement: divide, reduce, check, write.  Warnings of restrained warping
/// and of lost digits go to the report.  Throws like reduce_part; `output` is written whole or not at all.
void reduce_beam_part(const BeamPartInput& part, const std::filesystem::path& output,
                      const OutputOptions& options);

/// The natural frequencies of the free beam structure, nothing reduced, without and with the sections' rotary
/// inertia: `count` elastic modes as a table.
void print_beam_modes(const BeamPartInput& part, int count, std::ostream& out);

}  // namespace flexura::reduce
