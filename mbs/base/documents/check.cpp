// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <limits>
#include <map>
#include <sstream>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/section_data.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/documents/toml_file.hpp"
#include "mbs/base/documents/values.hpp"
#include "mbs/base/files/plain_text.hpp"

// Parses a TOML file, applies the overrides and checks the tree against the schema.  Defaults pass through
// the same code as values from the file, so a default out of range or of the wrong kind cannot hide.
namespace flexura::input {
namespace {

using DataPtr = std::shared_ptr<const Section::Data>;

// Names of the user's own become names in results, tables and pages; "" when this one can.
std::string wrong_with_name(std::string_view name) {
  constexpr std::size_t longest = 200;
  if (name.find_first_not_of(" \t") == std::string_view::npos) return "an empty name names nothing";
  if (name.size() > longest)
    return fmt::format("is a name of {} letters, {} are allowed", name.size(), longest);
  if (!files::is_plain_text(name)) return "has a control character in its name";
  if (name.find('/') != std::string_view::npos)
    return "has a \"/\" in its name, which parts names in results";
  return "";
}

// "1-5, 8" as (1, 5), (8, 8); nothing for another text.
std::optional<std::vector<std::pair<int, int>>> ranges_of(const std::string& text) {
  constexpr int kMost = 1'000'000;
  std::vector<std::pair<int, int>> ranges;
  if (text.ends_with(',')) return std::nullopt;
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, ',');) {
    std::istringstream in(part);
    int first = 0, last = 0;
    char dash = 0;
    if (!(in >> first)) return std::nullopt;
    last = first;
    if (in >> dash && (dash != '-' || !(in >> last))) return std::nullopt;
    if (in >> dash || first < 1 || last < first || last > kMost) return std::nullopt;
    ranges.emplace_back(first, last);
  }
  return ranges;
}

class Checker {
 public:
  Checker(std::shared_ptr<const std::filesystem::path> document, const Overrides& overrides)
      : values_(std::move(document), overrides) {}

  // Numbers of the document may from now on be formulas of its parameters.
  void take_parameters(const toml::table& root, const TableSchema& schema, const FormulaReader& formulas) {
    for (const Key& key : schema.keys) {
      if (key.name != "parameters" || key.kind != Kind::formulas) continue;
      auto data = std::make_shared<Section::Data>();
      data->document = values_.document();
      data->remarks = values_.remarks();
      data->kinds[key.name] = key.kind;
      if (auto value = check_key(root, key, "", 1, false)) data->values.emplace(key.name, std::move(*value));
      values_.set_formulas(formulas(Section(data)));
    }
  }

  // `lenient`: the table is not in the file; its required keys stay away until someone asks for them.
  DataPtr check(const toml::table& table, const TableSchema& schema, const std::string& path, int line,
                bool lenient) const {
    auto data = std::make_shared<Section::Data>();
    data->document = values_.document();
    data->remarks = values_.remarks();
    data->path = path;
    data->line = line;
    data->overridden = line == 0 && !lenient && !path.empty();

    std::vector<const Key*> keys;
    for (const Key& key : schema.keys) keys.push_back(&key);
    std::string variant;
    if (!schema.selector.empty()) {
      variant = selected_variant(table, schema, path, line, lenient);
      if (const auto found = schema.variants.find(variant); found != schema.variants.end()) {
        for (const Key& key : found->second.keys) keys.push_back(&key);
      }
    }
    Key selector;  // a selector that the schema leaves to its variants
    if (!schema.selector.empty() && std::none_of(keys.begin(), keys.end(), [&](const Key* key) {
          return key->name == schema.selector;
        })) {
      selector = choice(schema.selector, {variant}, "");
      keys.push_back(&selector);
    }

    refuse_unknown_keys(table, keys, schema, variant, path);
    for (const Key* key : keys) {
      data->kinds[key->name] = key->kind;
      if (auto value = check_key(table, *key, path, line, lenient))
        data->values.emplace(key->name, std::move(*value));
    }
    return data;
  }

