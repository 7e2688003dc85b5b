// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/bodies/preparation_cache.hpp"
#include "mbs/file/state_sets.hpp"
#include "mbs/mechanism/mechanism.hpp"

/// The mechanism file (TOML): bodies, markers, joints, forces, measures, runs.
namespace flexura::mbs {

/// The schema of the whole file; `solver` is what [solver] takes.
input::TableSchema mechanism_schema(input::TableSchema solver);

/// [run.NAME] set = ["body.rod.fidelity=rigid"]: to be read again with these overrides.
struct RunDescription {
  std::string name;
  std::vector<std::string> overrides;
};

/// Something in the file whose share in a run's error nothing in the program estimates.
struct BlindSpot {
  std::string kind;    ///< "elements", "plane", "link", "user_element"
  std::string name;    ///< of the body, marker or element
  std::string remedy;  ///< how the user can judge it; may be empty
  std::string key =
      {};  ///< that sets how many elements there are ("body.rod.beam.elements"), where a run can set it
  int elements = 0;  ///< how many
  /// Of a body that it holds together in a frame of its own, so that no other frame of the body says the same.
  bool has_own_frame = false;
};

struct MechanismFile {
  std::string name;                  ///< of the mechanism
  std::string source;                ///< the file's text
  MechanismDescription description;  ///< ready for Mechanism's constructor
  std::vector<std::string> outputs;  ///< wanted quantities, with * and ? as wildcards; empty: the usual ones
  std::vector<std::string> y;        ///< outputs of the linearised mechanism, likewise
  std::vector<RunDescription> runs;  ///< one without overrides when the file names none
  std::vector<std::string> notes;    ///< what the user should know: truncated bases, ...
  input::Section solver;             ///< checked [solver] table, for read_solver_options
  /// Of the file's own superelements and beams that have the key `fidelity`: whether it leaves the choice to the program
  /// (they are then built as fidelity_of() says).
  std::map<std::string, bool> leaves_fidelity_open = {};
  std::vector<BlindSpot> blind_spots = {};
  std::vector<StateSet> states = {};
  std::vector<std::string> deformable =
      {};  ///< the file's own superelements and beams, whatever their fidelity
};

/// Reads and checks the file with `overrides` applied ("body.rod.fidelity=rigid").  Superelement files are
/// sought beside it.  What the cache holds of their bodies' preparation is not computed again.  Throws
/// InputError.
MechanismFile read_mechanism(const std::filesystem::path& file, const input::TableSchema& solver,
                             const std::vector<std::string>& overrides = {},
                             PreparationCache* cache = nullptr);

}  // namespace flexura::mbs
