// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "mbs/app/commands.hpp"
#include "mbs/app/run/mechanism_runs.hpp"
#include "mbs/app/run/state_table.hpp"
#include "mbs/base/files/output.hpp"
#include "mbs/base/terminal/terminal.hpp"
#include "mbs/solver/start/state_file.hpp"

namespace flexura::app {
namespace {

using terminal::Align;
using terminal::number;

struct Arguments : MechanismArguments {
  std::string save_state;
  bool json = false;
};

// Positive while their switches stay where they are (n_root).
Eigen::VectorXd switching_functions(const mbs::PreparedMechanism& p) {
  Eigen::VectorXd values(p.mechanism->sizes().n_root);
  const auto scratch = p.mechanism->make_scratch();
  p.mechanism->roots(p.state, *scratch, values);
  return values;
}

nlohmann::json to_json(const NamedRun& run) {
  using nlohmann::json;
  const mbs::PreparedMechanism& p = run.prepared;
  const mbs::Mechanism& m = *p.mechanism;
  const mbs::Sizes n = m.sizes();
  json out = run_json(run);
  json &positions = out["positions"] = json::array(), &velocities = out["velocities"] = json::array(),
       &multipliers = out["multipliers"] = json::array();
  for (int i = 0; i < n.n_p; ++i)
    positions.push_back({{"name", m.name_of_position(i)}, {"value", p.state.p(i)}});
  for (int i = 0; i < n.n_v; ++i)
    velocities.push_back(
        {{"name", m.name_of_velocity(i)}, {"value", p.state.v(i)}, {"acceleration", p.v_dot(i)}});
  for (int i = 0; i < n.n_lambda; ++i)
    multipliers.push_back({{"name", m.name_of_constraint(i)}, {"value", p.state.lambda(i)}});
  json &dynamic = out["dynamic"] = json::array(), &algebraic = out["algebraic"] = json::array(),
       &switches = out["switches"] = json::array();
  for (int i = 0; i < n.n_dyn; ++i)
    dynamic.push_back({{"name", m.name_of_dynamic(i)}, {"value", p.state.c(i)}, {"is_held", m.is_held(i)}});
  for (int i = 0; i < n.n_alg; ++i)
    algebraic.push_back({{"name", m.name_of_algebraic(i)}, {"value", p.state.a(i)}});
  const Eigen::VectorXd functions = switching_functions(p);
  for (int i = 0; i < n.n_root; ++i)
    switches.push_back({{"name", m.name_of_root(i)},
                        {"value", p.state.root[static_cast<std::size_t>(i)]},
                        {"function", functions(i)}});
  out["iterations"] = p.assembly.iterations;
  out["position_residual"] = p.assembly.position_residual;
  out["velocity_residual"] = p.assembly.velocity_residual;
  return out;
}

int print_assembled(const Arguments& arguments, const terminal::Verbosity& verbosity) {
  files::Claims claims;
  claims.add(arguments.save_state);
  std::vector<NamedRun> runs = prepare_runs(arguments);
  if (!arguments.save_state.empty()) {
    const mbs::PreparedMechanism& p = only_run(runs, arguments, "--save-state").prepared;
    mbs::write_state(arguments.save_state, *p.mechanism, p.file.name, p.state);
  }
  if (arguments.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const NamedRun& run : runs) list.push_back(to_json(run));
    print_json("assembled", runs, list);
    return 0;
  }
  if (verbosity.quiet) return 0;
  for (const NamedRun& run : runs) {
    const mbs::PreparedMechanism& p = run.prepared;
    const mbs::Sizes n = p.mechanism->sizes();
    const bool colour = terminal::takes_colour(stdout);
    fmt::print("{}\n\n", heading(run));
    terminal::Table positions({{"position", Align::left}, {"value"}});
    const StateText text(p);
    for (int i = 0; i < n.n_p; ++i) positions.add_row({text.position_name(i), text.position(i, 9)});
    terminal::Table velocities({{"velocity", Align::left}, {"value"}, {"derivative, per s"}});
    for (int i = 0; i < n.n_v; ++i)
      velocities.add_row({text.velocity_name(i), text.velocity(i, 9), text.acceleration(i, 9)});
    fmt::print("{}\n{}\n", positions.text(terminal::width(stdout), colour),
               velocities.text(terminal::width(stdout), colour));
    if (n.n_lambda > 0) {
      terminal::Table multipliers({{"constraint", Align::left}, {"multiplier"}});
      for (int i = 0; i < n.n_lambda; ++i)
        multipliers.add_row({text.multiplier_name(i), text.multiplier(i, 9)});
      fmt::print("{}\n", multipliers.text(terminal::width(stdout), colour));
    }
    if (n.n_dyn + n.n_alg > 0) {
      const mbs::Mechanism& m = *p.mechanism;
      terminal::Table others({{"state", Align::left}, {"kind", Align::left}, {"value"}});
      for (int i = 0; i < n.n_dyn; ++i)
        others.add_row({text.other_name(m.name_of_dynamic(i)), m.is_held(i) ? "held" : "dynamic",
                        number(p.state.c(i), 9)});
      for (int i = 0; i < n.n_alg; ++i)
        others.add_row({text.other_name(m.name_of_algebraic(i)), "algebraic", number(p.state.a(i), 9)});
      fmt::print("{}\n", others.text(terminal::width(stdout), colour));
    }
    if (n.n_root > 0) {
      terminal::Table switches({{"switch", Align::left}, {"position"}, {"switching function"}});
      const Eigen::VectorXd functions = switching_functions(p);
      for (int i = 0; i < n.n_root; ++i)
        switches.add_row({p.mechanism->name_of_root(i),
                          fmt::format("{}", p.state.root[static_cast<std::size_t>(i)]),
                          number(functions(i), 9)});
      fmt::print("{}\n", switches.text(terminal::width(stdout), colour));
    }
    fmt::print("assembled in {} steps; residuals {} (position), {} (velocity)\n", p.assembly.iterations,
               number(p.assembly.position_residual, 2), number(p.assembly.velocity_residual, 2));
    for (const std::string& note : p.notes) terminal::say(stdout, "note: " + note);
  }
  return 0;
}

}  // namespace

terminal::Command assemble_command() {
  return {"assemble", "close a mechanism's loops and print where it stands",
          [](terminal::Options& options, const terminal::Verbosity& verbosity) -> std::function<int()> {
            auto a = std::make_shared<Arguments>();
            declare_mechanism(options, *a);
            options.option("--save-state", a->save_state, "FILE", "write the assembled states there")
                .flag("--json", a->json, "print JSON (SI units)")
                .example("flexura assemble engine.toml",
                         "positions, velocities, accelerations, multipliers, states of controls");
            return [a, &verbosity] { return print_assembled(*a, verbosity); };
          }};
}

}  // namespace flexura::app
