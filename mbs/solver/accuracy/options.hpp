// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/schema.hpp"

/// What the user may say about a dynamic run: the table [solver] of a mechanism file.
namespace flexura::mbs {

struct Scales;

struct SolverOptions {
  std::string method = "ida";  ///< the integrator, one of those in integrator_kind.cpp
  double start_time = 0.0;     ///< s
  double end_time = 1.0;       ///< s
  double stop_time = 0.0;      ///< s; stop cleanly after the step that reaches it, to go on later; 0: never
  double output_step = 0.01;   ///< s; rows stand at start_time + k output_step, and at end_time
  /// Relative error allowed in one step.  The absolute part is tolerance * absolute_factor times the typical
  /// size of the state (Equations::position_scale, velocity_scale).
  double tolerance = 1e-6;
  double absolute_factor = 1e-2;
  int max_order = 5;        ///< of BDF; 2 is stable for undamped vibration of any frequency
  double rho_inf = 0.8;     ///< of generalised_alpha: share of vibration left at infinite frequency
  double first_step = 0.0;  ///< s; 0 lets the integrator choose
  double min_step = 0.0;    ///< s; 0: 1e-12 of the run, of ida 1e-15
  double max_step = 0.0;    ///< s; 0: a tenth of the run, of fixed steps none
  double fixed_step = 0.0;  ///< s; 0: variable. Not for ida
  int max_steps = 0;        ///< steps allowed in a run; 0: no bound
  bool quasi_static_start =
      false;  ///< elastic coordinates start where their loads hold them (quasi_static_start.hpp)
  bool store_states = false;  ///< write all states into the results file
  /// Nobody said `method`: the run may change between ida and radau where steps collapse (method_watch.hpp).
  bool method_is_open = false;
  /// Of the mechanism (scales.hpp); without them lengths and angles count as in a mechanism of 1 m.
  std::shared_ptr<const Scales> scales = nullptr;

  /// The bound on an integrator's steps [s].
  double longest_step() const;
};

/// Schema of [solver], for the mechanism file and its reference page.
input::TableSchema solver_schema();

/// Options from a checked [solver] table.  Throws InputError where keys contradict each other (end before
/// start).
SolverOptions read_solver_options(const input::Section& section);

}  // namespace flexura::mbs
