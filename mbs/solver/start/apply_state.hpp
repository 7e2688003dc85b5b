// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/file/state_sets.hpp"
#include "mbs/solver/start/start.hpp"
#include "mbs/solver/start/state_file.hpp"

namespace flexura::mbs {

/// Puts the set's values into `s`, a state of `m` at the time it holds, and the set's time; marks in `given` what it
/// named.  `deformable`: bodies that may deform (MechanismFile::deformable), whose states may be missing.  Returns notes on deformation that does not fit the bodies' fidelity.  Throws input::InputError for states that
/// the mechanism does not have and for values of a wrong unit, what read_state() throws.
std::vector<std::string> apply_state(const StateSet& set, const std::vector<std::string>& deformable,
                                     const Mechanism& m, State& s, GivenState& given);

/// Likewise of a state file (--from-state).
std::vector<std::string> apply_state(const std::filesystem::path& path,
                                     const std::vector<std::string>& deformable, const Mechanism& m, State& s,
                                     GivenState& given);

}  // namespace flexura::mbs
