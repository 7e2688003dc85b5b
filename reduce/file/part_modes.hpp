// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/file/part_file.hpp"

// The part file's choice of modes; for part_file.cpp only.
namespace flexura::reduce {

/// The tables [modes] of solid parts and [mode_vectors].
input::TableSchema solid_modes_schema();
input::TableSchema mode_vectors_schema();

/// What [modes] has for solid parts beyond read_modes().
void read_solid_modes(const input::Section& in, ModesInput& modes);

/// The table [mode_vectors] and what does not go with it.
void read_finished_modes(const input::Section& in, PartInput& part);

/// Keys of [modes] against the interfaces' ties, which must have been read.
void check_elastic_ties(const input::Section& modes, const PartInput& part);

}  // namespace flexura::reduce
