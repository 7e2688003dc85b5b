// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/deformation_error.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "mbs/base/files/json_text.hpp"
#include "mbs/superelement/file.hpp"
#include "mbs/superelement/known_errors.hpp"

namespace flexura::study {

DeformationError deformation_error(const superelement::Superelement& se) {
  DeformationError out;
  const auto report = files::try_read_json(se.report_json);
  if (report.is_object() && report.contains("mesh") && report["mesh"].is_object() &&
      report["mesh"].contains("volume_error") && report["mesh"]["volume_error"].is_number())
    out.volume = std::abs(report["mesh"]["volume_error"].get<double>());
  const superelement::FrequencyError frequency = superelement::first_frequency_error(se);
  if (frequency.left_out >= 0.0) out.left_out = 2.0 * frequency.left_out;
  if (!se.mesh_error) return out;
  const auto is_known = [](double error) { return error >= 0.0 && error < 1.0; };
  if (!se.mesh_error->modes.empty() && !is_known(frequency.mesh)) return out;
  for (const superelement::MeshError::Interface& interface : se.mesh_error->interfaces)
    if (!is_known(interface.compliance_error)) return out;
  if (is_known(frequency.mesh)) {
    out.elements = 2.0 * frequency.mesh;
    out.note = "twice its first frequency's";
  }
  const superelement::MeshError::Interface* const worst = superelement::worst_interface(*se.mesh_error);
  if (worst && worst->compliance_error > out.elements.value_or(-1.0)) {
    out.elements = worst->compliance_error;
    out.note = "static compliance at " + worst->name;
  }
  return out;
}

double known_error(const DeformationError& error) {
  return error.volume + error.left_out.value_or(0.0) + error.elements.value_or(0.0);
}

DeformationError deformation_error(const mbs::BodyDescription& body) {
  return deformation_error(
      body.of_beam
          ? *body.of_beam
          : superelement::read(body.superelement, {.matrices = false, .inertia = false, .mesh_error = true}));
}

}  // namespace flexura::study