 private:
  std::string selected_variant(const toml::table& table, const TableSchema& schema, const std::string& path,
                               int line, bool lenient) const {
    std::vector<std::string> names;
    for (const auto& [name, variant] : schema.variants) names.push_back(name);
    const auto declared = std::find_if(schema.keys.begin(), schema.keys.end(),
                                       [&](const Key& key) { return key.name == schema.selector; });
    Key key = declared != schema.keys.end() ? *declared : choice(schema.selector, names, "").required();
    if (key.choices.empty()) key.choices = names;
    const auto value = check_key(table, key, path, line, lenient);
    return value ? value->text : "";
  }

  void refuse_unknown_keys(const toml::table& table, const std::vector<const Key*>& keys,
                           const TableSchema& schema, const std::string& variant,
                           const std::string& path) const {
    std::vector<std::string> names;
    for (const Key* key : keys) names.push_back(key->name);
    // The first in the file, so that the message does not depend on the alphabet.
    const toml::key* first = nullptr;
    const toml::node* first_node = nullptr;
    for (const auto& [key, node] : table) {
      if (std::find(names.begin(), names.end(), key.str()) != names.end()) continue;
      if (!first || line_of(key.source()) < line_of(first->source())) {
        first = &key;
        first_node = &node;
      }
    }
    if (!first) return;
    const std::string name(first->str());
    const std::string full = join_path(path, name);
    const int line = line_of(first->source()) ? line_of(first->source()) : line_of(first_node->source());
    std::string rule = "unknown key";
    if (!variant.empty()) {
      bool elsewhere = false;
      for (const auto& [other, other_schema] : schema.variants) {
        for (const Key& key : other_schema.keys)
          elsewhere = elsewhere || (key.name == name && other != variant);
      }
      if (elsewhere) rule += fmt::format(" for {} = \"{}\"", schema.selector, variant);
    }
    values_.refuse({full, line, values_.is_overridden(full), false}, nullptr, rule, suggestion(name, names));
  }

  std::optional<Value> check_key(const toml::table& table, const Key& key, const std::string& path, int line,
                                 bool lenient) const {
    const std::string full = join_path(path, key.name);
    if (const toml::node* node = table.get(key.name)) {
      Place place = values_.place_of(*node, full);
      if (place.line == 0 && !place.overridden) place.line = line;  // an implicit table, [a.b] without [a]
      Value value = check_node(*node, key, place);
      value.line = place.line;
      value.in_file = true;
      value.overridden = place.overridden;
      value.shown = shown(*node);
      return value;
    }
    if (!key.default_text.empty()) {
      const auto holder = parse_value(key.default_text);
      Value value = check_node(*holder->get("value"), key, {full, 0, false, true});
      value.shown = key.default_text;
      return value;
    }
    if (key.is_required) {
      if (lenient) return std::nullopt;
      const bool overridden = line == 0 && values_.is_overridden(path);
      values_.refuse({full, line, overridden, false}, nullptr, "is missing", values_.missing_remedy(key));
    }
    if (key.kind == Kind::table) {
      Value value;
      value.tables.emplace_back(key.name, check(toml::table{}, *key.table, full, 0, true));
      return value;
    }
    return std::nullopt;
  }

