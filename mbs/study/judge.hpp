// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/study/estimate/norms.hpp"
#include "mbs/study/measurement.hpp"
#include "mbs/study/study_file.hpp"

/// From measured runs to the trade: errors, front, answers.
///
/// With |.| the norm of a quantity and y* the reference, the error of a choice is |y - y*| / |y*|, the
/// largest over the quantities.  The reference's own uncertainty is the sum over its checks of share |y_check
/// - y*| / |y*|; where it is not small against an error, that error is known only within it.
namespace flexura::results {
struct Run;
}

namespace flexura::study {

/// The quantities of a study in a run, each within its span of time; of those that are counted |y| - level.
/// Throws std::invalid_argument for what the run has not stored.
std::vector<Signal> read_signals(const StudyFile& study, const results::Run& run);

struct ErrorOf {
  double against_reference = 0.0, against_finest = 0.0;  ///< relative; infinite when the run did not complete
};

struct Row {
  const Choice* choice = nullptr;
  const Measurement* cost = nullptr;
  double price = 0.0;           ///< [s], what the study counts as cost
  std::vector<ErrorOf> errors;  ///< one for each quantity
  ErrorOf error;                ///< the largest
  std::size_t worst = 0;        ///< the quantity that has it
  /// What the run itself estimated (truncation and integrator), relative, the largest over the quantities;
  /// negative where it could not.
  double estimate = -1.0;
  /// There are sources of error that the run could not judge: its estimate is what the error is at least.
  bool is_at_least = false;
  bool on_front = false;

  /// Estimate over error; negative where there is none, where the reference's uncertainty hides the error, or where a
  /// source is unknown in which the reference differs (it has the same mesh).
  double effectivity = -1.0;
};

/// What the program chose by itself, beside the cheapest rung of the ladder that meets the same accuracy.
struct Chosen {
  double wanted = 0.0;
  const Row* row = nullptr;
  const Row* cheapest = nullptr;  ///< null where no rung meets it
  bool met() const { return row->error.against_reference <= wanted; }
  double cost_ratio() const { return cheapest ? row->price / cheapest->price : 0.0; }
};

struct Judgement {
  std::vector<Row> rows;            ///< as in the study's choices
  std::vector<double> uncertainty;  ///< of the reference, relative, one for each quantity
  double largest_uncertainty = 0.0;
  std::vector<Chosen> chosen;
  std::vector<std::string> answers;  ///< in words, to what [want] asks
  std::vector<std::string> notes;    ///< what a reader should know before believing the figures
};

/// Throws std::invalid_argument when the reference or a check did not run through, or a quantity is zero in
/// the reference (give scale).  `study` and `measured` must live as long as the result.
Judgement judge(const StudyFile& study, const Measurements& measured);

}  // namespace flexura::study
