// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/estimated_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/base/files/json_depth.hpp"
#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/study/estimate/full_model.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/superelement/file.hpp"

namespace flexura::app {

using study::percent;

namespace {

// Energy that is off by more than this, and so many times more than the outputs, is no small error of theirs: it is of their
// squares, and numerical damping takes some of what rings.
constexpr double kEnergyTells = 0.01, kEnergyBeyond = 30.0;

// The shadows are linear in what they correct; from here on their figure is no more than a warning.
constexpr double kTrusted = 0.2;

// A number of a report, or nothing.
std::optional<double> number_in(const nlohmann::json& table, const char* key) {
  const auto found = table.is_object() ? table.find(key) : table.end();
  if (found == table.end() || !found->is_number()) return {};
  return found->get<double>();
}

// What the elements cost in deformation, by the estimates for the lowest frequency (f ~ k^(1/2)) and for the compliance
// between interfaces; nothing where the mesh was not judged or does not resolve the part.
std::optional<double> share_of_elements(const std::optional<superelement::MeshError>& mesh) {
  if (!mesh) return {};
  double worst = -1.0;
  const auto take = [&](double error, double factor) {
    if (error < 0.0 || error >= 1.0) return false;
    worst = std::max(worst, factor * error);
    return true;
  };
  if (!mesh->modes.empty() && !take(mesh->modes.front().error, 2.0)) return {};
  for (const superelement::MeshError::Interface& interface : mesh->interfaces)
    if (!take(interface.compliance_error, 1.0)) return {};
  return worst >= 0.0 ? std::optional(worst) : std::nullopt;
}

ErrorSource mesh_of(const mbs::BodyDescription& body) {
  ErrorSource out{"mesh", body.name, {}, 0.0, "its reduction reports no estimate"};
  const superelement::Superelement se =
      superelement::read(body.superelement, {.matrices = false, .inertia = false, .mesh_error = true});
  const auto report = nlohmann::json::parse(files::shallow_json(se.report_json), nullptr, false);
  if (!report.is_object()) return out;
  double known = 0.0;
  if (const auto mesh = report.find("mesh"); mesh != report.end())
    known = std::abs(number_in(*mesh, "volume_error").value_or(0.0));
  const auto estimate = report.find("estimate");
  std::optional<double> dropped;
  if (estimate != report.end() && estimate->is_array() && !estimate->empty())
    dropped = number_in(estimate->front(), "frequency_error");
  const std::optional<double> elements = share_of_elements(se.mesh_error);
  known += 2.0 * dropped.value_or(0.0) + elements.value_or(0.0);
  if (dropped && elements) {
    out.error = known;
    out.note = "of its deformation";
  } else {
    out.at_least = known;
    if (dropped) out.note = "its elements were not judged, or do not resolve the part";
  }
  return out;
}

void add_bodies(const mbs::PreparedMechanism& prepared, std::vector<ErrorSource>& sources) {
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies) {
    if (!study::can_deform(body)) continue;
    if (body.flexible) sources.push_back(mesh_of(body));
    if (!study::has_stiffening_terms(body))
      sources.push_back({"stiffening",
                         body.name,
                         {},
                         0.0,
                         body.follows_surface || body.is_loaded_by_case
                             ? "its loads on the surface have no terms for it"
                             : "reduce it with stiffening = true"});
  }
}

// What switches takes another course with every change of the motion: a second run sees it, an estimate that is
// linear about the run does not.
void add_switches(const mbs::PreparedMechanism& prepared, bool is_judged, std::vector<ErrorSource>& sources) {
  if (is_judged) return;
  for (const auto& force : prepared.mechanism->description().forces)
    if (force->n_switches() > 0)
      sources.push_back({"switch", force->name(), {}, 0.0, "the estimate is linear about the run"});
  for (int i = 0; i < prepared.mechanism->sizes().n_root; ++i)
    if (prepared.mechanism->is_condition(i) && !prepared.mechanism->is_kink(i))
      sources.push_back(
          {"switch", prepared.mechanism->name_of_root(i), {}, 0.0, "the estimate is linear about the run"});
}

std::string basis(const study::OutputEstimate& output) {
  return output.scale > output.size_rms ? output.name + "'s family, beside which it is nothing"
                                        : output.name + ", the worst output";
}

}  // namespace

