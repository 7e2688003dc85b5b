// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/run/quantity_list.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "mbs/mechanism/describe.hpp"

namespace flexura::app {
namespace {

struct Listed {
  std::string name, unit, doc;
  bool is_usual = false, is_unique = true;
};

std::vector<Listed> listed(const mbs::PreparedMechanism& p) {
  const mbs::Mechanism& m = *p.mechanism;
  std::vector<Listed> list;
  for (const mbs::OutputInfo& info : m.quantities())
    list.push_back({info.name, mbs::unit_of(info), info.doc});
  for (const int i : m.usual_quantities()) list[i].is_usual = true;
  const std::vector<bool> open = m.not_unique(p.state, p.state.p);
  for (std::size_t i = 0; i < open.size(); ++i) list[i].is_unique = !open[i];
  for (const mbs::OutputInfo& info : mbs::run_quantities()) list.push_back({info.name, "J", info.doc, true});
  return list;
}

// "mode_12" -> ("mode_", 12); names without a number at their end have the number -1.
std::pair<std::string, int> stem_and_number(const std::string& name) {
  const std::size_t digits = name.find_last_not_of("0123456789") + 1;
  if (digits == 0 || digits == name.size() || name.size() - digits > 6) return {name, -1};
  return {name.substr(0, digits), std::stoi(name.substr(digits))};
}

}  // namespace

std::string quantity_list(const mbs::PreparedMechanism& prepared, std::size_t width) {
  // In the order in which the owners come first.
  std::vector<std::string> owners;
  std::map<std::string, std::vector<Listed>> of;
  for (Listed& quantity : listed(prepared)) {
    const std::size_t dot = quantity.name.rfind('.');
    const std::string owner = dot == std::string::npos ? quantity.name : quantity.name.substr(0, dot);
    if (!of.contains(owner)) owners.push_back(owner);
    quantity.name = dot == std::string::npos ? "" : quantity.name.substr(dot + 1);
    of[owner].push_back(std::move(quantity));
  }
  std::string text;
  for (const std::string& owner : owners) {
    std::vector<Listed>& own = of[owner];
    // What has one unit together, units in the order in which they come first.
    std::vector<std::string> units;
    for (const Listed& q : own)
      if (std::ranges::find(units, q.unit) == units.end()) units.push_back(q.unit);
    std::ranges::stable_sort(
        own, {}, [&](const Listed& q) { return std::ranges::find(units, q.unit) - units.begin(); });
    std::vector<std::string> words;
    for (std::size_t i = 0; i < own.size(); ++i) {
      // A series, mode_1 to mode_40, is one word.
      std::size_t last = i;
      const auto [stem, first_number] = stem_and_number(own[i].name);
      const auto goes_on = [&](const Listed& next, int number) {
        return next.name == stem + std::to_string(number) && next.unit == own[i].unit &&
               next.is_usual == own[i].is_usual && next.is_unique == own[i].is_unique;
      };
      while (first_number >= 0 && last + 1 < own.size() &&
             goes_on(own[last + 1], first_number + static_cast<int>(last + 1 - i)))
        ++last;
      std::string word = own[i].name;
      if (last > i + 1)
        word += " to " + own[last].name;
      else
        last = i;
      word += own[i].is_usual ? "*" : "";
      word += own[i].is_unique ? "" : "?";
      // The unit once for all of it that follow each other.
      if (last + 1 == own.size() || own[last + 1].unit != own[i].unit)
        word += " [" + (own[i].unit.empty() ? "-" : own[i].unit) + "]";
      if (last + 1 < own.size()) word += ",";
      words.push_back(std::move(word));
      i = last;
    }
    // A measure is a quantity itself.
    if (own.size() == 1 && own[0].name.empty()) {
      text += fmt::format("  {}{}\n", owner, words[0]);
      continue;
    }
    std::string line = fmt::format("  {}:", owner);
    for (const std::string& word : words) {
      if (line.size() + 1 + word.size() > width) {
        text += line + "\n";
        line = "     ";
      }
      line += " " + word;
    }
    text += line + "\n";
  }
  return text;
}

nlohmann::json quantity_json(const mbs::PreparedMechanism& prepared) {
  nlohmann::json list = nlohmann::json::array();
  for (const Listed& q : listed(prepared))
    list.push_back({{"name", q.name},
                    {"unit", q.unit},
                    {"doc", q.doc},
                    {"is_usual", q.is_usual},
                    {"is_unique", q.is_unique}});
  return list;
}

}  // namespace flexura::app
