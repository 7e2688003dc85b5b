// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/ledger/estimated_error.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "mbs/base/files/json_text.hpp"
#include "mbs/solver/accuracy/integrator_kind.hpp"
#include "mbs/study/estimate/deformation_error.hpp"
#include "mbs/study/estimate/full_model.hpp"
#include "mbs/study/estimate/percent.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/known_errors.hpp"

namespace flexura::study {

namespace {

// The shadows are linear in what they correct; from here on their figure is no more than a warning.
constexpr double kTrusted = 0.2;

ErrorSource mesh_of(const std::string& name, const superelement::Superelement& se,
                    const TruncationEstimate* truncation) {
  ErrorSource out{"mesh", name, {}, 0.0, "its reduction reports no estimate"};
  const DeformationError known = deformation_error(se);
  const double sum = known_error(known);
  const StiffnessEstimate* followed = nullptr;
  if (truncation)
    for (const StiffnessEstimate& one : truncation->by_stiffness)
      if (one.body == name) followed = &one;
  const double share = followed ? followed->error : sum;
  if (known.left_out && known.elements && followed) {
    out.error = share;
    out.note = fmt::format("{}{} of its stiffness",
                           followed->output.empty() ? "" : "in " + followed->output + ", by ", percent(sum));
  } else if (known.left_out && known.elements) {
    out.error = sum;
    out.note = "of its deformation, most by " + (*known.left_out > *known.elements
                                                     ? "twice its first frequency's error by modes left out"
                                                     : known.note);
  } else {
    out.at_least = share;
    if (known.left_out)
      out.note = "its elements were not judged, or do not resolve the part";
    else if (known.elements)
      out.note = "what its reduction left out was not judged";
    else if (superelement::is_of_beams(se))
      out.note = "parts of beams report no estimate; compare with more elements to a member";
  }
  return out;
}

void add_bodies(const mbs::PreparedMechanism& prepared, const TruncationEstimate* truncation,
                std::vector<ErrorSource>& sources) {
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies) {
    if (!can_deform(body)) continue;
    if (body.flexible) {
      const superelement::Superelement se =
          body.of_beam ? *body.of_beam
                       : superelement::read(body.superelement,
                                            {.matrices = false, .inertia = false, .mesh_error = true});
      sources.push_back(mesh_of(body.name, se, truncation));
      if (!superelement::has_inertia_integrals(se))
        sources.push_back({"inertia", body.name, {}, 0.0, "its FlexData file has no inertia integrals"});
    }
    if (!has_stiffening_terms(body))
      sources.push_back({"stiffening",
                         body.name,
                         {},
                         0.0,
                         body.follows_surface ? "its loads on the surface have no terms for it"
                                              : "reduce it with stiffening = true"});
  }
}

// What laws of deformation leave out where nothing above has judged it.
void add_laws(const mbs::PreparedMechanism& prepared, std::vector<ErrorSource>& sources) {
  const auto is_told = [&](const std::string& body) {
    return std::ranges::any_of(prepared.file.blind_spots, [&](const mbs::BlindSpot& spot) {
      return spot.name == body || body.starts_with(spot.name + ".");
    });
  };
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies) {
    if (!body.flexible) continue;
    for (const mbs::LawError& error : body.flexible->error_sources())
      if (!(error.kind == "modes" ? body.is_reduced() : is_told(body.name)))
        sources.push_back({error.kind, body.name, {}, 0.0, error.remedy});
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

// Kinematics gives bodies the shape that balances their loads, whatever they would ring by; ked has them ring linearly.
void add_vibration(const mbs::PreparedMechanism& prepared, std::vector<ErrorSource>& sources) {
  const bool is_linear = prepared.options.method == "ked";
  if (prepared.options.method != "kinematics" && !is_linear) return;
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies)
    if (body.flexible)
      sources.push_back(
          {"vibration",
           body.name,
           {},
           0.0,
           is_linear ? "ked is linear about the motion without deformation; compare with method = \"radau\""
                     : "kinematics follows none; compare with method = \"radau\""});
}

// Of kinematics: positions that no row holds follow from their speeds.
bool integrates_speeds(const mbs::PreparedMechanism& prepared) {
  if (prepared.options.method != "kinematics") return false;
  const mbs::Mechanism& m = *prepared.mechanism;
  for (int k = 0; k < m.sizes().n_lambda; ++k)
    if (!m.is_holonomic(k)) return true;
  return false;
}

std::string basis(const OutputEstimate& output) {
  return output.scale > output.size_rms ? output.name + "'s family, beside which it is nothing"
                                        : output.name + ", the worst output";
}

}  // namespace

