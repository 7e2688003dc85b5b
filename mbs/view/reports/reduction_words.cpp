// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/reports/reduction_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "mbs/view/html/html.hpp"

namespace flexura::view {
namespace {

using nlohmann::json;

// What the endings do not tell.
const std::map<std::string, KeyWords>& known_keys() {
  static const std::map<std::string, KeyWords> known = {
      {"hz", {"frequency", "Hz"}},
      {"below_hz", {"no mode missed below", "Hz"}},
      {"volume", {"volume of the mesh", "cm³", 1e6}},
      {"cad_volume", {"volume in CAD", "cm³", 1e6}},
      {"volume_error", {"volume of the mesh against CAD", "%", 100.0, 3}},
      {"cad_mass", {"mass from CAD", "kg", 1.0, 7}},
      {"centroid", {"centre of the mesh", "mm", 1e3}},
      {"cad_centroid", {"centre in CAD", "mm", 1e3}},
      {"peak_stress_at", {"greatest stress at", "mm", 1e3}},
      {"unbounded_stress_at", {"stress without bound at", "mm", 1e3}},
      {"size", {"size of elements", "mm", 1e3}},
      {"cells", {"elements"}},
      {"poor_cells", {"badly shaped elements"}},
      {"inverted_cells", {"inverted elements"}},
      {"least_scaled_jacobian", {"least scaled Jacobian", "", 1.0, 3}},
      {"straightened_nodes", {"mid-edge nodes put on straight edges"}},
      {"dofs", {"degrees of freedom"}},
      {"interface_dofs", {"degrees of freedom of interfaces"}},
      {"peak_memory_bytes", {"greatest memory", "MB", 1e-6, 4}},
      {"factor_bytes", {"memory of the factor", "MB", 1e-6, 4}},
      {"factor_nonzeros", {"entries of the factor", "millions", 1e-6, 4}},
      {"factor_in_file", {"factor kept in a file"}},
      {"frequency_error", {"error of the frequency", "%", 100.0, 3}},
      {"safe_frequency_error", {"safe estimate of it", "%", 100.0, 3}},
      {"isolated", {"no other mode near"}},
      {"by", {"estimated by"}},
      {"seconds", {"time", "s", 1.0, 3}},
      {"rigid_error", {"rigid motions, greatest residual", "", 1.0, 2}},
      {"rigid_strain", {"strain of rigid motions", "", 1.0, 2}},
      {"constraint_residual", {"residual of constraint modes", "", 1.0, 2}},
      {"greatest_mode_residual", {"greatest residual of a mode", "", 1.0, 2}},
      {"smallest_pivot", {"smallest pivot of the stiffness matrix", "", 1.0, 2}},
      {"interface_condition", {"condition of the interfaces' stiffness", "", 1.0, 3}},
  };
  return known;
}

// Words of files in those of people.
std::string value_text(const std::string& word) {
  static const std::map<std::string, std::string> known = {{"craig_bampton", "Craig-Bampton"},
                                                           {"craig_chang", "Craig-Chang"},
                                                           {"guyan", "Guyan"},
                                                           {"enrichment", "elements of the next degree"},
                                                           {"recovery", "recovery of stress"}};
  const auto found = known.find(word);
  return found == known.end() ? word : found->second;
}

std::string plain_text(const KeyWords& words, const json& value) {
  if (value.is_string()) return value_text(value.get<std::string>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer() && words.factor == 1.0) return figure_text(value.get<double>(), 17);
  if (value.is_number()) return figure_text(words.factor * value.get<double>(), words.digits);
  return "–";
}

std::string list_text(const KeyWords& words, const json& list) {
  double size = 0.0;
  for (const json& item : list)
    if (item.is_number()) size = std::max(size, std::abs(item.get<double>()));
  std::string text;
  for (const json& item : list) {
    const bool round_off = item.is_number() && std::abs(item.get<double>()) < 1e-5 * size;
    text += text.empty() ? "" : ", ";
    text += round_off ? "0" : item.is_primitive() ? plain_text(words, item) : item.dump();
  }
  return text;
}

}  // namespace

KeyWords words_of(const std::string& key) {
  if (const auto found = known_keys().find(key); found != known_keys().end()) return found->second;
  static const std::pair<const char*, KeyWords> endings[] = {
      {"_hz", {"", "Hz"}}, {"_bytes", {"", "MB", 1e-6, 4}}, {"_seconds", {"", "s", 1, 3}},
      {"_kg", {"", "kg"}}, {"_percent", {"", "%"}},         {"_error", {"", "%", 100.0, 3}}};
  KeyWords words{key};
  for (const auto& [ending, unit] : endings) {
    const std::size_t n = std::char_traits<char>::length(ending);
    if (key.size() <= n || !key.ends_with(ending)) continue;
    words = unit;
    words.name = std::string(ending) == "_error" ? key : key.substr(0, key.size() - n);
    break;
  }
  std::ranges::replace(words.name, '_', ' ');
  return words;
}

std::string told_text(const std::string& key, const json& value) {
  const KeyWords words = words_of(key);
  std::string text;
  if (value.is_array()) {
    text = list_text(words, value);
  } else if (value.is_object()) {
    for (const auto& [name, item] : value.items())
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", words_of(name).name, told_text(name, item));
    return text;
  } else {
    text = plain_text(words, value);
    if (!value.is_number()) return text;
  }
  return words.unit.empty() || text.empty() ? text : text + " " + words.unit;
}

ReportCell told_cell(const std::string& key, const json& value) {
  const KeyWords words = words_of(key);
  if (value.is_number()) return ReportCell(words.factor * value.get<double>());
  Tone tone = Tone::plain;
  if (value.is_boolean() && (key == "passed" || key == "ok"))
    tone = value.get<bool>() ? Tone::good : Tone::bad;
  if (value.is_array()) return {list_text(words, value)};
  if (value.is_object()) return {told_text(key, value)};
  return {value.is_null() ? "" : plain_text(words, value), tone};
}

}  // namespace flexura::view
