// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <iosfwd>

#include "reduce/part/part_input.hpp"

namespace flexura::reduce {

/// Whether the format is one of decks, which have sets and ties to choose interfaces from.
bool is_deck(PartFormat format);

/// `flexura reduce --list-faces deck.bdf`: elements, materials, sets and ties of a deck, with a part file to copy.  Numbers
/// are as in the deck.
void print_deck(const std::filesystem::path& deck, PartFormat format, std::ostream& out);

}  // namespace flexura::reduce
