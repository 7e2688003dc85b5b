// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/study/estimate/norms.hpp"

/// The study file (TOML): which choices are tried on which mechanism, and what accuracy means.
namespace flexura::study {

/// A part that the study reduces itself, so that mesh and modes can be choices.
struct Part {
  std::string name;
  std::filesystem::path file;
  std::vector<std::string> bodies;  ///< of the mechanism that take its superelement
  std::vector<std::string> set;     ///< overrides of the part file for all choices
};

/// One way to run the model: overrides of the mechanism file and of the part files.
struct Choice {
  std::string name;
  std::vector<std::string> set;
  std::map<std::string, std::vector<std::string>> part_set;  ///< by the part's name
  /// The program is to choose for this accuracy: no rung of the ladder, but compared with its cheapest.
  double wanted = 0.0;
};

/// A coarser neighbour of the reference; their difference measures what the reference has not resolved.
struct Check {
  Choice choice;       ///< the reference with this coarsened
  double share = 1.0;  ///< uncertainty per difference: 1, or 1 / (ratio^order - 1) by Richardson
};

struct WantedQuantity {
  std::string name;   ///< of the quantity in the results
  std::string label;  ///< in tables
  Norm norm = Norm::max;
  double from = 0.0, to = 0.0;  ///< [s]; to <= from: the whole run
  double level = 0.0;           ///< of a count: what |y| has to rise above
  double scale = 0.0;           ///< errors are divided by this instead of the reference's size; 0: by that
};

/// A quantity that the choices are compared by, in place of their errors.
struct Goal {
  std::size_t quantity = 0;  ///< of StudyFile::quantities
  bool is_least = true;      ///< the least is the best, not the greatest
};

struct StudyFile {
  std::string name;
  std::filesystem::path file, mechanism, cache;
  std::string run;               ///< of the mechanism file; "" for its only one
  std::vector<std::string> set;  ///< for all choices
  int repeats = 3;
  bool times_estimates = false;  ///< runs are timed with the estimates of their errors
  double time_limit = 0.0;       ///< [s] for one run
  std::vector<Part> parts;
  std::vector<Choice> choices;  ///< from coarse to fine: the last one is the finest
  Choice reference;
  std::vector<Check> checks;
  std::vector<WantedQuantity> quantities;
  bool cpu_is_cost = false;  ///< the front is made of CPU time, not of wall time
  std::vector<double> accuracies, times;

  /// With goals the choices are designs: their values are compared, nothing is timed, and there is no reference.
  std::vector<Goal> goals;
  std::vector<Choice>
      finer;  ///< each choice once more, solved more accurately; none: the values' errors are unknown
  bool compares_designs() const { return !goals.empty(); }
};

/// For the reference page.
input::TableSchema study_schema();

/// Reads and checks a study file with `overrides` applied.  Throws input::InputError: besides what the schema
/// refuses, an axis without choices, a part that no body takes, an override of a part that is not there, ...
StudyFile read_study(const std::filesystem::path& file, const std::vector<std::string>& overrides = {});

}  // namespace flexura::study
