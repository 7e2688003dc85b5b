// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "reduce/cms/errors/error_estimate.hpp"
#include "reduce/cms/result/mesh_share.hpp"
#include "reduce/part/part_input.hpp"

namespace flexura::reduce {

/// What the reduction did and how far to trust it, for people and for programs.
struct Report {
  std::string text;     ///< a few lines for the terminal, ending with a newline
  nlohmann::json json;  ///< kept in the superelement
};

/// The superelement against the model it was made from.
struct Comparison {
  std::vector<double> full_hz, reduced_hz;  ///< elastic modes of the free body
  double static_error = -1.0;  ///< relative, of unit loads on the last interface, the first held; -1: none
};

struct ReportData {
  mesh::MeshReport mesh;
  std::vector<std::string> notes;
  std::vector<std::string> warnings = {};
  std::vector<ModeError> errors = {};        ///< of the free body's frequencies; empty: not estimated
  std::optional<MeshShare> mesh_error = {};  ///< what the mesh costs; none: not known
  double bulk_over_shear = 1.0;              ///< greatest of the materials
  Comparison comparison = {};
  double seconds = 0.0;
};

/// Sizes, residuals, memory and time by stage.
nlohmann::json reduction_json(const Reduction& reduction);

/// How many modes were counted, and below which frequency; null where they were not.
nlohmann::json certificate_json(const ReductionReport& report);

/// Says in its last line whether to trust the superelement.
Report make_report(const PartInput& input, const Reduction& reduction, ReportData& data);

}  // namespace flexura::reduce
