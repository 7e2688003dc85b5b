// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include "mesh/import/abaqus/abaqus_deck.hpp"

/// *MATERIAL and its options.
namespace flexura::mesh::abaqus {

/// Takes *MATERIAL, *DENSITY, *ELASTIC and *DAMPING into a deck.  A material ends at the next card that is no option of one.  What
/// contradicts itself (rows for several temperatures, options given twice) is told in Deck::otherwise.
class MaterialReader {
 public:
  /// `name` as the deck first spelt it.  Throws std::invalid_argument, naming file and line, as the next.
  void start(const Keyword& k, const std::string& name, Deck& deck);
  /// True where the card is one that was read.
  bool take(const Keyword& k, Deck& deck);

 private:
  void note_twice(const Keyword& k, Deck& deck);
  int at_ = -1;                           ///< place in Deck::materials, -1 outside of a material
  std::map<std::string, Where> started_;  ///< by name in capitals
  std::map<std::string, Where> given_;    ///< options of this material
};

}  // namespace flexura::mesh::abaqus
