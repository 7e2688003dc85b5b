// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/reduction_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "mbs/base/files/json_depth.hpp"
#include "mbs/view/html.hpp"

namespace flexura::view {

namespace {

using nlohmann::json;
using superelement::Superelement;

/// "greatest_mode_residual" as it is read: "greatest mode residual"; a unit at the end goes into brackets.
std::string words(std::string key) {
  static const std::pair<const char*, const char*> units[] = {
      {"_hz", " [Hz]"}, {"_bytes", " [bytes]"}, {"_seconds", " [s]"}, {"_kg", " [kg]"}, {"_percent", " [%]"}};
  for (const auto& [ending, unit] : units) {
    const std::size_t n = std::char_traits<char>::length(ending);
    if (key.size() > n && key.ends_with(ending)) {
      key.replace(key.size() - n, n, unit);
      break;
    }
  }
  for (char& c : key) {
    if (c == '_') c = ' ';
  }
  return key;
}

/// " m" for "centroid": units of what the reduction tells without one in its name.
std::string unit_behind(const std::string& key) {
  static const std::pair<const char*, const char*> units[] = {
      {"volume", "m³"}, {"cad_volume", "m³"}, {"centroid", "m"}, {"cad_centroid", "m"},
      {"size", "m"},    {"cad_mass", "kg"},   {"seconds", "s"}};
  for (const auto& [name, unit] : units)
    if (key == name) return std::string(" ") + unit;
  return {};
}

bool is_plain(const json& value) {
  return !value.is_object() && !value.is_array();
}

std::string plain_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_number_integer()) return figure_text(value.get<double>(), 17);
  if (value.is_number()) return figure_text(value.get<double>(), 5);
  return "\u2013";
}

ReportCell cell_of(const std::string& key, const json& value) {
  if (value.is_number()) return ReportCell(value.get<double>());
  Tone tone = Tone::plain;
  if (value.is_boolean() && (key == "passed" || key == "ok"))
    tone = value.get<bool>() ? Tone::good : Tone::bad;
  if (is_plain(value)) return {value.is_null() ? "" : plain_text(value), tone};
  std::string text;
  if (value.is_array()) {
    double size = 0.0;
    for (const json& item : value)
      if (item.is_number()) size = std::max(size, std::abs(item.get<double>()));
    for (const json& item : value) {
      // Round-off beside a component that is there is zero.
      const bool round_off = item.is_number() && std::abs(item.get<double>()) < 1e-9 * size;
      text += text.empty() ? "" : ", ";
      text += round_off ? "0" : is_plain(item) ? plain_text(item) : item.dump();
    }
  } else {
    for (const auto& [name, item] : value.items()) {
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", words(name),
                          is_plain(item) ? plain_text(item) : item.dump());
    }
  }
  return {text};
}