ErrorEstimate estimate_error(const mbs::PreparedMechanism& prepared, const Judges& judges,
                             const mbs::RunResult& result) {
  const study::TruncationEstimate* const truncation = judges.truncation;
  const study::IntegratorEstimate* const check = judges.integrator;
  ErrorEstimate out;
  const double off = std::abs(result.energy.relative_error());
  if (check && check->is_whole && off > std::max(kEnergyTells, kEnergyBeyond * check->error)) {
    out.sources.push_back(
        {"integrator",
         "",
         {},
         0.0,
         fmt::format("about {} by its steps, but energy is off by {}: a step may have leapt "
                     "over something; give a smaller max_step",
                     percent(check->error), percent(off))});
  } else if (check) {
    std::string note = check->output.empty() ? "" : "in " + check->output;
    if (!check->note.empty()) note += (note.empty() ? "" : "; ") + check->note;
    out.sources.push_back({"integrator", "", check->is_whole ? std::optional(check->error) : std::nullopt,
                           check->is_whole ? 0.0 : check->error, note});
  } else if (mbs::kind_of(prepared.options).integrates) {
    out.sources.push_back({"integrator",
                           "",
                           {},
                           off,
                           fmt::format("energy balance {}; --check-integrator tells", percent(off))});
  }
  out.of = check && !check->output.empty() ? check->output : "an output";
  if (const study::ElementsEstimate* const e = judges.elements;
      e && !e->output.empty() && (!check || e->error > check->error))
    out.of = e->output;
  if (truncation && truncation->worst >= 0) {
    out.of = basis(truncation->outputs[static_cast<std::size_t>(truncation->worst)]);
    out.is_large = truncation->error > kTrusted;
    for (const study::SourceEstimate& source : truncation->by_body)
      if (truncation->missed > 0.0)
        out.sources.push_back(
            {"modes",
             source.body,
             {},
             source.error,
             fmt::format("forces change within {:.3g} s, the rows that judge it are {:.3g} s apart: "
                         "give a smaller output_step",
                         truncation->missed, truncation->rows_apart)});
      else
        // Alone a body may be worst for another output.
        out.sources.push_back(
            {"modes", source.body, source.error, 0.0,
             truncation->by_body.size() > 1 && !source.output.empty() ? "in " + source.output : ""});
  }
  add_bodies(prepared, out.sources);
  const auto is_judged = [&](const std::string& body) {
    return judges.elements &&
           std::ranges::find(judges.elements->bodies, body) != judges.elements->bodies.end();
  };
  for (const mbs::BlindSpot& spot : prepared.file.blind_spots)
    if (spot.kind != "elements" || !is_judged(spot.name))
      out.sources.push_back(
          {spot.kind, spot.name, {}, 0.0, spot.key.empty() ? spot.remedy : "--check-elements tells"});
  // Those runs take all beams together.
  if (const study::ElementsEstimate* const e = judges.elements)
    out.sources.push_back({"elements", fmt::format("{}", fmt::join(e->bodies, ", ")),
                           e->is_whole ? std::optional(e->error) : std::nullopt, e->error, e->note});
  add_switches(prepared, check && check->factor != 1.0 && !truncation, out.sources);
  // Of all bodies together, where some of their errors may cancel.
  if (truncation) out.at_least += truncation->error;
  for (const ErrorSource& source : out.sources) {
    if (source.kind != "modes") out.at_least += source.error.value_or(source.at_least);
    out.is_whole = out.is_whole && source.error.has_value();
  }
  return out;
}

std::vector<ErrorSource> discretisation_of(const mbs::PreparedMechanism& prepared) {
  std::vector<ErrorSource> sources;
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies) {
    const mbs::ModalData* const data = body.flexible ? body.flexible->modal() : nullptr;
    // Shapes of a superelement, the six of rigid motion among them, that the basis does not span.
    if (data && data->Y.cols() + 6 < data->Y.rows())
      sources.push_back({"modes", body.name, {}, 0.0, "flexura simulate estimates them"});
  }
  add_bodies(prepared, sources);
  for (const mbs::BlindSpot& spot : prepared.file.blind_spots)
    sources.push_back({spot.kind, spot.name, {}, 0.0, spot.remedy});
  return sources;
}

}  // namespace flexura::app