  Value check_node(const toml::node& node, const Key& key, const Place& place) const {
    Value value;
    switch (key.kind) {
      case Kind::text:
        value.text = values_.text(node, key, place);
        break;
      case Kind::choice:
        value.text = values_.text(node, key, place);
        if (std::find(key.choices.begin(), key.choices.end(), value.text) == key.choices.end()) {
          values_.refuse(place, &node, "is not a known choice", suggestion(value.text, key.choices));
        }
        break;
      case Kind::flag:
        value.flag = values_.flag(node, key, place);
        break;
      case Kind::integer:
        value.integers = {values_.whole(node, key, place)};
        break;
      case Kind::quantity:
        value.numbers = {values_.number(node, key, place)};
        break;
      case Kind::expression:
        value.text = values_.formula(node, key, place);
        break;
      case Kind::vector3:
        value.numbers = values_.numbers(node, key, place, 3);
        break;
      case Kind::quantities:
        value.numbers = values_.numbers(node, key, place, key.size);
        break;
      case Kind::quaternion:
        value.numbers = values_.normalised(node, key, place);
        break;
      case Kind::texts:
        for (const toml::node& entry : values_.list(node, key, place, key.size)) {
          if (!entry.is_string())
            values_.refuse(place, &entry, values_.wanted(key) + " is wanted",
                           "write each in quotes, like \"1\"");
          value.texts.push_back(values_.text(entry, key, place));
        }
        break;
      case Kind::integers:
        for (const toml::node& entry : values_.list(node, key, place, key.size))
          value.integers.push_back(values_.whole(entry, key, place));
        break;
      case Kind::selection:
        selection(node, key, place, value);
        break;
      case Kind::vectors3:
        for (const toml::node& entry : values_.list(node, key, place, key.size)) {
          for (const double component : values_.numbers(entry, key, place, 3))
            value.numbers.push_back(component);
        }
        break;
      case Kind::matrix:
        values_.matrix(node, key, place, value);
        break;
      case Kind::table: {
        const toml::table* table = node.as_table();
        if (!table) values_.refuse(place, &node, values_.wanted(key) + " is wanted");
        value.tables.emplace_back(key.name, check(*table, *key.table, place.path, place.line, false));
        break;
      }
      case Kind::tables: {
        const toml::array& entries = values_.list(node, key, place, key.size);
        for (std::size_t i = 0; i < entries.size(); ++i) {
          const toml::table* table = entries[i].as_table();
          if (!table) values_.refuse(place, &node, values_.wanted(key) + " is wanted");
          const int line = line_of(entries[i].source());
          value.tables.emplace_back("", check(*table, *key.table, fmt::format("{}[{}]", place.path, i + 1),
                                              line ? line : place.line, false));
        }
        break;
      }
      case Kind::table_map:
        table_map(node, key, place, value);
        break;
      case Kind::formulas:
        formulas(node, key, place, value);
        break;
    }
    return value;
  }

  void table_map(const toml::node& node, const Key& key, const Place& place, Value& value) const {
    const toml::table* table = node.as_table();
    if (!table) values_.refuse(place, &node, values_.wanted(key) + " are wanted");
    struct Entry {
      std::string name;
      const toml::table* table;
      int line;
    };
    std::vector<Entry> entries;
    for (const auto& [name, child] : *table) {
      const std::string full = join_path(place.path, std::string(name.str()));
      const int line = line_of(name.source()) ? line_of(name.source()) : line_of(child.source());
      if (const std::string why = wrong_with_name(name.str()); !why.empty())
        values_.refuse({full, line, values_.is_overridden(full), false}, nullptr, why, "choose another name");
      if (!child.is_table()) {
        values_.refuse({full, line, values_.is_overridden(full), false}, &child,
                       values_.wanted(key) + " are wanted");
      }
      entries.push_back({std::string(name.str()), child.as_table(), line});
    }
    // toml++ sorts by name; what the user wrote first comes first, what the command line added comes last.
    const auto rank = [](const Entry& entry) {
      return entry.line ? entry.line : std::numeric_limits<int>::max();
    };
    std::stable_sort(entries.begin(), entries.end(),
                     [&](const Entry& a, const Entry& b) { return rank(a) < rank(b); });
    for (const Entry& entry : entries) {
      value.tables.emplace_back(
          entry.name, check(*entry.table, *key.table, join_path(place.path, entry.name), entry.line, false));
    }
  }

