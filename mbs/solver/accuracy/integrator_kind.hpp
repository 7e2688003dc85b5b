// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/solver/accuracy/options.hpp"

/// What is to be known of an integrator before one is made, and without one.
namespace flexura::mbs {

/// Their names in C++; `automatic` leaves the choice to the program.
enum class Method { automatic, ida, radau, generalised_alpha, runge_kutta, kinematics, quasi_statics, ked };

struct IntegratorKind {
  const char* name;  ///< as the user says it: solver.method
  const char* doc;   ///< completes "name = "
  Method method;
  /// It integrates a motion; else it finds one state after the other, each for itself, with no error of steps.
  bool integrates = true;
  /// States go over into each other, with the work done between them; between equilibria there is none.
  bool is_motion = true;
  /// It solves for positions and multipliers at once, which constraints that lose rank for an instant hold up: a few
  /// explicit steps lead across.
  bool is_implicit = false;
  /// For any mechanism, with error control: what a run may change to by itself (method_watch.hpp).
  bool is_for_all = false;
  bool takes_fixed_steps = false;
  /// The error of the motion goes with the tolerance to this power, that with a fixed step with its length to that
  /// one; 0: nothing is known of it.
  double power_of_tolerance = 0.0, power_of_step = 0.0;
  /// At most so many of its steps, which follow one another closely, are one of an equation of order five for their error,
  /// as far as one polynomial tells them; 1 where its own steps are as long.
  int steps_of_error = 1;
  /// What a matrix costs beside its derivatives, in those of a real one; an evaluation, in those of a residual, with
  /// and without constraints: a number and one for each `n^2 / 1500` (MethodWatch).
  double matrix = 1.0;
  double evaluation = 1.0, constrained_evaluation = 1.0, constrained_factor = 0.0;
};

/// All of them; mbs/solver/run/make_integrator.cpp makes them.
const std::vector<IntegratorKind>& integrator_kinds();
/// Throws std::invalid_argument for a name that is none.
const IntegratorKind& kind_of(const SolverOptions& options);
const IntegratorKind& kind_of(const std::string& method);
/// "runge_kutta" or "generalised_alpha": those that satisfy `is`.
std::string names_of_kinds(bool IntegratorKind::*is);

}  // namespace flexura::mbs
