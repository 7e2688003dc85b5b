// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/accuracy/options.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mbs/solver/accuracy/integrator_kind.hpp"

namespace flexura::mbs {

double SolverOptions::longest_step() const {
  if (max_step > 0.0) return max_step;
  return fixed_step > 0.0 ? fixed_step : 0.1 * (end_time - start_time);
}

input::TableSchema solver_schema() {
  namespace in = input;
  in::TableSchema schema;
  schema.name = "solver";
  schema.doc = "How the equations of motion are integrated and how often results are written.";
  std::vector<std::string> methods;
  std::string docs;
  for (const IntegratorKind& kind : integrator_kinds()) {
    methods.emplace_back(kind.name);
    docs += fmt::format("{} = {}; ", kind.name, kind.doc);
  }
  schema.keys.push_back(in::choice(
      "method", methods,
      "integrator: " + docs +
          "without it radau where "
          "bodies deform (superelements, ancf), ida otherwise, and the run changes between these two where "
          "one of them stops or the other is three times as fast, which it looks at after 1000 steps (250 of "
          "more than 100 unknowns), 4000, 16000 ..., and to radau where twenty events (samples of a "
          "controller) "
          "leave ida fewer than 40 steps from one to the next; it says so at the end"));
  schema.keys.push_back(
      in::quantity("start_time", in::dim::time, "time at which the run begins").or_default("0 s"));
  schema.keys.push_back(
      in::quantity("end_time", in::dim::time, "time at which the run ends").or_default("1 s"));
  schema.keys.push_back(
      in::quantity("stop_time", in::dim::time,
                   "stop after the step that reaches this time, to go on later (--save-state, "
                   "--continue); 0 = run to end_time")
          .or_default("0 s"));
  schema.keys.push_back(
      in::quantity("output_step", in::dim::time,
                   "time between two rows of the results, interpolated by the integrator's own "
                   "polynomial: it does not bound the step")
          .or_default("10 ms")
          .above(0.0));
  schema.keys.push_back(in::quantity("tolerance", in::dim::none, "relative error allowed in one step")
                            .or_default("1e-6")
                            .at_least(1e-13)
                            .at_most(1e-1));
  schema.keys.push_back(
      in::quantity(
          "accuracy", in::dim::none,
          "wanted relative accuracy (rms) of all stored outputs, like \"1 %\": flexura simulate then "
          "chooses the tolerance, and fidelity and modes of every superelement that has no fidelity "
          "of its own; 0 = nothing is chosen")
          .or_default("0")
          .at_least(0.0)
          .at_most(1.0));
  schema.keys.push_back(
      in::quantity(
          "absolute_factor", in::dim::none,
          "the absolute error allowed is tolerance * absolute_factor times the largest displacement of the "
          "run so far (angles and modes counted by what they displace; at most the mechanism's length), for "
          "speeds the largest speed so far (at most 1 rad/s, and 1 m/s or one length of the mechanism in a "
          "second)")
          .or_default("0.01")
          .above(0.0));
  schema.keys.push_back(
      in::integer("max_order",
                  "highest order of BDF; 2 is stable for undamped vibration of any frequency, "
                  "higher orders are more accurate on smooth motion")
          .or_default("5")
          .at_least(1)
          .at_most(5));
  schema.keys.push_back(
      in::quantity("rho_inf", in::dim::none,
                   "of generalised_alpha: share of a vibration of infinite frequency that is "
                   "left after a step; 1 = no numerical damping, with constraints by a fixed_step only")
          .or_default("0.8")
          .at_least(0.0)
          .at_most(1.0));
  schema.keys.push_back(in::quantity("first_step", in::dim::time, "first step; 0 = the integrator chooses")
                            .or_default("0 s")
                            .at_least(0.0));
  schema.keys.push_back(
      in::quantity("min_step", in::dim::time,
                   "a run that needs smaller steps stops; 0: 1e-12 of the run, of ida 1e-15")
          .or_default("0 s")
          .at_least(0.0));
  schema.keys.push_back(in::quantity("max_step", in::dim::time,
                                     "longest step; 0 = a tenth of the run, with a fixed_step no bound")
                            .or_default("0 s")
                            .at_least(0.0));
  schema.keys.push_back(
      in::quantity("fixed_step", in::dim::time,
                   "fixed step of method " + names_of_kinds(&IntegratorKind::takes_fixed_steps) +
                       ", without error control, shorter only where it ends at an event; 0 = variable step")
          .or_default("0 s")
          .at_least(0.0));
  schema.keys.push_back(in::integer("max_steps", "a run that needs more steps stops; 0 = no bound")
                            .or_default("0")
                            .at_least(0));
  schema.keys.push_back(
      in::choice(
          "initial_deformation", {"none", "quasi_static"},
          "of flexible bodies: none where the loops allow it, so that they ring under their loads from the "
          "start; or the deformation that follows the loads and the motion without ringing")
          .or_default("none"));
  schema.keys.push_back(in::text(
      "initial_state", "name of the [state.NAME] to start from, or \"zero\"; without it the file's values"));
  schema.keys.push_back(
      in::flag("store_states", "write all states into the results file").or_default("false"));
  return schema;
}

SolverOptions read_solver_options(const input::Section& section) {
  SolverOptions o;
  if (section.has("method")) o.method = section.text("method");
  o.start_time = section.quantity("start_time");
  o.end_time = section.quantity("end_time");
  o.stop_time = section.quantity("stop_time");
  o.output_step = section.quantity("output_step");
  o.tolerance = section.quantity("tolerance");
  o.absolute_factor = section.quantity("absolute_factor");
  o.max_order = section.integer("max_order");
  o.rho_inf = section.quantity("rho_inf");
  o.first_step = section.quantity("first_step");
  o.min_step = section.quantity("min_step");
  o.max_step = section.quantity("max_step");
  o.fixed_step = section.quantity("fixed_step");
  o.max_steps = section.integer("max_steps");
  o.quasi_static_start = section.text("initial_deformation") == "quasi_static";
  o.store_states = section.flag("store_states");
  if (o.end_time < o.start_time)
    section.refuse("end_time", "must not be before start_time", "give a later end_time");
  if (o.stop_time != 0.0 && o.stop_time < o.start_time)
    section.refuse("stop_time", "must not be before start_time", "give a later stop_time, or 0 for none");
  // Steps that a run cannot take in a lifetime, or that are lost in the round-off of the time itself.
  const double duration = o.end_time - o.start_time,
               resolution = 16.0 * std::numeric_limits<double>::epsilon() *
                            std::max(std::abs(o.start_time), std::abs(o.end_time));
  // Below, products of times and numbers of usual size leave the range of normal numbers.
  constexpr double shortest = 1e-100;
  if (duration > 0.0 && duration < std::max(resolution, shortest))
    section.refuse(
        "end_time",
        fmt::format("leaves {:.2g} s after start_time, which is lost in the round-off of the time", duration),
        "give a later end_time, or times nearer to zero");
  const auto bound = [&](const char* key, double step, double most, const char* of_what) {
    if (step <= 0.0) return;
    if (step < duration / most)
      section.refuse(key,
                     fmt::format("makes {:.3g} {} of {:.6g} s; at most {:.0g} are possible", duration / step,
                                 of_what, duration, most),
                     fmt::format("give {:.2g} s or more, or an earlier end_time", duration / most));
    if (step < resolution && duration > 0.0)
      section.refuse(key, fmt::format("is lost in the round-off of the time, {:.2g} s", resolution),
                     "give a longer step, or times nearer to zero");
  };
  constexpr double most_rows = 1e8, most_steps = 1e10;
  bound("output_step", o.output_step, most_rows, "rows");
  bound("fixed_step", o.fixed_step, most_steps, "steps");
  bound("max_step", o.max_step, most_steps, "steps");
  bound("first_step", o.first_step, 1e15, "steps");
  if (o.fixed_step > 0.0 && !kind_of(o).takes_fixed_steps)
    section.refuse("fixed_step", o.method + " chooses its own steps",
                   "use method = " + names_of_kinds(&IntegratorKind::takes_fixed_steps));
  if (o.max_step > 0.0 && o.max_step < o.min_step)
    section.refuse("max_step", "must not be below min_step", "give a larger max_step, or 0 for no bound");
  if (o.max_step > 0.0 && o.fixed_step > o.max_step)
    section.refuse("max_step",
                   fmt::format("{:g} s would shorten the fixed_step of {:g} s", o.max_step, o.fixed_step),
                   "take max_step away, or give a fixed_step that is not longer");
  return o;
}

}  // namespace flexura::mbs
