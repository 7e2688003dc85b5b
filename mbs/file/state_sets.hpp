// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"

namespace flexura::mbs {

/// [state.NAME]: values of states that a run may start from (solver.initial_state).  What a set does not name stays as the
/// mechanism file has it.
struct StateSet {
  struct Value {
    std::string state;  ///< "hinge.angle", "rod.mode_1_rate"
    input::Measured value;
    std::string where;  ///< "m.toml:12: state.bent.values.hinge.angle", for messages
  };
  std::string name;
  std::string where;                ///< "m.toml:10: state.bent"
  bool zero = false;                ///< every state is zero first, orientations those of the markers
  std::filesystem::path file = {};  ///< a state file (state_file.hpp) whose states come next; empty: none
  std::vector<Value> values = {};   ///< come last
  std::optional<double> time =
      {};  ///< [s] at which a run starts from it; without it the file's, or solver.start_time
  bool equilibrium = false;  ///< positions move into static equilibrium from there; speeds stay
};

/// The name of the set that needs no table: every state zero.
inline constexpr const char* kZeroState = "zero";

input::TableSchema state_schema();

/// The sets of a mechanism file in its order.  Throws InputError.
std::vector<StateSet> read_state_sets(const input::Section& root);

/// The set of this name.  Throws InputError, beginning with `where`, where there is none.
StateSet find_state_set(const std::vector<StateSet>& sets, const std::string& name, const std::string& where);

}  // namespace flexura::mbs
