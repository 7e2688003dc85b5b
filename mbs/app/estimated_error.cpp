// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/estimated_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/study/percent.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::app {

using study::percent;

namespace {

// The shadows are linear in what they correct; from here on their figure is no more than a warning.
constexpr double kTrusted = 0.2;

}  // namespace

std::vector<MeshShare> mesh_shares(const mbs::PreparedMechanism& prepared) {
  std::vector<MeshShare> out;
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies) {
    if (!body.flexible && !body.ked) continue;
    MeshShare share{body.name, -1.0};
    if (body.superelement.empty()) {
      share.is_beam = true;
      out.push_back(std::move(share));
      continue;
    }
    const auto report = nlohmann::json::parse(
        superelement::read(body.superelement, {.matrices = false, .inertia = false}).report_json, nullptr,
        false);
    const auto add = [&](double part) { share.of_deformation = std::max(share.of_deformation, 0.0) + part; };
    if (report.is_object()) {
      const auto estimate = report.find("estimate");
      if (estimate != report.end() && estimate->is_array() && !estimate->empty())
        add(2.0 * estimate->front().value("frequency_error", 0.0));
      const auto mesh = report.find("mesh");
      if (mesh != report.end() && mesh->is_object() && mesh->contains("volume_error") &&
          mesh->at("volume_error").is_number())
        add(std::abs(mesh->at("volume_error").get<double>()));
    }
    out.push_back(std::move(share));
  }
  return out;
}

std::string estimated_error_line(const std::vector<MeshShare>& meshes,
                                 const study::TruncationEstimate* truncation,
                                 const study::IntegratorEstimate* check, const mbs::RunResult& result) {
  struct Part {
    std::string text;
    double error;
  };
  const double integrator = check ? check->error : std::abs(result.energy.relative_error());
  std::vector<Part> parts = {{"the integrator", integrator}};
  std::string words =
      check ? fmt::format("integrator {} (in {}; a second run at {:g} times the {})", percent(integrator),
                          check->output, check->factor, check->by_step ? "step" : "tolerance")
            : fmt::format("integrator {} or more (energy balance alone; --check-integrator tells)",
                          percent(integrator));
  std::string worst = check && !check->output.empty() ? check->output : "an output";
  double error = integrator;
  if (truncation && truncation->worst >= 0) {
    error += truncation->error;
    worst = truncation->outputs[static_cast<std::size_t>(truncation->worst)].name + ", the worst output";
    for (const study::SourceEstimate& source : truncation->by_body) {
      words += fmt::format(", modes left out of {} {}", source.body, percent(source.error));
      // Alone a body may be worst for another output.
      parts.push_back({truncation->by_body.size() > 1 && !source.output.empty()
                           ? fmt::format("what is left out of {}, in {}", source.body, source.output)
                           : fmt::format("what is left out of {}", source.body),
                       source.error});
    }
  } else if (!truncation) {
    words += ", no mode left out";
  }
  for (const MeshShare& mesh : meshes) {
    if (mesh.is_beam) {
      words += fmt::format(", elements of {} not judged (compare with twice as many)", mesh.body);
      continue;
    }
    if (mesh.of_deformation < 0.0) {
      words += fmt::format(", mesh of {} unknown (its reduction reports no estimate)", mesh.body);
      continue;
    }
    words += fmt::format(", mesh and reduction of {} {} of its deformation", mesh.body,
                         percent(mesh.of_deformation));
    error += mesh.of_deformation;
    parts.push_back({fmt::format("mesh and reduction of {}", mesh.body), mesh.of_deformation});
  }
  const Part& largest = *std::ranges::max_element(parts, {}, &Part::error);
  std::string line = fmt::format("estimated error {} of the rms of {}: {}; largest: {}", percent(error),
                                 worst, words, largest.text);
  if (truncation && truncation->error > kTrusted)
    line += "; an estimate to first order, of this size only a warning: compare with a run with more modes";
  return line;
}

nlohmann::json estimated_error_json(const std::vector<MeshShare>& meshes,
                                    const study::TruncationEstimate* truncation,
                                    const study::IntegratorEstimate* check, const mbs::RunResult& result) {
  nlohmann::json out = {{"integrator", check ? check->error : std::abs(result.energy.relative_error())}};
  if (check)
    out["integrator_check"] = {{"error", check->error},
                               {"output", check->output},
                               {"factor", check->factor},
                               {"wall_time", check->wall}};
  for (const MeshShare& mesh : meshes)
    if (mesh.of_deformation >= 0.0) out["mesh"][mesh.body] = mesh.of_deformation;
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
