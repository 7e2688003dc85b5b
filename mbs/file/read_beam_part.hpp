// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "mbs/mechanism/beam_part.hpp"

namespace flexura::mbs {

/// The schema of [body.NAME.beam].
input::TableSchema beam_part_schema();

/// Throws InputError.
BeamPart read_beam_part(const input::Section& s);

}  // namespace flexura::mbs
