// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"
#include "mbs/mechanism/beam_part.hpp"

namespace flexura::mbs {

/// The schema of [body.NAME.beam].
input::TableSchema beam_part_schema();

/// What a fidelity does with the table.
struct BeamUse {
  /// Constants of the section that it does not read.
  std::vector<std::string> ignores = {};
  /// And of one that bends in a plane alone.
  std::vector<std::string> ignores_in_plane = {};
  /// The stress-free axis may be curved.
  bool may_be_curved = false;
  /// It may bend in a plane alone.
  bool may_be_planar = false;
};

/// Throws InputError.
BeamPart read_beam_part(const input::Section& s, const BeamUse& use = {});

}  // namespace flexura::mbs
