// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/run/run.hpp"

/// States as text (JSON), every value by the state's name and with all its digits:
///
///     { "format": "flexura state", "version": 1, "mechanism": "...", "time": 0.25,
///       "positions":   { "shaft.angle": 0.61, ... },      "velocities": { "shaft.speed": 12.5, ... },
///       "dynamic":     { ... }, "algebraic": { ... },     "multipliers": { ... }, "switches": [ ... ],
///       "continuation": { "method": "ida", "next_row": 26, "v_dot": [...], "energy": [...],
///                         "history": [...] } }
///
/// All but the first two are optional: a file that names some states only is a state set, which changes these
/// and leaves the others as they are.
namespace flexura::mbs {

/// Writes beside and renames.  Throws std::runtime_error where the file cannot be written.
void write_state(const std::filesystem::path& path, const Equations& eq, const std::string& mechanism,
                 const State& s, const Continuation* continuation = nullptr);

/// What a file changed of a state.
struct StateChange {
  std::vector<bool> position, velocity;  ///< entries of p and of v that the file names
  std::optional<Continuation> continuation;
  bool continuation_fits = true;  ///< the file has as many states of every kind as the mechanism
  bool is_whole =
      false;  ///< the file is of a mechanism, as write_state() writes it: what it lacks, that lacked
  std::vector<std::string> left_out;  ///< names of deformation that the mechanism does not have
};

/// Of a name that the mechanism does not have: true where another fidelity of one of its bodies may have it.
using OfDeformation = std::function<bool(const std::string&)>;

/// Puts the file's values into `s`; multipliers of other constraints are passed over, as they follow from the rest.
/// Throws std::invalid_argument, one sentence, for a file that is none and for a state that the mechanism does not
/// have ("did you mean ...?") unless it is `of_deformation`.
StateChange read_state(const std::filesystem::path& path, const Equations& eq, State& s,
                       const OfDeformation& of_deformation = {});

}  // namespace flexura::mbs
