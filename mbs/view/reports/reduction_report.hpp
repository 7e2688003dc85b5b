// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "mbs/superelement/superelement.hpp"
#include "mbs/view/reports/report.hpp"

namespace flexura::view {

/// The report of a reduction, from the superelement it made: what the body is, how the mesh and the modes
/// were made, how far to trust them, how long it took, with a drawing.  Parts of se.report_json that this function does not
/// know are shown as facts and tables under their own names, so a report may grow without it. Needs the
/// matrices and the inertia integrals.
Report reduction_report(const superelement::Superelement& se);

/// The same from what `flexura reduce --report` wrote alone (is_told_by_reduction()), without the drawing.
Report reduction_report(const nlohmann::json& told);
bool is_told_by_reduction(const nlohmann::json& value);

/// Any JSON as blocks: numbers and words as facts, lists of objects as tables, objects as tables of their
/// own. A "passed" or "ok" that is false is marked.
void add_json(ReportSection& section, const std::string& title, const nlohmann::json& value);

}  // namespace flexura::view
