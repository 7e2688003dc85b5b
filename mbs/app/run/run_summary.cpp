// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/run_summary.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "mbs/base/terminal/terminal.hpp"

namespace flexura::app {

using terminal::Align;
using terminal::number;

nlohmann::json summary_of(const mbs::PreparedMechanism& prepared, const mbs::RunResult& r) {
  const double simulated = r.state.t - prepared.options.start_time;
  return {{"method", r.method.empty() ? prepared.options.method : r.method},
          {"method_changes", r.method_changes},
          {"method_hint", r.method_hint},
          {"tolerance", prepared.options.tolerance},
          {"end_time", r.state.t},
          {"wall_time", r.wall_time},
          {"real_time_factor", simulated > 0.0 ? r.wall_time / simulated : 0.0},
          {"steps", r.counts.steps},
          {"evaluations", r.counts.evaluations},
          {"jacobians", r.counts.jacobians},
          {"error_failures", r.counts.error_failures},
          {"newton_failures", r.counts.newton_failures},
          {"switches", r.events.size()},
          {"energy_error", r.energy.error()},
          {"largest_energy_error", r.largest_energy_error},
          {"relative_energy_error", r.energy.relative_error()},
          {"work_in", r.energy.work_in},
          {"dissipated", r.energy.dissipated},
          {"peak_position_drift", r.peak_position_drift},
          {"peak_velocity_drift", r.peak_velocity_drift},
          {"redundant_constraints", prepared.redundant.size()}};
}

void print_summary(
    const std::vector<std::pair<std::string, std::pair<const mbs::PreparedMechanism*, mbs::RunResult>>>& runs,
    bool verbose) {
  std::vector<terminal::Column> columns = {{"run", Align::left}, {"t [s]"}, {"wall"},
                                           {"x real"},           {"steps"}, {"error [J]"},
                                           {"relative"},         {"drift"}};
  if (verbose) {
    for (const char* name : {"evaluations", "jacobians", "rejected", "newton failures", "switches"})
      columns.push_back({name});
  }
  terminal::Table table(columns);
  for (const auto& [name, run] : runs) {
    const auto& [prepared, r] = run;
    const double simulated = r.state.t - prepared->options.start_time;
    std::vector<std::string> row = {name,
                                    number(r.state.t, 6),
                                    terminal::duration(r.wall_time),
                                    simulated > 0.0 ? number(r.wall_time / simulated, 3) : "-",
                                    fmt::format("{}", r.counts.steps),
                                    number(r.energy.error(), 3),
                                    number(r.energy.relative_error(), 2),
                                    number(r.peak_position_drift, 2)};
    if (verbose) {
      const std::size_t counts[] = {static_cast<std::size_t>(r.counts.evaluations),
                                    static_cast<std::size_t>(r.counts.jacobians),
                                    static_cast<std::size_t>(r.counts.error_failures),
                                    static_cast<std::size_t>(r.counts.newton_failures), r.events.size()};
      for (const std::size_t count : counts) row.push_back(fmt::format("{}", count));
    }
    table.add_row(std::move(row));
  }
  fmt::print("{}", table.text(terminal::width(stdout), terminal::takes_colour(stdout)));
  fmt::print("x real: wall time per simulated time; error: of the energy balance\n");
}

}  // namespace flexura::app
