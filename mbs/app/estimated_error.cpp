// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/estimated_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/terminal/terminal.hpp"

namespace flexura::app {
namespace {

std::string percent(double fraction) {
  return terminal::number(100.0 * fraction, 2) + " %";
}

}  // namespace

std::string estimated_error_line(const study::TruncationEstimate* truncation, const mbs::RunResult& result) {
  const double integrator = std::abs(result.energy.relative_error());
  std::string parts, largest = "the integrator";
  double error = integrator;
  if (truncation && truncation->worst >= 0) {
    error += truncation->error;
    const auto& output = truncation->outputs[static_cast<std::size_t>(truncation->worst)];
    const study::SourceEstimate& most = truncation->by_body.front();
    if (truncation->error > integrator)
      largest = fmt::format("{}'s dropped modes, in {}", most.body, output.name);
    for (const study::SourceEstimate& source : truncation->by_body)
      parts += fmt::format(", modes of {} {}", source.body, percent(source.error));
  } else if (!truncation) {
    parts = ", no mode dropped";
  }
  return fmt::format("estimated error {} (rms, worst output): integrator {} (energy balance){}; largest: {}",
                     percent(error), percent(integrator), parts, largest);
}

nlohmann::json estimated_error_json(const study::TruncationEstimate* truncation,
                                    const mbs::RunResult& result) {
  nlohmann::json out = {{"integrator", std::abs(result.energy.relative_error())}};
  if (!truncation) return out;
  out["error"] = truncation->error;
  out["shadows"] = truncation->shadows;
  out["wall_time"] = truncation->wall;
  for (const study::SourceEstimate& source : truncation->by_body) out["by_body"][source.body] = source.error;
  for (const study::OutputEstimate& o : truncation->outputs)
    out["outputs"][o.name] = {{"max", o.max},
                              {"rms", o.rms},
                              {"final", o.final},
                              {"size_max", o.size_max},
                              {"size_rms", o.size_rms}};
  return out;
}

}  // namespace flexura::app
