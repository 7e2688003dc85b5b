// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/file/read_mechanism.hpp"
#include "mbs/solver/start/start.hpp"
#include "mbs/solver/start/state_file.hpp"

namespace flexura::mbs {

/// Puts the set's values into `s`, a state of `m` at the time it holds, and the set's time; marks in `given` what it
/// named.  Returns notes on deformation that does not fit the bodies' fidelity.  Throws input::InputError for states that
/// the mechanism does not have and for values of a wrong unit, what read_state() throws.
std::vector<std::string> apply_state(const StateSet& set, const MechanismFile& file, const Mechanism& m,
                                     State& s, GivenState& given);

/// Likewise of a state file (--from-state).
std::vector<std::string> apply_state(const std::filesystem::path& path, const MechanismFile& file,
                                     const Mechanism& m, State& s, GivenState& given);

}  // namespace flexura::mbs
