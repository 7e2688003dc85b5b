// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/library/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mbs/solver/algebra/accelerations.hpp"
#include "mbs/solver/start/apply_state.hpp"

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
  SolverOptions& o = started_.options;
  o.method = word_of(options.method, m);
  o.method_is_open = options.method == Method::automatic;
  o.tolerance = options.tolerance;
  o.end_time = options.end_time;
  o.max_step = options.max_step;
  o.fixed_step = options.fixed_step;
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
  assemble(m, Eigen::VectorXd::Zero(m.n_inputs()));
}

Simulation::Simulation(const PreparedMechanism& file, const SimulationOptions& options)
    : Simulation(Mechanism(file.file.description), options) {
  sets_ = file.file.states;
  deformable_ = file.file.deformable;
  if (file.file.solver.has("initial_state")) start_from(file.file.solver.text("initial_state"));
}

std::vector<std::string> Simulation::state_sets() const {
  std::vector<std::string> names = {kZeroState};
  for (const StateSet& set : sets_) names.push_back(set.name);
  return names;
}

void Simulation::add_state_set(const StateSet& set) {
  if (set.name == kZeroState)
    throw std::invalid_argument(
        fmt::format("\"{}\" is the set with every state zero; choose another name", kZeroState));
  std::erase_if(sets_, [&](const StateSet& other) { return other.name == set.name; });
  sets_.push_back(set);
}

void Simulation::start_from(const std::string& name) {
  const StateSet set = find_state_set(sets_, name, "start_from");
  StartedMechanism anew;
  anew.options = started_.options;
  anew.mechanism = std::make_unique<Mechanism>(started_.mechanism->description());
  const Mechanism& m = *anew.mechanism;
  GivenState given;
  std::vector<std::string> notes;
  const auto apply = [&](double t) {
    given = {m.given_positions(), m.given_velocities(), false};
    anew.state = m.initial_state(t);
    anew.state.u = started_.state.u;
    notes = apply_state(set, deformable_, m, anew.state, given);
    return anew.state.t;
  };
  // Drives stand where they are at the set's time.
  if (const double t = apply(0.0); t != 0.0) apply(t);
  anew.options.start_time = anew.state.t;
  if (!(anew.state.t < anew.options.end_time))
    throw std::invalid_argument(
        fmt::format("state set \"{}\" is at {} s, and the simulation ends at {} s; give it a later end_time",
                    name, anew.state.t, anew.options.end_time));
  assemble_start(anew, given);
  if (set.equilibrium) start_in_equilibrium(anew);
  anew.notes.insert(anew.notes.begin(), notes.begin(), notes.end());
  started_ = std::move(anew);
  scratch_ = started_.mechanism->make_scratch();
  run_.reset();
  energy_ = {};
  length_ = 0.0;
  places_.clear();
}

// At its start, with `u` added to its inputs.
void Simulation::assemble(const Mechanism& m, const Eigen::VectorXd& u) {
  StartedMechanism anew;
  anew.options = started_.options;
  anew.mechanism = std::make_unique<Mechanism>(m.description());
  anew.state = anew.mechanism->initial_state();
  anew.state.u = u;
  assemble_start(anew, {anew.mechanism->given_positions(), anew.mechanism->given_velocities()});
  started_ = std::move(anew);
  scratch_ = started_.mechanism->make_scratch();
}

void Simulation::advance(double step) {
  const double t = time(), end = started_.options.end_time;
  if (!(step > 0.0) || !std::isfinite(step))
    throw std::invalid_argument(fmt::format("a simulation goes on by a time above 0, not by {} s", step));
  if (run_ && !run_->stopped_because().empty()) throw std::runtime_error(run_->stopped_because());
  if (step != length_) {
    from_ = t;
    length_ = step;
    n_ = 0.0;
  }
  constexpr double kNearly = 1e-6;  // of a step
  double goal = from_ + (n_ + 1.0) * step;
  if (goal > end + kNearly * step)
    throw std::runtime_error(
        fmt::format("the simulation ends at {} s, before {} s; give it a later end_time", end, goal));
  if (goal > end - kNearly * step) goal = end;
  if (!run_) {
    // What elements read may have changed since the mechanism was assembled.
    AccelerationSolver(*started_.mechanism).solve(started_.state, started_.v_dot);
    // Nobody asks for rows.
    SolverOptions options = started_.options;
    options.output_step = options.longest_step();
    run_ = std::make_unique<GuidedRun>(*started_.mechanism, started_.state, started_.v_dot, options);
  }
  n_ += 1.0;
  const std::size_t changes = run_->method_changes().size();
  const bool goes_on = run_->go_to(goal);
  for (std::size_t i = changes; i < run_->method_changes().size(); ++i)
    started_.notes.push_back("method changed " + run_->method_changes()[i]);
  started_.state = run_->state();
  started_.v_dot = run_->accelerations();
  energy_ = run_->energy();
  if (!goes_on) throw std::runtime_error(run_->stopped_because());
}

void Simulation::set_input(const std::string& name, double value) {
  const std::vector<InputDescription>& inputs = started_.mechanism->description().inputs;
  const auto input = std::ranges::find(inputs, name, &InputDescription::name);
  if (input == inputs.end()) {
    std::vector<std::string> names;
    for (const InputDescription& one : inputs) names.push_back("\"" + one.name + "\"");
    throw std::invalid_argument(fmt::format(
        "there is no input \"{}\"; {}", name,
        names.empty()
            ? "declare it, MechanismBuilder::input() or [input." + name + "], and let formulas read it"
            : fmt::format("there {} {}", names.size() == 1 ? "is" : "are", fmt::join(names, ", "))));
  }
  if (!std::isfinite(value))
    throw std::invalid_argument(fmt::format("input \"{}\" is set to {}; give a finite number", name, value));
  if (input->value->reads_time())
    throw std::invalid_argument(fmt::format(
        "input \"{}\" follows \"{}\", a formula of t, and cannot be set; declare it with a number, "
        "and let what reads it add the formula",
        name, input->value->text()));
  const auto i = input - inputs.begin();
  Eigen::VectorXd u = started_.state.u;
  u(i) = value - started_.mechanism->input_value(static_cast<int>(i), time());
  if (!run_) return assemble(*started_.mechanism, u);
  run_->set_inputs(u);
  started_.state.u = u;
  AccelerationSolver(*started_.mechanism).solve(started_.state, started_.v_dot);
}

void Simulation::begin_anew() {
  if (run_) run_->begin_anew();
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
