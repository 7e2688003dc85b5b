// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/study/study_file.hpp"

/// Runs the choices of a study in child processes and keeps what they cost in a cache of files named by
/// content: KEY.h5 (results) and KEY.json (measurements).  A study that was interrupted, or shared between
/// processes or machines with a common folder, goes on where the cache ends.  A file there that is not what was written is
/// made again, with a note.
namespace flexura::study {

struct Programs {
  std::filesystem::path flexura, reduce, mesh;
};

struct MeasureOptions {
  int jobs = 1;               ///< first runs side by side; times are then taken one run at a time
  int share = 1, shares = 1;  ///< run only every shares-th choice, beginning with number `share`
  bool fresh = false;         ///< forget what is in the cache
  bool run_scripts = false;   ///< parts may name scripts
  std::function<void(std::string_view stage, double fraction)> progress;
  std::function<void(std::string_view words)> note;  ///< a sentence for the user, one at a time
};

/// What one choice cost.
struct Measurement {
  bool complete = false;
  std::string failure;            ///< why not, in the program's words
  std::vector<double> wall, cpu;  ///< [s], one for each timed run of the whole program
  double peak_memory = 0.0;       ///< [B], largest of them
  double reduce_wall = 0.0;       ///< [s] that the reduction of its parts took, once
  double solver_wall = 0.0;       ///< [s] of the first run, integration alone
  long steps = 0, evaluations = 0;
  double energy_error = 0.0;  ///< relative, of the run's energy balance
  std::filesystem::path results;

  double median_wall() const;
  double median_cpu() const;
};

struct Measurements {
  std::vector<Measurement> choices;
  Measurement reference;
  std::vector<Measurement> checks;
  std::vector<Measurement> finer;  ///< as StudyFile::finer; designs have no reference and no checks
  bool whole = true;               ///< false when only a share was run
};

double median(std::vector<double> values);

/// Throws input::InputError for what a program refuses as bad input, naming the choice, and
/// std::runtime_error when a program cannot be started or the cache cannot be written.  A run that stops
/// early or takes too long is a result, not an error.
Measurements measure(const StudyFile& study, const Programs& programs, const MeasureOptions& options);

}  // namespace flexura::study