  void formulas(const toml::node& node, const Key& key, const Place& place, Value& value) const {
    const toml::table* table = node.as_table();
    if (!table) values_.refuse(place, &node, values_.wanted(key) + " is wanted");
    std::vector<Formula> entries;
    collect(*table, key, place, "", entries);
    std::ranges::stable_sort(entries, {}, &Formula::line);
    // "a.b" and a.b are one name; the command line has the last word on it.
    std::map<std::string, std::size_t> places;
    for (Formula& entry : entries) {
      const auto [at, is_new] = places.emplace(entry.name, value.texts.size());
      if (is_new)
        value.texts.insert(value.texts.end(), {std::move(entry.name), std::move(entry.text)});
      else if (entry.line == kNoLine)
        value.texts[at->second + 1] = std::move(entry.text);
      else
        values_.refuse(place, nullptr, fmt::format("gives \"{}\" twice", entry.name), "keep one of them");
    }
  }

  // A number alone stands for the first so many; a list or a text names which.
  void selection(const toml::node& node, const Key& key, const Place& place, Value& value) const {
    if (node.is_integer()) {
      value.integers = {values_.whole(node, key, place)};
      return;
    }
    value.flag = true;
    if (const auto* text = node.as_string()) {
      const auto ranges = ranges_of(text->get());
      if (!ranges) values_.refuse(place, &node, values_.wanted(key) + " is wanted");
      for (const auto& [first, last] : *ranges)
        for (int i = first; i <= last; ++i) value.integers.push_back(i);
    } else {
      for (const toml::node& entry : values_.list(node, key, place, -1))
        value.integers.push_back(values_.whole(entry, key, place));
    }
    if (value.integers.empty()) values_.refuse(place, &node, values_.wanted(key) + " is wanted");
    std::ranges::sort(value.integers);
    if (const auto twice = std::ranges::adjacent_find(value.integers); twice != value.integers.end())
      values_.refuse(place, &node, fmt::format("names {} twice", *twice));
  }

  static constexpr int kNoLine = std::numeric_limits<int>::max();  // of the command line
  struct Formula {
    int line;
    std::string name, text;
  };
  // A point in a name that stands without quotes makes a table within the table.
  void collect(const toml::table& table, const Key& key, const Place& place, const std::string& prefix,
               std::vector<Formula>& entries) const {
    const Key entry = expression(key.name, key.doc);
    for (const auto& [name, child] : table) {
      const std::string whole = prefix + std::string(name.str()), full = join_path(place.path, whole);
      const int line = line_of(name.source()) ? line_of(name.source()) : line_of(child.source());
      const Place here{full, line, values_.is_overridden(full), false};
      if (!files::is_plain_text(name.str()))
        values_.refuse(here, nullptr, "has a control character in its name", "choose another name");
      const int rank = line ? line : kNoLine;
      if (const toml::table* below = child.as_table(); below != nullptr && !below->empty())
        collect(*below, key, place, whole + ".", entries);
      else if (const auto* text = child.as_string(); key.keeps_units && text != nullptr)
        entries.push_back({rank, whole, text->get()});
      else
        entries.push_back({rank, whole, values_.formula(child, entry, here)});
    }
  }

  ValueReader values_;
};

}  // namespace

Section read_document(const std::filesystem::path& file, const TableSchema& schema,
                      const std::vector<std::string>& overrides, const FormulaReader& formulas) {
  toml::table root = read_toml(file);
  Overrides applied;
  for (const std::string& entry : overrides) apply_override(root, schema, entry, applied);
  Checker checker(std::make_shared<const std::filesystem::path>(file), applied);
  if (formulas) checker.take_parameters(root, schema, formulas);
  return Section(checker.check(root, schema, "", 1, false));
}

Section read_text_document(const std::string& name, const std::string& text, const TableSchema& schema) {
  const toml::table root = parse_toml(text, name);
  const Overrides none;
  return Section(
      Checker(std::make_shared<const std::filesystem::path>(name), none).check(root, schema, "", 1, false));
}

}  // namespace flexura::input
