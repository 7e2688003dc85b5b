// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/file/part_file.hpp"

// What is kept of a part: for part_file.cpp and beam_file.cpp only.
namespace flexura::reduce {

/// The tables [modes] and [recovery] of all parts, of solid parts, [mode_vectors], [damping].
input::TableSchema modes_schema();
input::TableSchema solid_modes_schema();
input::TableSchema mode_vectors_schema();
input::TableSchema damping_schema();
input::TableSchema recovery_schema();
input::TableSchema solid_recovery_schema();

RecoveryInput read_recovery(const input::Section& in);

/// [modes], [damping] and stiffening of a part of any kind.
void read_request(const input::Section& in, ReductionRequest& request);

/// What [modes] has for solid parts beyond that; their interfaces must have been read.
void read_interface_modes(const input::Section& modes, PartInput& part);

/// The table [mode_vectors] and what does not go with it.
void read_finished_modes(const input::Section& in, PartInput& part);

}  // namespace flexura::reduce
