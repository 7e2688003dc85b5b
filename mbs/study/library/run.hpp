// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/library/builder.hpp"
#include "mbs/library/part_source.hpp"
#include "mbs/study/choice/choose.hpp"
#include "mbs/study/ledger/estimated_error.hpp"

/// A run of a mechanism made in C++ with its error, by sources; within an accuracy where one is asked for:
///
///     MechanismBuilder b;
///     auto arm = b.add("arm", Part{"arm.se.h5"});
///     ...
///     const study::Answer a = study::run(b, {.end_time = 2.0, .accuracy = 0.01, .outputs = {"tip"}});
///     a.choice.bodies.at("arm").fidelity;  // "modal"
///     a.values("tip");                     // of every row
///     for (const study::ErrorSource& s : a.ledger.sources) ...
namespace flexura::study {

struct Answer {
  mbs::ModelChoice choice;           ///< with which it ran
  std::vector<std::string> reasons;  ///< for it, a line for each body, restart and tolerance
  ErrorEstimate ledger;              ///< what the run says about its own error
  std::string missed;                ///< where the accuracy is not met, or not known to be; else empty
  std::vector<std::string> notes;    ///< what the user should know
  mbs::RunResult result;
  std::vector<RowOfRun> rows;
  mbs::PreparedMechanism prepared;

  std::vector<double> times() const;  ///< [s]
  /// Of every row, a quantity by its name [SI].  Throws std::invalid_argument.
  Eigen::VectorXd values(const std::string& quantity) const;
};

/// Throws what prepare() throws; a run that does not come to its end says so in result.stopped_because.
Answer run(const mbs::MechanismBuilder& mechanism, const mbs::RunSettings& settings,
           const mbs::RunCallbacks& callbacks = {});
/// The same of any source, a mechanism file among them (FileSource).
Answer run(const mbs::PreparedMechanism& prepared, const mbs::RunCallbacks& callbacks = {});

}  // namespace flexura::study
