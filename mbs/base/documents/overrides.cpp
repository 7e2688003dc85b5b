// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <optional>
#include <sstream>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/nesting.hpp"
#include "mbs/base/documents/section_data.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/documents/values.hpp"

namespace flexura::input {
namespace {

struct Step {
  std::string key;
  std::optional<std::size_t> index;  // from 1
};

std::vector<Step> split_path(const std::string& override_text, const std::string& path) {
  const auto malformed = [&]() -> InputError {
    return InputError(
        fmt::format("command line: \"{}\": is not of the form key.path=value; write for example "
                    "\"body.rod.density=7850 kg/m^3\" or \"joint[2].axis=[0, 0, 1]\"",
                    shown_text(override_text)));
  };
  std::vector<Step> steps;
  std::istringstream parts(path);
  for (std::string part; std::getline(parts, part, '.');) {
    Step step;
    const auto bracket = part.find('[');
    step.key = part.substr(0, bracket);
    if (bracket != std::string::npos) {
      const std::string digits = part.substr(bracket + 1, part.size() - bracket - 2);
      if (part.back() != ']' || digits.empty() || digits.size() > 6 ||
          digits.find_first_not_of("0123456789") != std::string::npos || std::stoul(digits) == 0) {
        throw malformed();
      }
      step.index = std::stoul(digits);
    }
    if (step.key.empty()) throw malformed();
    steps.push_back(step);
  }
  if (steps.empty() || path.back() == '.' || steps.size() > deepest_nesting) throw malformed();
  return steps;
}

// A misspelt name, "body.rodd.mass=3", must not become a body of its own: a table with a name of the user's
// own is there already, or comes whole, as in "body.rod={mass = 3}".
void refuse_new_names(const toml::table& root, const TableSchema& schema, const std::vector<Step>& steps) {
  const toml::table* table = &root;
  const TableSchema* known = &schema;
  std::string path;
  for (std::size_t i = 0; i + 1 < steps.size(); ++i) {
    const Key* key = nullptr;
    for (const Key& candidate : known->keys)
      if (candidate.name == steps[i].key) key = &candidate;
    path = join_path(path, steps[i].key);
    const toml::node* next = table == nullptr ? nullptr : table->get(steps[i].key);
    table = next == nullptr ? nullptr : next->as_table();
    // Of the file itself: a subsystem's parameters also stand in a file of their own.
    if (i == 0 && key != nullptr && key->kind == Kind::formulas && table != nullptr && !table->empty() &&
        i + 2 == steps.size() && !table->contains(steps[i + 1].key)) {
      std::vector<std::string> names;
      for (const auto& [other, child] : *table) names.emplace_back(other.str());
      throw InputError(fmt::format("command line: {}: the file's {} have no \"{}\"{}",
                                   join_path(path, steps[i + 1].key), path, steps[i + 1].key,
                                   suggestion(steps[i + 1].key, names)));
    }
    if (key == nullptr || key->table == nullptr || steps[i].index) return;
    known = key->table.get();
    if (key->kind != Kind::table_map) continue;
    ++i;
    const std::string& name = steps[i].key;
    const toml::node* entry = table == nullptr ? nullptr : table->get(name);
    if (entry == nullptr && i + 1 < steps.size()) {
      std::vector<std::string> names;
      if (table != nullptr)
        for (const auto& [other, child] : *table) names.emplace_back(other.str());
      throw InputError(fmt::format("command line: {}: there is no {} \"{}\"{}", join_path(path, name),
                                   known->name.empty() ? key->name : known->name, name,
                                   suggestion(name, names)));
    }
    path = join_path(path, name);
    table = entry == nullptr ? nullptr : entry->as_table();
  }
}

}  // namespace

std::shared_ptr<toml::table> parse_value(const std::string& text) {
  try {
    // One line only: a line break would let a value smuggle in further keys.
    if (text.find('\n') == std::string::npos && !line_nested_too_deep(text)) {
      return std::make_shared<toml::table>(toml::parse("value = " + text));
    }
  } catch (const toml::parse_error&) {
  }
  auto holder = std::make_shared<toml::table>();
  holder->insert("value", text);
  return holder;
}

void apply_override(toml::table& root, const TableSchema& schema, const std::string& text,
                    Overrides& overrides) {
  const auto equals = text.find('=');
  const auto trim = [](std::string s) {
    const auto first = s.find_first_not_of(" \t");
    if (first == std::string::npos) return std::string();
    return s.substr(first, s.find_last_not_of(" \t") - first + 1);
  };
  const std::string path = trim(text.substr(0, equals));
  const std::vector<Step> steps = split_path(text, equals == std::string::npos ? "" : path);
  refuse_new_names(root, schema, steps);
  const std::string raw = trim(text.substr(equals + 1));
  const auto holder = parse_value(raw);
  const toml::node& value = *holder->get("value");

  toml::table* table = &root;
  std::string here;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const auto& [key, index] = steps[i];
    here = join_path(here, key);
    const bool last = i + 1 == steps.size();
    if (last && !index) {
      if (raw.empty())
        table->erase(key);
      else
        table->insert_or_assign(key, value);
      break;
    }
    toml::node* next = table->get(key);
    if (index) {
      toml::array* list = next ? next->as_array() : nullptr;
      if (!list || *index > list->size()) {
        throw InputError(
            fmt::format("command line: {}[{}]: there is no such entry; {} has {}, counted from 1", here,
                        *index, here, list ? list->size() : 0));
      }
      here += fmt::format("[{}]", *index);
      if (last) {
        list->replace(list->cbegin() + static_cast<std::ptrdiff_t>(*index - 1), value);
        break;
      }
      next = list->get(*index - 1);
    } else if (!next) {
      table->insert(key, toml::table{});
      next = table->get(key);
    }
    table = next->as_table();
    if (!table)
      throw InputError(
          fmt::format("command line: {}: is not a table, so it has no key {}", here, steps[i + 1].key));
  }
  overrides[here] = raw;
}

}  // namespace flexura::input
