// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/known_errors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"

namespace flexura::superelement {

namespace {

// A mode of the file and the same by a table of the reduction: the digits that the report prints.  Of a pair the worse counts.
constexpr double kSame = 1e-6;
// Errors below it are those of the arithmetic.
constexpr double kRoundOff = 1e-12;

bool is_same(double a, double b) {
  return std::abs(a - b) <= kSame * std::abs(b);
}

struct LeftOut {
  double hz, error;
};

// The report's "estimate".
std::vector<LeftOut> left_out_rows(const Superelement& se) {
  std::vector<LeftOut> out;
  const auto report = files::try_read_json(se.report_json);
  if (!report.is_object() || !report.contains("estimate") || !report["estimate"].is_array()) return out;
  for (const nlohmann::json& row : report["estimate"]) {
    if (!row.is_object()) continue;
    const auto hz = row.find("frequency_hz"), error = row.find("frequency_error");
    if (hz != row.end() && error != row.end() && hz->is_number() && error->is_number())
      // Below zero it is round-off of nothing left out, as some files have it.
      out.push_back({hz->get<double>(), std::clamp(error->get<double>(), 0.0, 1.0)});
  }
  return out;
}

}  // namespace

FrequencyError frequency_error(const Superelement& se, double frequency_hz) {
  FrequencyError out;
  if (se.mesh_error)
    for (const MeshError::Mode& mode : se.mesh_error->modes)
      if (is_same(mode.frequency_hz, frequency_hz)) out.mesh = std::max(out.mesh, mode.error);
  for (const LeftOut& row : left_out_rows(se))
    if (is_same(row.hz, frequency_hz)) out.left_out = std::max(out.left_out, row.error);
  return out;
}

FrequencyError first_frequency_error(const Superelement& se) {
  FrequencyError out;
  if (se.mesh_error && !se.mesh_error->modes.empty()) out.mesh = se.mesh_error->modes.front().error;
  if (const std::vector<LeftOut> rows = left_out_rows(se); !rows.empty()) out.left_out = rows.front().error;
  return out;
}

const MeshError::Interface* worst_interface(const MeshError& error) {
  const auto worst = std::ranges::max_element(error.interfaces, {}, &MeshError::Interface::compliance_error);
  return worst != error.interfaces.end() && worst->compliance_error >= 0.0 ? &*worst : nullptr;
}

bool is_resolved(double worst, bool rough) {
  // What is known only to a factor of five does not say that much.
  return worst < (rough ? 1.0 : 0.2);
}

bool is_resolved(const MeshError& error) {
  double worst = error.modes.empty() ? -1.0 : error.modes.front().error;
  if (const MeshError::Interface* interface = worst_interface(error))
    worst = std::max(worst, interface->compliance_error);
  return worst >= 0.0 && is_resolved(worst, error.rough);
}

bool has_inertia_integrals(const Superelement& se) {
  const auto report = files::try_read_json(se.report_json);
  if (!report.is_object() || !report.contains("flexdata") || !report["flexdata"].is_object()) return true;
  const auto found = report["flexdata"].find("has_integrals");
  return found == report["flexdata"].end() || !found->is_boolean() || found->get<bool>();
}

bool is_of_beams(const Superelement& se) {
  const auto report = files::try_read_json(se.report_json);
  return report.is_object() && report.contains("mesh") && report["mesh"].is_object() &&
         report["mesh"].contains("members");
}

std::string percent_words(double error) {
  if (!(error >= 0.0)) return "unknown";
  if (error < kRoundOff) return "0";
  return error < 0.5 ? fmt::format("{:.2g}", 100.0 * error) : "50 or more";
}

std::string mesh_error_words(const Superelement& se) {
  if (!se.mesh_error || (se.mesh_error->modes.empty() && se.mesh_error->interfaces.empty()))
    return "What the mesh costs is unknown: the elements were not judged";
  std::string text;
  for (const MeshError::Interface& interface : se.mesh_error->interfaces)
    text += fmt::format("{}{}{} at {}", text.empty() ? "Static compliance, too low by the mesh: " : ", ",
                        percent_words(interface.compliance_error),
                        interface.compliance_error >= 0.0 ? " %" : "", interface.name);
  if (text.empty()) text = "Static compliance is judged between interfaces, there is one at most";
  if (se.mesh_error->rough) text += "; known only roughly, to a factor of five";
  return text;
}

}  // namespace flexura::superelement
