// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "mbs/input/document.hpp"
#include "mbs/input/section_data.hpp"

// Parses a TOML file, applies the overrides and checks the tree against the schema.  Defaults pass through
// the same code as values from the file, so a default out of range or of the wrong kind cannot hide.
namespace flexura::input {
namespace {

using DataPtr = std::shared_ptr<const Section::Data>;

int line_of(const toml::source_region& region) {
  return static_cast<int>(region.begin.line);
}

// --- Overrides -------------------------------------------------------------------------------------------

// The value of "key=value" and of a default: TOML if it is TOML, else text, so that quotes may be left out.
std::shared_ptr<toml::table> parse_value(const std::string& text) {
  try {
    // One line only: a line break would let a value smuggle in further keys.
    if (text.find('\n') == std::string::npos) {
      return std::make_shared<toml::table>(toml::parse("value = " + text));
    }
  } catch (const toml::parse_error&) {
  }
  auto holder = std::make_shared<toml::table>();
  holder->insert("value", text);
  return holder;
}

struct Step {
  std::string key;
  std::optional<std::size_t> index;  // from 1
};

std::vector<Step> split_path(const std::string& override_text, const std::string& path) {
  const auto malformed = [&]() -> InputError {
    return InputError(
        fmt::format("command line: \"{}\": is not of the form key.path=value; write for example "
                    "\"body.rod.density=7850 kg/m^3\" or \"joint[2].axis=[0, 0, 1]\"",
                    override_text));
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
  if (steps.empty() || path.back() == '.') throw malformed();
  return steps;
}

struct Override {
  std::string raw;  // as written, for text keys: name=12 is the text "12"
};

using Overrides = std::map<std::string, Override>;

void apply_override(toml::table& root, const std::string& text, Overrides& overrides) {
  const auto equals = text.find('=');
  const auto trim = [](std::string s) {
    const auto first = s.find_first_not_of(" \t");
    if (first == std::string::npos) return std::string();
    return s.substr(first, s.find_last_not_of(" \t") - first + 1);
  };
  const std::string path = trim(text.substr(0, equals));
  const std::vector<Step> steps = split_path(text, equals == std::string::npos ? "" : path);
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
  overrides[here] = {raw};
}

// --- Checking --------------------------------------------------------------------------------------------

std::string shown(const toml::node& node) {
  if (node.is_table()) return "";
  std::ostringstream out;
  if (const auto* value = node.as_string()) {
    out << '"' << value->get() << '"';
  } else if (const auto* array = node.as_array()) {
    out << '[';
    for (std::size_t i = 0; i < array->size(); ++i) out << (i ? ", " : "") << shown((*array)[i]);
    out << ']';
  } else if (const auto* number = node.as_floating_point()) {
    out << fmt::format("{}", number->get());
  } else {
    node.visit([&out](const auto& value) {
      if constexpr (toml::is_value<decltype(value)>) out << value;
    });
  }
  std::string text = out.str();
  constexpr std::size_t longest = 72;
  if (text.size() > longest) text = text.substr(0, longest - 3) + "...";
  return text;
}

class Checker {
 public:
  Checker(std::shared_ptr<const std::filesystem::path> document, const Overrides& overrides)
      : document_(std::move(document)), overrides_(overrides) {}

  // `lenient`: the table is not in the file; its required keys stay away until someone asks for them.
  DataPtr check(const toml::table& table, const TableSchema& schema, const std::string& path, int line,
                bool lenient) const {
    auto data = std::make_shared<Section::Data>();
    data->document = document_;
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
  // Where a node stands, for a message.
  struct Place {
    std::string path;
    int line = 0;
    bool overridden = false;
    bool is_default = false;
  };

  [[noreturn]] void refuse(const Place& place, const toml::node* node, const std::string& rule,
                           const std::string& remedy = {}) const {
    if (place.is_default) throw std::logic_error("the default of " + place.path + " is not valid: " + rule);
    refuse_value(location(*document_, place.line, place.overridden, place.path), node ? shown(*node) : "",
                 rule, remedy);
  }

  Place place_of(const toml::node& node, const std::string& path) const {
    return {path, line_of(node.source()), is_overridden(path), false};
  }

  // The path itself or a table or list above it came from the command line.
  bool is_overridden(const std::string& path) const {
    for (const auto& [key, value] : overrides_) {
      if (path == key || path.starts_with(key + ".") || path.starts_with(key + "[")) return true;
    }
    return false;
  }

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
    refuse({full, line, is_overridden(full), false}, nullptr, rule, suggestion(name, names));
  }

  std::optional<Value> check_key(const toml::table& table, const Key& key, const std::string& path, int line,
                                 bool lenient) const {
    const std::string full = join_path(path, key.name);
    if (const toml::node* node = table.get(key.name)) {
      Place place = place_of(*node, full);
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
      const bool overridden = line == 0 && is_overridden(path);
      refuse({full, line, overridden, false}, nullptr, "is missing", missing_remedy(key));
    }
    if (key.kind == Kind::table) {
      Value value;
      value.tables.emplace_back(key.name, check(toml::table{}, *key.table, full, 0, true));
      return value;
    }
    return std::nullopt;
  }

  static std::string missing_remedy(const Key& key) {
    std::string remedy = "give " + wanted(key);
    if (!key.doc.empty()) remedy += " (" + key.doc + ")";
    return remedy;
  }

  // "a length", "a text", "a list of 3 numbers"
  static std::string wanted(const Key& key) {
    const std::string unit = si_unit(key.dimension);
    const std::string entries = unit.empty() ? "plain numbers" : "quantities in " + unit;
    const std::string count = key.size >= 0 ? fmt::format("{} ", key.size) : "";
    switch (key.kind) {
      case Kind::text:
        return "a text in quotes";
      case Kind::flag:
        return "true or false";
      case Kind::integer:
        return "a whole number";
      case Kind::quantity:
        return kind_name(key.dimension);
      case Kind::vector3:
        return "a list of 3 " + entries;
      case Kind::quaternion:
        return "a list of 4 numbers (w, x, y, z)";
      case Kind::expression:
        return "a formula in quotes or a number";
      case Kind::choice: {
        std::string text = "one of ";
        for (std::size_t i = 0; i < key.choices.size(); ++i)
          text += fmt::format("{}\"{}\"", i ? ", " : "", key.choices[i]);
        return text;
      }
      case Kind::texts:
        return "a list of " + count + "texts";
      case Kind::integers:
        return "a list of " + count + "whole numbers";
      case Kind::quantities:
        return "a list of " + count + entries;
      case Kind::vectors3:
        return "a list of " + count + "lists of 3 " + entries;
      case Kind::matrix:
        return "a list of rows of equal length";
      case Kind::table:
        return "a table [" + key.name + "]";
      case Kind::tables:
        return "a list of tables [[" + key.name + "]]";
      case Kind::table_map:
        return "tables [" + key.name + ".NAME]";
      case Kind::formulas:
        return "a table [" + key.name + "] of names with formulas";
    }
    return "";
  }

  Value check_node(const toml::node& node, const Key& key, const Place& place) const {
    Value value;
    switch (key.kind) {
      case Kind::text:
        value.text = text(node, key, place);
        break;
      case Kind::choice:
        value.text = text(node, key, place);
        if (std::find(key.choices.begin(), key.choices.end(), value.text) == key.choices.end()) {
          refuse(place, &node, "is not a known choice", suggestion(value.text, key.choices));
        }
        break;
      case Kind::flag:
        value.flag = flag(node, key, place);
        break;
      case Kind::integer:
        value.integers = {whole(node, key, place)};
        break;
      case Kind::quantity:
        value.numbers = {number(node, key, place)};
        break;
      case Kind::expression:
        value.text = formula(node, key, place);
        break;
      case Kind::vector3:
        value.numbers = numbers(node, key, place, 3);
        break;
      case Kind::quantities:
        value.numbers = numbers(node, key, place, key.size);
        break;
      case Kind::quaternion:
        value.numbers = normalised(node, key, place);
        break;
      case Kind::texts:
        for (const toml::node& entry : list(node, key, place, key.size))
          value.texts.push_back(text(entry, key, place));
        break;
      case Kind::integers:
        for (const toml::node& entry : list(node, key, place, key.size))
          value.integers.push_back(whole(entry, key, place));
        break;
      case Kind::vectors3:
        for (const toml::node& entry : list(node, key, place, key.size)) {
          for (const double component : numbers(entry, key, place, 3)) value.numbers.push_back(component);
        }
        break;
      case Kind::matrix:
        matrix(node, key, place, value);
        break;
      case Kind::table: {
        const toml::table* table = node.as_table();
        if (!table) refuse(place, &node, wanted(key) + " is wanted");
        value.tables.emplace_back(key.name, check(*table, *key.table, place.path, place.line, false));
        break;
      }
      case Kind::tables: {
        const toml::array& entries = list(node, key, place, key.size);
        for (std::size_t i = 0; i < entries.size(); ++i) {
          const toml::table* table = entries[i].as_table();
          if (!table) refuse(place, &node, wanted(key) + " is wanted");
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
    if (!table) refuse(place, &node, wanted(key) + " are wanted");
    struct Entry {
      std::string name;
      const toml::table* table;
      int line;
    };
    std::vector<Entry> entries;
    for (const auto& [name, child] : *table) {
      const std::string full = join_path(place.path, std::string(name.str()));
      const int line = line_of(name.source()) ? line_of(name.source()) : line_of(child.source());
      if (!child.is_table()) {
        refuse({full, line, is_overridden(full), false}, &child, wanted(key) + " are wanted");
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
    if (!table) refuse(place, &node, wanted(key) + " is wanted");
    std::vector<std::pair<int, std::pair<std::string, std::string>>> entries;
    Key entry = expression(key.name, key.doc);
    for (const auto& [name, child] : *table) {
      const std::string full = join_path(place.path, std::string(name.str()));
      const int line = line_of(name.source()) ? line_of(name.source()) : line_of(child.source());
      entries.push_back(
          {line ? line : std::numeric_limits<int>::max(),
           {std::string(name.str()), formula(child, entry, {full, line, is_overridden(full), false})}});
    }
    std::stable_sort(entries.begin(), entries.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (auto& [line, named] : entries) {
      value.texts.push_back(std::move(named.first));
      value.texts.push_back(std::move(named.second));
    }
  }

  std::string text(const toml::node& node, const Key& key, const Place& place) const {
    if (const auto* value = node.as_string()) return value->get();
    // On the command line quotes are optional: name=12 means the text.
    if (const auto found = overrides_.find(place.path); found != overrides_.end() && node.is_value()) {
      return found->second.raw;
    }
    if (place.is_default) return key.default_text;
    refuse(place, &node, wanted(key) + " is wanted");
  }

  bool flag(const toml::node& node, const Key& key, const Place& place) const {
    if (const auto* value = node.as_boolean()) return value->get();
    refuse(place, &node, wanted(key) + " is wanted");
  }

  int whole(const toml::node& node, const Key& key, const Place& place) const {
    const auto* value = node.as_integer();
    if (!value) refuse(place, &node, "a whole number is wanted");
    if (std::abs(static_cast<double>(value->get())) > std::numeric_limits<int>::max()) {
      refuse(place, &node, "is too large for a whole number", "the largest is 2147483647");
    }
    check_range(static_cast<double>(value->get()), node, key, place);
    return static_cast<int>(value->get());
  }

  double number(const toml::node& node, const Key& key, const Place& place) const {
    double value = 0.0;
    if (const auto* integer = node.as_integer()) {
      value = static_cast<double>(integer->get());
    } else if (const auto* real = node.as_floating_point()) {
      value = real->get();
    } else if (const auto* quantity = node.as_string()) {
      try {
        value = parse_quantity(quantity->get(), key.dimension);
      } catch (const std::invalid_argument& failure) {
        refuse(place, &node, failure.what());
      }
    } else {
      refuse(place, &node, fmt::format("{} is wanted", wanted(key)));
    }
    if (!std::isfinite(value)) refuse(place, &node, "is not finite", "give a number");
    check_range(value, node, key, place);
    return value;
  }

  void check_range(double value, const toml::node& node, const Key& key, const Place& place) const {
    const bool low = key.lower_open ? value <= key.lower : value < key.lower;
    const bool high = key.upper_open ? value >= key.upper : value > key.upper;
    if (!low && !high) return;
    const std::string unit = si_unit(key.dimension).empty() ? "" : " " + si_unit(key.dimension);
    std::string rule = "must be ";
    const bool has_low = std::isfinite(key.lower), has_high = std::isfinite(key.upper);
    if (has_low) rule += fmt::format("{} {}", key.lower_open ? "above" : "at least", key.lower);
    if (has_low && has_high) rule += " and ";
    if (has_high) rule += fmt::format("{} {}", key.upper_open ? "below" : "at most", key.upper);
    refuse(place, &node, rule + unit);
  }

  std::string formula(const toml::node& node, const Key& key, const Place& place) const {
    if (node.is_integer() || node.is_floating_point()) return fmt::format("{}", number(node, key, place));
    const auto* value = node.as_string();
    if (!value || value->get().find_first_not_of(" \t") == std::string::npos) {
      refuse(place, &node, wanted(key) + " is wanted");
    }
    const auto measured = try_parse_measured(value->get());
    if (!measured) return value->get();  // a formula: checked by whoever knows its variables
    if (key.dimension == dim::none && std::isfinite(measured->value))
      return fmt::format("{}", measured->value);
    return fmt::format("{}", number(node, key, place));
  }

  const toml::array& list(const toml::node& node, const Key& key, const Place& place, int size) const {
    const toml::array* array = node.as_array();
    if (!array) refuse(place, &node, wanted(key) + " is wanted");
    if (size >= 0 && static_cast<int>(array->size()) != size) {
      refuse(place, &node, fmt::format("has {} entries, {} are wanted", array->size(), size));
    }
    return *array;
  }

  // A list of numbers and quantities, or in one text with one unit: "0, 0, 12 mm".
  std::vector<double> numbers(const toml::node& node, const Key& key, const Place& place, int size) const {
    std::vector<double> values;
    const auto* packed = node.as_string();
    if (!packed) {
      for (const toml::node& entry : list(node, key, place, size))
        values.push_back(number(entry, key, place));
      return values;
    }
    const std::string& all = packed->get();
    const auto last = all.find_last_of(',');
    const auto tail = last == std::string::npos ? all : all.substr(last + 1);
    const auto unit_at = tail.find_first_not_of(" \t+-.0123456789eE");
    std::string unit = unit_at == std::string::npos ? "" : tail.substr(unit_at);
    std::istringstream parts(all);
    for (std::string part; std::getline(parts, part, ',');) {
      const bool bare = part.find_first_not_of(" \t+-.0123456789eE") == std::string::npos;
      const toml::value<std::string> entry(bare ? part + " " + unit : part);
      try {
        values.push_back(parse_quantity(entry.get(), key.dimension));
      } catch (const std::invalid_argument& failure) {
        refuse(place, &node, failure.what());
      }
      check_range(values.back(), node, key, place);
    }
    if (size >= 0 && static_cast<int>(values.size()) != size) {
      refuse(place, &node, fmt::format("has {} entries, {} are wanted", values.size(), size));
    }
    return values;
  }

  std::vector<double> normalised(const toml::node& node, const Key& key, const Place& place) const {
    std::vector<double> q = numbers(node, key, place, 4);
    const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
    if (!(norm > 0.0) || !std::isfinite(norm)) {
      refuse(place, &node, "is no rotation: all its entries are zero", "[1, 0, 0, 0] is no rotation at all");
    }
    for (double& component : q) component /= norm;
    return q;
  }

  void matrix(const toml::node& node, const Key& key, const Place& place, Value& value) const {
    for (const toml::node& row : list(node, key, place, key.size)) {
      const std::vector<double> entries = numbers(row, key, place, -1);
      const int n_columns = static_cast<int>(entries.size());
      if (value.n_columns == 0) value.n_columns = n_columns;
      if (n_columns != value.n_columns || n_columns == 0) {
        refuse(place, &node,
               fmt::format("has rows of {} and {} entries, {} is wanted", value.n_columns, n_columns,
                           wanted(key)));
      }
      value.numbers.insert(value.numbers.end(), entries.begin(), entries.end());
    }
  }

  std::shared_ptr<const std::filesystem::path> document_;
  const Overrides& overrides_;
};

std::string read_text(const std::filesystem::path& file) {
  std::error_code failure;
  const auto status = std::filesystem::status(file, failure);
  if (!std::filesystem::exists(status)) {
    std::vector<std::string> neighbours;
    const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
    for (std::filesystem::directory_iterator it(folder, failure), end; !failure && it != end;
         it.increment(failure)) {
      if (it->path().extension() == ".toml") neighbours.push_back(it->path().filename().string());
    }
    const std::string near = nearest(file.filename().string(), neighbours);
    throw InputError(file.string() + ": there is no such file" +
                     (near.empty() ? "; check the path" : ", did you mean \"" + near + "\"?"));
  }
  if (std::filesystem::is_directory(status))
    throw InputError(file.string() + ": is a folder, a TOML file is wanted");
  std::ifstream in(file, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in) throw InputError(file.string() + ": cannot be read; check its permissions");
  if (text.starts_with("\x89HDF"))
    throw InputError(file.string() + ": is an HDF5 file, a TOML file is wanted");
  return text;
}

}  // namespace

Section read_document(const std::filesystem::path& file, const TableSchema& schema,
                      const std::vector<std::string>& overrides) {
  const std::string text = read_text(file);
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error& failure) {
    throw InputError(fmt::format("{}:{}:{}: is not valid TOML: {}", file.string(),
                                 failure.source().begin.line, failure.source().begin.column,
                                 failure.description()));
  }
  Overrides applied;
  for (const std::string& entry : overrides) apply_override(root, entry, applied);
  const Checker checker(std::make_shared<const std::filesystem::path>(file), applied);
  return Section(checker.check(root, schema, "", 1, false));
}

}  // namespace flexura::input