ReportTable table_of(const std::string& title, const json& rows) {
  ReportTable table{.title = title, .note = {}, .columns = {}, .rows = {}};
  std::vector<std::string> keys;
  for (const json& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  // What names the row comes first.
  for (const char* first : {"frequency_hz", "check", "interface", "name", "number", "mode"}) {
    const auto found = std::find(keys.begin(), keys.end(), first);
    if (found != keys.end()) std::rotate(keys.begin(), found, found + 1);
  }
  for (const std::string& key : keys) table.columns.push_back({words(key)});
  for (const json& row : rows) {
    std::vector<ReportCell> cells;
    for (const std::string& key : keys) cells.push_back(cell_of(key, row.value(key, json())));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

std::string vector_text(const Eigen::Vector3d& v) {
  const double size = v.cwiseAbs().maxCoeff();
  // Round-off beside a component that is there is zero.
  const auto part = [&](double x) { return figure_text(std::abs(x) < 1e-9 * size ? 0.0 : x, 6); };
  return fmt::format("({}, {}, {})", part(v.x()), part(v.y()), part(v.z()));
}

std::string directions_text(const superelement::Interface& item) {
  static constexpr const char* names[] = {"u_x", "u_y", "u_z", "θ_x", "θ_y", "θ_z"};
  if (item.directions.size() == 6) return "all six";
  std::string text;
  for (const auto direction : item.directions)
    text += (text.empty() ? "" : " ") + std::string(names[static_cast<int>(direction)]);
  for (const auto direction : item.following)
    text += (text.empty() ? "(" : " (") + std::string(names[static_cast<int>(direction)]) + " follows)";
  return text;
}

/// With what else the reduction told about the body as a whole, in single numbers and words.
void add_body(Report& report, const Superelement& se, const json& told) {
  const double mass = se.inertia.mass;
  const Eigen::Vector3d centre =
      mass > 0.0 ? Eigen::Vector3d(se.inertia.S_x / mass) : Eigen::Vector3d::Zero();
  const Eigen::Matrix3d S = se.inertia.S_xx - mass * centre * centre.transpose();
  const Eigen::Matrix3d J = S.trace() * Eigen::Matrix3d::Identity() - S;
  ReportSection& section = report.add("Body");
  ReportFacts facts{{{"mass", figure_text(mass, 7) + " kg"},
                     {"mass centre", vector_text(centre) + " m"},
                     {"inertia xx, yy, zz", vector_text(J.diagonal()) + " kg·m²"},
                     {"inertia xy, yz, zx", vector_text({J(0, 1), J(1, 2), J(2, 0)}) + " kg·m²"},
                     {"modal damping", figure_text(100.0 * se.modal_damping, 3) + " %"},
                     {"geometric stiffening", se.stiffening ? "yes" : "no"}}};
  if (told.is_object()) {
    for (const auto& [key, value] : told.items()) {
      if (key != "part" && key != "mass" && key != "seconds" && is_plain(value))
        facts.facts.emplace_back(words(key), plain_text(value) + unit_behind(key));
    }
  }
  section.add(std::move(facts));
  ReportTable table{.title = "Interfaces",
                    .note = {},
                    .columns = {{"name"}, {"tie"}, {"x", "m"}, {"y", "m"}, {"z", "m"}, {"directions"}},
                    .rows = {}};
  // Round-off beside the part's size is zero.
  double size = 0.0;
  for (const auto& item : se.interfaces) size = std::max(size, item.p_BoN_B.cwiseAbs().maxCoeff());
  const auto part = [&](double x) { return std::abs(x) < 1e-9 * size ? 0.0 : x; };
  for (const auto& item : se.interfaces) {
    const Eigen::Vector3d& p = item.p_BoN_B;
    table.rows.push_back({item.name, item.tie, part(p.x()), part(p.y()), part(p.z()), directions_text(item)});
  }
  section.add(std::move(table));
}

void add_modes(Report& report, const Superelement& se) {
  if (se.n_q == 0) return;
  ReportSection& section = report.add("Fixed-interface modes");
  ReportCurve curve{.name = "fixed-interface modes", .x = {}, .y = {}, .style = CurveStyle::points};
  for (int k = 0; k < se.n_q; ++k) {
    curve.x.push_back(k + 1);
    curve.y.push_back(std::sqrt(std::max(se.omega2[k], 0.0)) / (2.0 * std::numbers::pi));
  }
  section.add(
      ReportPlot{.title = "Frequencies",
                 .note = "With all interfaces held. What moves faster than the last mode is carried by the "
                         "constraint modes only.",
                 .x = {"mode"},
                 .y = {"frequency", "Hz"},
                 .curves = {curve}});
}

void add_times(ReportSection& section, const json& seconds) {
  ReportTable table{
      .title = "Time", .note = {}, .columns = {{"step"}, {"time", "s", 3}, {"share", "%", 3}}, .rows = {}};
  double total = 0.0;
  for (const auto& [key, value] : seconds.items()) total += value.is_number() ? value.get<double>() : 0.0;
  for (const auto& [key, value] : seconds.items()) {
    if (value.is_number()) {
      table.rows.push_back(
          {words(key), value.get<double>(), total > 0.0 ? 100.0 * value.get<double>() / total : 0.0});
    }
  }
  section.add(std::move(table));
}

}  // namespace

void add_json(ReportSection& section, const std::string& title, const json& value) {
  if (value.is_array() && !value.empty() &&
      std::all_of(value.begin(), value.end(), [](const json& v) { return v.is_object(); })) {
    section.add(table_of(title, value));
  } else if (value.is_object()) {
    ReportFacts facts;
    for (const auto& [key, item] : value.items()) {
      if (item.is_null()) continue;  // not measured
      if (!item.is_object() && !(item.is_array() && !item.empty() && item.front().is_object())) {
        const ReportCell cell = cell_of(key, item);
        facts.facts.emplace_back(words(key),
                                 (cell.is_number ? plain_text(item) : cell.text) + unit_behind(key));
      }
    }
    if (!facts.facts.empty()) section.add(std::move(facts));
    for (const auto& [key, item] : value.items()) {
      if (item.is_object() && key == "seconds") {
        add_times(section, item);
      } else if (item.is_object() && std::all_of(item.begin(), item.end(), is_plain)) {
        ReportTable table{.title = words(key), .note = {}, .columns = {{""}, {"value"}}, .rows = {}};
        for (const auto& [name, inner] : item.items())
          table.rows.push_back({words(name), cell_of(name, inner)});
        section.add(std::move(table));
      } else if (item.is_object() || (item.is_array() && !item.empty() && item.front().is_object())) {
        add_json(section, words(key), item);
      }
    }
  } else if (value.is_array()) {
    for (const json& item : value) section.add(ReportText{is_plain(item) ? plain_text(item) : item.dump()});
  } else {
    section.add(ReportFacts{{{title, plain_text(value)}}});
  }
}

Report reduction_report(const Superelement& se) {
  Report report{
      .title = se.name + " · reduction",
      .summary = fmt::format(
          "{} interface degrees of freedom and {} fixed-interface modes stand for the part.", se.n_b, se.n_q),
      .created_by = se.created_by};
  const json told = json::parse(files::shallow_json(se.report_json), nullptr, false);
  const auto get = [&](const char* group, const char* key) -> json {
    if (!told.is_object() || !told.contains(group)) return {};
    const json& value = told.at(group);
    return key == nullptr ? value : value.is_object() ? value.value(key, json()) : json();
  };
  report.facts = {{"mass", figure_text(se.inertia.mass, 5) + " kg"}};
  if (const json nodes = get("mesh", "nodes"); nodes.is_number())
    report.facts.emplace_back("nodes", plain_text(nodes));
  if (const json dofs = get("reduction", "dofs"); dofs.is_number())
    report.facts.emplace_back("degrees of freedom", plain_text(dofs));
  report.facts.emplace_back("shapes", fmt::format("{} + {}", se.n_b, se.n_q));
  if (const json time = get("seconds", nullptr); time.is_number())
    report.facts.emplace_back("time", figure_text(time.get<double>(), 3) + " s");
  if (const json memory = get("reduction", "peak_memory_bytes"); memory.is_number()) {
    report.facts.emplace_back("peak memory", figure_text(memory.get<double>() / 1e9, 3) + " GB");
  }

  if (told.is_object()) {
    // What the reader must know first.
    for (const auto& [key, value] : told.items()) {
      if (key == "acceptance" || key == "checks" || key == "accuracy") {
        std::string heading = words(key);
        heading[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(heading[0])));
        add_json(report.add(heading), "", value);
      }
    }
    if (told.contains("notes") && told["notes"].is_array() && !told["notes"].empty()) {
      ReportSection& notes = report.add("Notes");
      for (const json& note : told["notes"]) notes.add(ReportNotice{Tone::plain, plain_text(note)});
    }
  }
  add_body(report, se, told);
  add_modes(report, se);
  if (told.is_object()) {
    for (const auto& [key, value] : told.items()) {
      static constexpr const char* shown[] = {"acceptance", "checks", "accuracy",
                                              "notes",      "centre", "inertia"};
      if (is_plain(value) ||
          std::any_of(std::begin(shown), std::end(shown), [&](const char* name) { return key == name; }))
        continue;
      std::string heading = words(key);
      heading[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(heading[0])));
      json rest = value;
      if (rest.is_object()) rest.erase("fixed_interface_frequencies_hz");  // plotted
      add_json(report.add(heading), heading, rest);
    }
  }
  if (!se.source.empty())
    report.add("Part file").add(ReportCode{"The file that made this superelement", se.source});
  return report;
}

}  // namespace flexura::view
