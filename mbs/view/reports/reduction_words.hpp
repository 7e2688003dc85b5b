// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "mbs/view/reports/report.hpp"

/// How the keys and numbers that a reduction tells (se.report_json) are read by people: words, units, round-off.
namespace flexura::view {

/// What a key's numbers are: its name for people, the unit they are shown in and the factor to it from what the file holds.
struct KeyWords {
  std::string name, unit{};
  double factor = 1.0;
  int digits = 5;
};

/// "greatest_mode_residual": "greatest mode residual"; a unit at the end of a key ("_hz", "_bytes", "_seconds") becomes one,
/// an error becomes per cent, lengths millimetres, volumes cubic centimetres.
KeyWords words_of(const std::string& key);

/// A number, text, truth or list of numbers with its unit, "289.9 cm³"; in lists what is below a 1e-5th of the largest (a mesh
/// is not symmetric to better) is 0; a dash for null.
std::string told_text(const std::string& key, const nlohmann::json& value);

/// The same as a cell of a table, whose column's heading bears the unit.
ReportCell told_cell(const std::string& key, const nlohmann::json& value);

}  // namespace flexura::view
