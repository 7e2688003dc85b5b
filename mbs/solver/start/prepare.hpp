// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/start/model_source.hpp"
#include "mbs/solver/start/start.hpp"
#include "mbs/solver/start/state_file.hpp"

/// From a mechanism file to a mechanism that stands assembled at its start time, ready for any solver.
namespace flexura::mbs {

/// `notes` begin with those of reading.
struct PreparedMechanism : StartedMechanism {
  PreparedMechanism(MechanismFile read, std::shared_ptr<PreparationCache> of)
      : file(std::move(read)), cache(std::move(of)) {}
  MechanismFile file;
  double given_start_time = 0.0;              ///< of the mechanism file, whatever a state file says
  std::optional<Continuation> continuation;   ///< of the state file, where it holds one
  bool continuation_fits = true;              ///< its file has as many states of every kind as the mechanism
  std::shared_ptr<PreparationCache> cache;    ///< of its bodies; for further runs of the same source
  std::shared_ptr<const ModelSource> source;  ///< what it was made from, with this choice
  ModelChoice choice;
};

/// Moves what is assembled into static equilibrium; speeds stay, as of a rotor whose shaft sags.
void start_in_equilibrium(StartedMechanism& out);

/// Reads, builds, assembles on all levels and drops redundant constraint rows.  Throws input::InputError for
/// a bad file and for a mechanism that cannot be assembled, std::invalid_argument for a description that
/// cannot move.  A state file (state_file.hpp) sets the states that it names before the assembly, which
/// rather moves the others, and the time at which the run starts.  Without a cache it makes a new one.
PreparedMechanism prepare(std::shared_ptr<const ModelSource> source, const ModelChoice& choice = {},
                          const std::filesystem::path& state_file = {},
                          std::shared_ptr<PreparationCache> cache = nullptr);
/// Of a mechanism file with these overrides.
PreparedMechanism prepare(const std::filesystem::path& file, const std::vector<std::string>& overrides = {},
                          const std::filesystem::path& state_file = {},
                          std::shared_ptr<PreparationCache> cache = nullptr);

}  // namespace flexura::mbs
