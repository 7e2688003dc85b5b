// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/view/reports/reduction_report.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <tuple>

#include "mbs/base/files/json_text.hpp"
#include "mbs/view/html/html.hpp"
#include "mbs/view/reports/part_drawing.hpp"
#include "mbs/view/reports/reduction_words.hpp"

namespace flexura::view {

namespace {

using nlohmann::json;
using superelement::Superelement;

bool is_plain(const json& value) {
  return !value.is_object() && !value.is_array();
}

std::string capital(std::string words) {
  if (!words.empty()) words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  return words;
}

/// Of a section: what the group of numbers is about.
std::string heading_of(const std::string& key) {
  if (key == "estimate") return "Error left by the modes, free body";
  if (key == "mesh_error") return "Error left by the mesh";
  if (key == "certificate") return "Completeness";
  return capital(words_of(key).name);
}

ReportTable table_of(const std::string& title, const json& rows) {
  ReportTable table{.title = title, .note = {}, .columns = {}, .rows = {}};
  std::vector<std::string> keys;
  for (const json& row : rows) {
    for (const auto& [key, value] : row.items()) {
      // What no row knows is no column.
      if (!value.is_null() && std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  // What names the row comes first.
  for (const char* first :
       {"frequency_error", "hz", "frequency_hz", "check", "interface", "name", "number", "mode"}) {
    const auto found = std::find(keys.begin(), keys.end(), first);
    if (found != keys.end()) std::rotate(keys.begin(), found, found + 1);
  }
  for (const std::string& key : keys) {
    const KeyWords words = words_of(key);
    table.columns.push_back({words.name, words.unit, words.digits});
  }
  for (const json& row : rows) {
    std::vector<ReportCell> cells;
    for (const std::string& key : keys) cells.push_back(told_cell(key, row.value(key, json())));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

std::string vector_text(const Eigen::Vector3d& v, double scale = 0.0) {
  const double size = std::max(scale, v.cwiseAbs().maxCoeff());
  // Round-off beside a component that is there is zero, and so is what a mesh of a symmetric part is asymmetric by.
  const auto part = [&](double x) { return figure_text(std::abs(x) < 1e-5 * size ? 0.0 : x, 6); };
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
  if (std::string drawing = part_drawing(se); !drawing.empty())
    section.add(ReportDrawing{"The part and its interfaces", std::move(drawing)});
  ReportFacts facts{{{"mass", figure_text(mass, 7) + " kg"},
                     {"mass centre", vector_text(1e3 * centre) + " mm"},
                     {"inertia xx, yy, zz", vector_text(J.diagonal()) + " kg·m²"},
                     {"inertia xy, yz, zx", vector_text({J(0, 1), J(1, 2), J(2, 0)}, J.norm()) + " kg·m²"},
                     {"modal damping", figure_text(100.0 * se.modal_damping, 3) + " %"},
                     {"geometric stiffening", se.stiffening ? "yes" : "no"}}};
  if (told.is_object()) {
    for (const auto& [key, value] : told.items()) {
      if (key != "part" && key != "mass" && key != "seconds" && is_plain(value))
        facts.facts.emplace_back(words_of(key).name, told_text(key, value));
    }
  }
  section.add(std::move(facts));
  ReportTable table{.title = "Interfaces",
                    .note = {},
                    .columns = {{"name"}, {"tie"}, {"x", "mm"}, {"y", "mm"}, {"z", "mm"}, {"directions"}},
                    .rows = {}};
  // Round-off beside the part's size is zero.
  double size = 0.0;
  for (const auto& item : se.interfaces) size = std::max(size, item.p_BoN_B.cwiseAbs().maxCoeff());
  const auto part = [&](double x) { return std::abs(x) < 1e-9 * size ? 0.0 : 1e3 * x; };
  for (const auto& item : se.interfaces) {
    const Eigen::Vector3d& p = item.p_BoN_B;
    table.rows.push_back({item.name, item.tie, part(p.x()), part(p.y()), part(p.z()), directions_text(item)});
  }
  section.add(std::move(table));
}

void add_times(ReportSection& section, const std::string& title, const json& seconds) {
  ReportTable table{
      .title = title, .note = {}, .columns = {{"step"}, {"time", "s", 3}, {"share", "%", 3}}, .rows = {}};
  double total = 0.0;
  for (const auto& [key, value] : seconds.items()) total += value.is_number() ? value.get<double>() : 0.0;
  for (const auto& [key, value] : seconds.items()) {
    if (value.is_number()) {
      table.rows.push_back(
          {words_of(key).name, value.get<double>(), total > 0.0 ? 100.0 * value.get<double>() / total : 0.0});
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
        facts.facts.emplace_back(words_of(key).name, told_text(key, item));
      }
    }
    if (!facts.facts.empty()) section.add(std::move(facts));
    for (const auto& [key, item] : value.items()) {
      // Whatever their steps are called, these are times.
      if (item.is_object() && (key == "seconds" || key.ends_with("_seconds"))) {
        add_times(section, key == "seconds" ? "Time" : capital(words_of(key).name) + " time", item);
      } else if (item.is_object() && std::all_of(item.begin(), item.end(), is_plain)) {
        ReportTable table{
            .title = words_of(key).name, .note = {}, .columns = {{"quantity"}, {"value"}}, .rows = {}};
        for (const auto& [name, inner] : item.items())
          table.rows.push_back({words_of(name).name, told_text(name, inner)});
        section.add(std::move(table));
      } else if (item.is_object() || (item.is_array() && !item.empty() && item.front().is_object())) {
        add_json(section, words_of(key).name, item);
      }
    }
  } else if (value.is_array()) {
    for (const json& item : value) section.add(ReportText{told_text("", item)});
  } else {
    section.add(ReportFacts{{{title, told_text("", value)}}});
  }
}

namespace {

// What the reader must know first: is it to be trusted, and what was done to the part.
void add_verdict(Report& report, const json& told) {
  if (!told.is_object()) return;
  for (const auto& [key, value] : told.items())
    if (key == "acceptance" || key == "checks" || key == "accuracy")
      add_json(report.add(heading_of(key)), "", value);
  if (told.contains("notes") && told["notes"].is_array() && !told["notes"].empty()) {
    ReportSection& notes = report.add("Notes");
    for (const json& note : told["notes"]) notes.add(ReportNotice{Tone::plain, told_text("", note)});
  }
}

void add_rest(Report& report, const json& told) {
  if (!told.is_object()) return;
  for (const auto& [key, value] : told.items()) {
    static constexpr const char* shown[] = {"acceptance", "checks", "accuracy", "notes", "centre", "inertia"};
    if (is_plain(value) ||
        std::any_of(std::begin(shown), std::end(shown), [&](const char* name) { return key == name; }))
      continue;
    json rest = value;
    if (rest.is_object()) rest.erase("fixed_interface_frequencies_hz");  // plotted
    add_json(report.add(heading_of(key)), heading_of(key), rest);
  }
}

// In the line under the title.
std::vector<Fact> figures_of(const json& told, const std::string& shapes) {
  const auto get = [&](const char* group, const char* key) -> json {
    if (!told.is_object() || !told.contains(group)) return {};
    const json& value = told.at(group);
    return key == nullptr ? value : value.is_object() ? value.value(key, json()) : json();
  };
  std::vector<Fact> facts;
  if (const json nodes = get("mesh", "nodes"); nodes.is_number())
    facts.emplace_back("nodes", told_text("", nodes));
  if (const json dofs = get("reduction", "dofs"); dofs.is_number())
    facts.emplace_back("degrees of freedom", told_text("", dofs));
  if (!shapes.empty()) facts.emplace_back("shapes", shapes);
  if (const json time = get("seconds", nullptr); time.is_number())
    facts.emplace_back("time", told_text("seconds", time));
  if (const json memory = get("reduction", "peak_memory_bytes"); memory.is_number())
    facts.emplace_back("greatest memory", told_text("peak_memory_bytes", memory));
  return facts;
}

void add_frequencies(ReportSection& section, std::vector<double> hz) {
  ReportCurve curve{
      .name = "fixed-interface modes", .x = {}, .y = std::move(hz), .style = CurveStyle::points};
  for (std::size_t k = 0; k < curve.y.size(); ++k) curve.x.push_back(static_cast<double>(k + 1));
  section.add(
      ReportPlot{.title = "Frequencies",
                 .note = "With all interfaces held. What moves faster than the last mode is carried by the "
                         "constraint modes only.",
                 .x = {"mode"},
                 .y = {"frequency", "Hz"},
                 .curves = {curve}});
}

}  // namespace

Report reduction_report(const Superelement& se) {
  Report report{
      .title = se.name + " · reduction",
      .summary = fmt::format(
          "{} interface degrees of freedom and {} fixed-interface modes stand for the part.", se.n_b, se.n_q),
      .created_by = se.created_by};
  const json told = files::try_read_json(se.report_json);
  report.facts = figures_of(told, fmt::format("{} + {}", se.n_b, se.n_q));
  report.facts.insert(report.facts.begin(), {"mass", figure_text(se.inertia.mass, 5) + " kg"});
  add_verdict(report, told);
  add_body(report, se, told);
  if (se.n_q > 0) {
    std::vector<double> hz;
    for (int k = 0; k < se.n_q; ++k)
      hz.push_back(std::sqrt(std::max(se.omega2[k], 0.0)) / (2.0 * std::numbers::pi));
    add_frequencies(report.add("Fixed-interface modes"), std::move(hz));
  }
  add_rest(report, told);
  if (!se.source.empty())
    report.add("Part file").add(ReportCode{"The file that made this superelement", se.source});
  return report;
}

bool is_told_by_reduction(const json& value) {
  return value.is_object() && value.contains("part") && value.contains("reduction");
}

Report reduction_report(const json& told) {
  Report report{.title = told_text("", told.at("part")) + " · reduction",
                .summary =
                    "What the reduction told (--report); the page of the superelement itself also has its "
                    "drawing and interfaces."};
  report.facts = figures_of(told, "");
  if (told.contains("mass"))
    report.facts.insert(report.facts.begin(), {"mass", told_text("cad_mass", told.at("mass"))});
  add_verdict(report, told);
  ReportFacts facts;
  for (const auto& [key, unit, factor] : {std::tuple("mass", "kg", 1.0), std::tuple("centre", "mm", 1e3),
                                          std::tuple("inertia", "kg·m²", 1.0)}) {
    if (!told.contains(key)) continue;
    json value = told.at(key);
    if (factor != 1.0 && value.is_array())
      for (json& item : value)
        if (item.is_number()) item = factor * item.get<double>();
    facts.facts.emplace_back(std::string(key) == "inertia" ? "inertia xx, yy, zz, xy, yz, zx" : key,
                             told_text("", value) + " " + unit);
  }
  for (const auto& [key, value] : told.items())
    if (key != "part" && key != "mass" && key != "seconds" && is_plain(value))
      facts.facts.emplace_back(words_of(key).name, told_text(key, value));
  report.add("Body").add(std::move(facts));
  if (const json& reduction = told.at("reduction"); reduction.is_object()) {
    std::vector<double> hz;
    for (const json& one : reduction.value("fixed_interface_frequencies_hz", json::array()))
      if (one.is_number()) hz.push_back(one.get<double>());
    if (!hz.empty()) add_frequencies(report.add("Fixed-interface modes"), std::move(hz));
  }
  add_rest(report, told);
  return report;
}

}  // namespace flexura::view
