// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/accuracy/integrator_kind.hpp"

#include <fmt/format.h>

#include <stdexcept>

namespace flexura::mbs {

const std::vector<IntegratorKind>& integrator_kinds() {
  static const std::vector<IntegratorKind> kinds = {
      {.name = "ida",
       .doc = "SUNDIALS IDA (BDF, variable step and order) on the stabilised index-2 form",
       .method = Method::ida,
       .is_implicit = true,
       .is_for_all = true,
       .power_of_tolerance = 5.0 / 6.0,
       .power_of_step = 5.0 / 6.0,
       .steps_of_error = 6},
      {.name = "radau",
       .doc = "Radau IIA of order 5 on the same form, L-stable: high frequencies decay, none grows",
       .method = Method::radau,
       .is_implicit = true,
       .is_for_all = true,
       .power_of_tolerance = 5.0 / 6.0,
       .power_of_step = 5.0 / 6.0,
       .matrix = 5.0},  // a real and a complex one
      {.name = "generalised_alpha",
       .doc = "order 2 on index 3 with numerical damping at high frequencies (rho_inf)",
       .method = Method::generalised_alpha,
       .is_implicit = true,
       .takes_fixed_steps = true,
       .power_of_tolerance = 2.0 / 3.0,
       .power_of_step = 2.0,
       .steps_of_error = 6},
      // An explicit stage solves for accelerations, by mass matrix and QR where there are constraints.
      {.name = "runge_kutta",
       .doc = "Dormand-Prince 5(4) with projection, explicit, for models that are not stiff",
       .method = Method::runge_kutta,
       .takes_fixed_steps = true,
       .power_of_tolerance = 1.0,
       .power_of_step = 5.0,
       .matrix = 0.0,
       .evaluation = 2.0,
       .constrained_evaluation = 3.0,
       .constrained_factor = 4.0},
      {.name = "kinematics",
       .doc = "positions, velocities, accelerations and drive forces where drives prescribe the whole "
              "motion; bodies "
              "deform as their loads and the inertia of that motion have them, without vibration "
              "(kineto-elastostatics), which accelerations and drive forces leave out",
       .method = Method::kinematics,
       .integrates = false},
      {.name = "ked",
       .doc = "kineto-elastodynamics where drives prescribe the whole motion: bodies vibrate about that of "
              "the undeformed "
              "mechanism, assembled at each position and linear in their deformation, which moves what hangs "
              "on them and does "
              "not act back on the drives' motion",
       .method = Method::ked,
       .integrates = false,
       .takes_fixed_steps = true},
      {.name = "quasi_statics",
       .doc = "an equilibrium at each output time",
       .method = Method::quasi_statics,
       .integrates = false,
       .is_motion = false},
  };
  return kinds;
}

const IntegratorKind& kind_of(const std::string& method) {
  for (const IntegratorKind& kind : integrator_kinds())
    if (method == kind.name) return kind;
  throw std::invalid_argument(fmt::format("unknown integrator \"{}\"", method));
}
const IntegratorKind& kind_of(const SolverOptions& options) {
  return kind_of(options.method);
}

std::string names_of_kinds(bool IntegratorKind::*is) {
  std::string text;
  for (const IntegratorKind& kind : integrator_kinds())
    if (kind.*is) text += fmt::format("{}\"{}\"", text.empty() ? "" : " or ", kind.name);
  return text;
}

}  // namespace flexura::mbs
