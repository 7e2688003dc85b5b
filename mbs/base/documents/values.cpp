// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/values.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <sstream>

#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/files/plain_text.hpp"

namespace flexura::input {

std::string shown(const toml::node& node) {
  if (node.is_table()) return "";
  std::ostringstream out;
  if (const auto* value = node.as_string()) {
    out << '"' << value->get() << '"';
  } else if (const auto* array = node.as_array()) {
    out << '[';
    constexpr std::size_t most = 40;  // the rest would be cut
    for (std::size_t i = 0; i < std::min(array->size(), most); ++i)
      out << (i ? ", " : "") << shown((*array)[i]);
    if (array->size() > most) out << ", ...";
    out << ']';
  } else if (const auto* number = node.as_floating_point()) {
    out << fmt::format("{}", number->get());
  } else {
    node.visit([&out](const auto& held) {
      if constexpr (toml::is_value<decltype(held)>) out << held;
    });
  }
  return shown_text(out.str());
}

void ValueReader::refuse(const Place& place, const toml::node* node, const std::string& rule,
                         const std::string& remedy) const {
  if (place.is_default) throw std::logic_error("the default of " + place.path + " is not valid: " + rule);
  refuse_value(location(*document_, place.line, place.overridden, place.path), node ? shown(*node) : "", rule,
               remedy);
}

Place ValueReader::place_of(const toml::node& node, const std::string& path) const {
  return {path, line_of(node.source()), is_overridden(path), false};
}

bool ValueReader::is_overridden(const std::string& path) const {
  for (const auto& [key, value] : overrides_) {
    if (path == key || path.starts_with(key + ".") || path.starts_with(key + "[")) return true;
  }
  return false;
}

std::string ValueReader::missing_remedy(const Key& key) {
  std::string remedy = "give " + wanted(key);
  if (!key.doc.empty()) remedy += " (" + key.doc + ")";
  return remedy;
}

std::string ValueReader::wanted(const Key& key) {
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
    case Kind::selection:
      return "a whole number, a list like [1, 3, 7], or a text like \"1-5, 8\"";
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

std::string ValueReader::text(const toml::node& node, const Key& key, const Place& place) const {
  if (const auto* value = node.as_string()) return files::plain_text(value->get());
  // On the command line quotes are optional: name=12 means the text.
  if (const auto found = overrides_.find(place.path); found != overrides_.end() && node.is_value()) {
    return files::plain_text(found->second);
  }
  if (place.is_default) return key.default_text;
  refuse(place, &node, wanted(key) + " is wanted");
}

bool ValueReader::flag(const toml::node& node, const Key& key, const Place& place) const {
  if (const auto* value = node.as_boolean()) return value->get();
  refuse(place, &node, wanted(key) + " is wanted");
}

int ValueReader::whole(const toml::node& node, const Key& key, const Place& place) const {
  const auto* value = node.as_integer();
  if (!value) refuse(place, &node, "a whole number is wanted");
  if (std::abs(static_cast<double>(value->get())) > std::numeric_limits<int>::max()) {
    refuse(place, &node, "is too large for a whole number", "the largest is 2147483647");
  }
  check_range(static_cast<double>(value->get()), node, key, place);
  return static_cast<int>(value->get());
}

namespace {

bool is_number_with_word(const std::string& text) {
  // Not names that strtod would take for numbers: "infeed", "nano".
  const auto first = text.find_first_not_of(" \t+-.");
  if (first == std::string::npos || !std::isdigit(static_cast<unsigned char>(text[first]))) return false;
  char* end = nullptr;
  std::strtod(text.c_str(), &end);
  while (*end == ' ' || *end == '\t') ++end;
  return std::isalpha(static_cast<unsigned char>(*end)) != 0;
}

}  // namespace

double ValueReader::measured(const std::string& text, const toml::node& node, const Key& key,
                             const Place& place) const {
  std::string trouble;
  try {
    return parse_quantity(text, key.dimension);
  } catch (const std::invalid_argument& failure) {
    trouble = failure.what();
  }
  // "12 mn" is a misspelt unit; "radius", "2*radius" and "1/12" are formulas.
  if (formulas_ && !is_number_with_word(text)) {
    try {
      if (const auto value = formulas_(text)) return *value;
    } catch (const std::invalid_argument& failure) {
      // Of a single word that is near no name there is nothing to say about formulas.
      const std::string words = failure.what();
      const bool is_word =
          std::ranges::all_of(text, [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '.'; });
      if (!is_word || words.find("did you mean") != std::string::npos)
        trouble = words;
      else
        trouble += ", or a formula of the file's parameters";
    }
  }
  refuse(place, &node, trouble);
}

double ValueReader::number(const toml::node& node, const Key& key, const Place& place) const {
  double value = 0.0;
  if (const auto* integer = node.as_integer()) {
    value = static_cast<double>(integer->get());
  } else if (const auto* real = node.as_floating_point()) {
    value = real->get();
  } else if (const auto* quantity = node.as_string()) {
    value = measured(quantity->get(), node, key, place);
  } else {
    refuse(place, &node, fmt::format("{} is wanted", wanted(key)));
  }
  if (!std::isfinite(value)) refuse(place, &node, "is not finite", "give a number");
  if (key.dimension == dim::angle && !node.is_string()) remark_on_angle(value, place);
  check_range(value, node, key, place);
  return value;
}

void ValueReader::remark_on_angle(double value, const Place& place) const {
  constexpr double kTurn = 2.0 * std::numbers::pi * (1.0 + 1e-9);
  if (std::abs(value) <= kTurn || place.is_default) return;
  remarks_->push_back(fmt::format(
      "{} = {}: is {:.3g} turns, angles without unit being radians; write \"{} deg\" or \"{} rad\"",
      location(*document_, place.line, place.overridden, place.path), value, value / (2.0 * std::numbers::pi),
      value, value));
}

void ValueReader::check_range(double value, const toml::node& node, const Key& key,
                              const Place& place) const {
  // Far beyond any machine on either side: sums and products of what is left stay within what a double holds,
  // of lengths, which are raised to the sixth power, and of ratios of stiffness to mass, too.
  const bool is_of_material = key.dimension == dim::density || key.dimension == dim::pressure;
  const double largest = key.dimension == dim::length ? 1e12
                         : is_of_material             ? 1e20
                                                      : 1e40,
               least = 1.0 / largest;
  if (std::isfinite(value) && std::abs(value) > largest && !place.is_default)
    refuse(place, &node, "is beyond all measure", fmt::format("the largest number taken is {}", largest));
  if (key.lower == 0.0 && (key.lower_open || is_of_material) && value > 0.0 && value < least)
    refuse(place, &node, "is beyond all measure", fmt::format("the least number taken is {}", least));
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

std::string ValueReader::formula(const toml::node& node, const Key& key, const Place& place) const {
  if (node.is_integer() || node.is_floating_point()) return fmt::format("{}", number(node, key, place));
  const auto* value = node.as_string();
  if (!value || value->get().find_first_not_of(" \t") == std::string::npos) {
    refuse(place, &node, wanted(key) + " is wanted");
  }
  const auto measured = try_parse_measured(value->get());
  if (!measured) return value->get();  // a formula: checked by whoever knows its variables
  if (key.dimension == dim::none && std::isfinite(measured->value)) return fmt::format("{}", measured->value);
  return fmt::format("{}", number(node, key, place));
}

const toml::array& ValueReader::list(const toml::node& node, const Key& key, const Place& place,
                                     int size) const {
  const toml::array* array = node.as_array();
  if (!array) refuse(place, &node, wanted(key) + " is wanted");
  if (size >= 0 && static_cast<int>(array->size()) != size) {
    refuse(place, &node, fmt::format("has {} entries, {} are wanted", array->size(), size));
  }
  return *array;
}

// A list of numbers and quantities, or in one text with one unit: "0, 0, 12 mm".
std::vector<double> ValueReader::numbers(const toml::node& node, const Key& key, const Place& place,
                                         int size) const {
  std::vector<double> values;
  const auto* packed = node.as_string();
  if (!packed) {
    for (const toml::node& entry : list(node, key, place, size)) values.push_back(number(entry, key, place));
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

std::vector<double> ValueReader::normalised(const toml::node& node, const Key& key,
                                            const Place& place) const {
  std::vector<double> q = numbers(node, key, place, 4);
  const double norm = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!(norm > 0.0) || !std::isfinite(norm)) {
    refuse(place, &node, "is no rotation: all its entries are zero", "[1, 0, 0, 0] is no rotation at all");
  }
  for (double& component : q) component /= norm;
  return q;
}

void ValueReader::matrix(const toml::node& node, const Key& key, const Place& place, Value& value) const {
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

}  // namespace flexura::input
