// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/library/simulation.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace flexura::mbs {
namespace {

std::string word_of(Method method, const Mechanism& m) {
  if (method == Method::automatic) return has_deformation(m) ? "radau" : "ida";
  for (const IntegratorKind& kind : integrator_kinds())
    if (kind.method == method) return kind.name;
  throw std::invalid_argument("there is no such method; name one of Method");
}

}  // namespace

Simulation::Simulation(const Mechanism& m, const SimulationOptions& options) {
  started_.mechanism = std::make_unique<Mechanism>(m.description());
  SolverOptions& o = started_.options;
  o.method = word_of(options.method, *started_.mechanism);
  o.method_is_open = options.method == Method::automatic;
  o.tolerance = options.tolerance;
  o.end_time = options.end_time;
  o.max_step = options.max_step;
  o.fixed_step = options.fixed_step;
  o.output_step = 0.0;  // the first advance() says
  for (const auto& [name, value] : {std::pair("tolerance", o.tolerance), std::pair("end_time", o.end_time)})
    if (!(value > 0.0) || !std::isfinite(value))
      throw std::invalid_argument(
          fmt::format("the {} of a simulation is {}; give a number above 0", name, value));
  for (const auto& [name, value] : {std::pair("max_step", o.max_step), std::pair("fixed_step", o.fixed_step)})
    if (!(value >= 0.0) || !std::isfinite(value))
      throw std::invalid_argument(
          fmt::format("the {} of a simulation is {}; give a time, or 0 for none", name, value));
  if (o.fixed_step > 0.0 && (o.method_is_open || !kind_of(o).takes_fixed_steps))
    throw std::invalid_argument(fmt::format("a fixed step goes with {}; name one of them, or leave it out",
                                            names_of_kinds(&IntegratorKind::takes_fixed_steps)));
  started_.state = started_.mechanism->initial_state();
  assemble_start(started_, {started_.mechanism->given_positions(), started_.mechanism->given_velocities()});
  scratch_ = started_.mechanism->make_scratch();
}

void Simulation::advance(double step) {
  SolverOptions& o = started_.options;
  if (!(step > 0.0) || !std::isfinite(step))
    throw std::invalid_argument(fmt::format("a simulation goes on by a time above 0, not by {} s", step));
  if (o.output_step == 0.0) o.output_step = step;
  const double rows = std::round(step / o.output_step);
  if (rows < 1.0 || std::abs(step / o.output_step - rows) > 1e-6)
    throw std::invalid_argument(fmt::format(
        "the first step was {} s, and {} s is no multiple of it; take the least of all steps first",
        o.output_step, step));
  for (double left = rows; left > 0.5; left -= 1.0) {
    if (ahead_.empty()) run_until(started_.state.t + left * o.output_step);
    if (ahead_.empty() && !ended_because_.empty()) throw std::runtime_error(ended_because_);
    if (ahead_.empty())
      throw std::runtime_error(
          fmt::format("the simulation is at its end, {} s; give it a later end_time", started_.state.t));
    started_.state = std::move(ahead_.front().state);
    started_.v_dot = std::move(ahead_.front().v_dot);
    energy_ = ahead_.front().energy;
    ahead_.pop_front();
  }
}

void Simulation::run_until(double t) {
  if (is_over_) return;
  SolverOptions o = started_.options;
  // A clean stop behind the rows that are asked for; the run that goes on from it is the same to the bit.
  if (t < o.end_time * (1.0 - 1e-12)) o.stop_time = t * (1.0 + 1e-12);
  RunCallbacks callbacks;
  bool is_start = !continuation_;
  callbacks.row = [&](const State& s, const Eigen::VectorXd& v_dot, const EnergyAccount& energy) {
    if (!is_start) ahead_.push_back({s, v_dot, energy});
    is_start = false;
  };
  RunResult result = continuation_ ? run(*started_.mechanism, *continuation_, o, callbacks)
                                   : run(*started_.mechanism, started_.state, started_.v_dot, o, callbacks);
  is_over_ = !result.stopped_as_told;
  if (is_over_ && !result.complete) ended_because_ = result.stopped_because;
  continuation_ = std::move(result.continuation);
}

double Simulation::output(const std::string& name) const {
  if (places_.empty()) {
    const std::vector<OutputInfo> infos = started_.mechanism->quantities();
    for (std::size_t i = 0; i < infos.size(); ++i) places_.emplace(infos[i].name, static_cast<int>(i));
  }
  const auto place = places_.find(name);
  if (place == places_.end())
    throw std::invalid_argument(
        fmt::format("there is no quantity \"{}\"; take one that Mechanism::quantities() names", name));
  Eigen::VectorXd value(1);
  started_.mechanism->evaluate({place->second}, started_.state, started_.v_dot, *scratch_, value);
  return value(0);
}

}  // namespace flexura::mbs