ErrorEstimate estimate_error(const mbs::PreparedMechanism& prepared, const Judges& judges,
                             const mbs::RunResult& result) {
  const TruncationEstimate* const truncation = judges.truncation;
  const IntegratorEstimate* const check = judges.integrator;
  ErrorEstimate out;
  const double off = std::abs(result.energy.relative_error());
  if (!result.near_rank_loss.empty())
    out.sources.push_back({"dead_point", "", {}, 0.0, "the warning tells when; other rows are not touched"});
  // Next to a dead point the account takes reactions that are wrong, from steps that are right.
  const bool is_account_right = result.doubt_of_energy < off;
  if (check && check->is_whole && is_account_right && energy_tells_more(off, check->error)) {
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
  } else if (integrates_speeds(prepared)) {
    out.sources.push_back(
        {"integrator",
         "",
         {},
         off,
         fmt::format("energy balance {}; positions of driven speeds are integrated: compare "
                     "with a smaller tolerance",
                     percent(off))});
  } else if (mbs::kind_of(prepared.options).is_motion) {
    // Kinematics of positions: each state stands for itself, and is as good as its loops are closed.
    out.sources.push_back({"integrator", "", result.doubt_of_rows, 0.0, "what closing the loops leaves"});
  }
  out.of = check && !check->output.empty() ? check->output : "an output";
  if (const ElementsEstimate* const e = judges.elements;
      e && !e->output.empty() && (!check || e->error > check->error))
    out.of = e->output;
  if (truncation && truncation->worst >= 0) {
    out.of = basis(truncation->outputs[static_cast<std::size_t>(truncation->worst)]);
    out.is_large = truncation->error > kTrusted;
  }
  // Also where no row shows that they cost anything: a pulse between two rows may.
  if (truncation) {
    for (const SourceEstimate& source : truncation->by_body)
      if (truncation->missed > 0.0)
        out.sources.push_back(
            {"modes",
             source.body,
             {},
             source.error,
             fmt::format("forces change within {:.3g} s, more often than is looked at beside "
                         "rows {:.3g} s apart: compare with a run with more modes",
                         truncation->missed, truncation->rows_apart)});
      else if (!truncation->followed_roughly.empty())
        out.sources.push_back({"modes",
                               source.body,
                               {},
                               source.error,
                               truncation->followed_roughly + ": compare with a run with more modes"});
      else if (!source.beyond.empty())
        out.sources.push_back(
            {"modes", source.body, {}, source.error, source.beyond + ": compare with a run with more modes"});
      else
        // Alone a body may be worst for another output.
        out.sources.push_back(
            {"modes", source.body, source.error, 0.0,
             truncation->by_body.size() > 1 && !source.output.empty() ? "in " + source.output : ""});
  }
  add_bodies(prepared, truncation, out.sources);
  add_laws(prepared, out.sources);
  add_stresses(prepared, out.sources);
  const auto is_judged = [&](const std::string& body) {
    return judges.elements &&
           std::ranges::find(judges.elements->bodies, body) != judges.elements->bodies.end();
  };
  for (const mbs::BlindSpot& spot : prepared.file.blind_spots)
    if (spot.kind != "elements" || !is_judged(spot.name))
      out.sources.push_back(
          {spot.kind, spot.name, {}, 0.0, spot.key.empty() ? spot.remedy : "--check-elements tells"});
  // Those runs take all beams together.
  if (const ElementsEstimate* const e = judges.elements)
    out.sources.push_back({"elements", fmt::format("{}", fmt::join(e->bodies, ", ")),
                           e->is_whole ? std::optional(e->error) : std::nullopt, e->error, e->note});
  add_vibration(prepared, out.sources);
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
  add_bodies(prepared, nullptr, sources);
  // A run follows what loads do to the stiffness; nothing does here.
  for (const mbs::BodyDescription& body : prepared.mechanism->description().bodies)
    if (body.flexible && body.flexible->acts_back() && !body.flexible->has_geometric_stiffness() &&
        body.is_reduced() && has_stiffening_terms(body))
      sources.push_back({"stiffening", body.name, {}, 0.0, "fidelity = \"modal-stiffened\" has it"});
  add_stresses(prepared, sources);
  for (const mbs::BlindSpot& spot : prepared.file.blind_spots)
    sources.push_back({spot.kind, spot.name, {}, 0.0, spot.remedy});
  return sources;
}

}  // namespace flexura::study
