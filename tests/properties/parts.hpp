// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "mbs/superelement/superelement.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

/// Random parts as users write them: frames of beams, solids and sheets of decks, FlexData of few modes, matrices of another
/// program, with interfaces that keep any of their directions and any number of modes.
namespace flexura::properties {

struct RandomPart {
  std::string text;  ///< of the part file, and of the files beside it: what a failing case is repeated with
  std::string refused;  ///< why the part is no part; then there is no superelement
  superelement::Superelement superelement;
};

enum class Kind { beams, solids, shells, flexdata, matrices };
inline const char* name_of(Kind kind) {
  static constexpr const char* kNames[] = {"Beams", "Solids", "Shells", "FlexData", "Matrices"};
  return kNames[static_cast<int>(kind)];
}
inline void PrintTo(Kind kind, std::ostream* out) {
  *out << name_of(kind);
}
inline constexpr Kind kKinds[] = {Kind::beams, Kind::solids, Kind::shells, Kind::flexdata, Kind::matrices};

struct PartOptions {
  bool all_directions = false;  ///< every interface keeps all six
  int fewest_modes = 0;
};

/// Writes the part's files into the folder and reduces it.  Needs a linalg::Session.
RandomPart random_part(mbs::chance::Chance& chance, Kind kind, const test::Folder& folder,
                       const PartOptions& options = {});

}  // namespace flexura::properties
