// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "reduce/assembly/ties/tied_numbering.hpp"

namespace flexura::reduce {

/// Throws std::invalid_argument for interfaces without nodes, too narrow for what they hold, or that share nodes, and unless
/// `may_be_free` for interfaces that leave a rigid motion of the body free.
void check_interfaces(const Part& part, const TiedNumbering& numbering, bool may_be_free);

/// All nodes must hang together through cells and ties, or the interfaces hold each piece.
void check_pieces(const Part& part, const TiedNumbering& numbering);

/// The numbering of a part that has passed both checks.
TiedNumbering checked_numbering(const Part& part, bool may_be_free);

/// Averaging ties have no stiffness in K_ii: as many interior dofs as there are rigid motions that the other ties leave free,
/// at which weak springs would hold them.
std::vector<int> choose_pins(const TiedNumbering& numbering);

}  // namespace flexura::reduce
