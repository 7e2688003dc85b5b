// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mesh/import/imported.hpp"

namespace flexura::reduce {

/// Leaves of a model the piece with the most nodes alone, of those that cells, bars, springs, ties and equations join; what
/// goes is said in its messages.
void keep_largest_piece(mesh::ImportedModel& model);

}  // namespace flexura::reduce
