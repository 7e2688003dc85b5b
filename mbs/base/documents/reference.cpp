// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "mbs/base/documents/schema.hpp"

namespace flexura::input {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string kind_text(const Key& key) {
  const std::string unit = si_unit(key.dimension);
  // As code: Markdown takes the asterisks of N*m*s for emphasis.
  const std::string in_unit = unit.empty() ? "" : " [`" + unit + "`]";
  const std::string count = key.size >= 0 ? fmt::format("{} ", key.size) : "";
  switch (key.kind) {
    case Kind::text:
      return "text";
    case Kind::flag:
      return "true or false";
    case Kind::integer:
      return "whole number";
    case Kind::quantity:
      return unit.empty() ? "number" : "quantity" + in_unit;
    case Kind::vector3:
      return "3 numbers" + in_unit;
    case Kind::quaternion:
      return "quaternion (w, x, y, z)";
    case Kind::expression:
      return "formula or number" + in_unit;
    case Kind::choice: {
      std::string text;
      for (const std::string& choice : key.choices) text += (text.empty() ? "`\"" : ", `\"") + choice + "\"`";
      return text;
    }
    case Kind::texts:
      return "list of " + count + "texts";
    case Kind::integers:
      return "list of " + count + "whole numbers";
    case Kind::selection:
      return "whole number, list of them, or text like \"1-5, 8\"";
    case Kind::quantities:
      return "list of " + count + (unit.empty() ? "numbers" : "quantities" + in_unit);
    case Kind::vectors3:
      return count.empty() ? "list of points: 3 numbers" + in_unit + " each"
                           : "list of " + count + "times 3 numbers" + in_unit;
    case Kind::matrix:
      return "matrix: list of rows" + in_unit;
    case Kind::table:
      return "table";
    case Kind::tables:
      return "list of tables";
    case Kind::formulas:
      return "table of formulas";
    case Kind::table_map:
      return "tables by name";
  }
  return "";
}

std::string range_text(const Key& key) {
  std::string text;
  if (std::isfinite(key.lower)) text += fmt::format("{} {}", key.lower_open ? ">" : ">=", key.lower);
  if (std::isfinite(key.upper)) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", key.upper_open ? "<" : "<=", key.upper);
  }
  return text;
}

void write_rows(const std::vector<Key>& keys, std::string& out) {
  if (keys.empty()) {
    out += "No further keys.\n\n";
    return;
  }
  out += "| key | value | default | meaning |\n|---|---|---|---|\n";
  for (const Key& key : keys) {
    const std::string range = range_text(key);
    const std::string value = kind_text(key) + (range.empty() ? "" : ", " + range);
    const std::string fallback = key.is_required            ? "**required**"
                                 : key.default_text.empty() ? ""
                                                            : "`" + key.default_text + "`";
    out += fmt::format("| `{}` | {} | {} | {} |\n", key.name, escaped(value), escaped(fallback),
                       escaped(key.doc));
  }
  out += "\n";
}

// Whether this variant stands under another name of its own: its schema says of which type it is.
bool is_synonym(const TableSchema& schema, const std::string& name, const TableSchema& variant) {
  return variant.name != name && schema.variants.contains(variant.name);
}

// `type = "revolute"`, and beside it its synonyms: in the heading, where a search looks first.
std::string variant_heading(const TableSchema& schema, const std::string& name) {
  std::string text = fmt::format("`{} = \"{}\"`", schema.selector, name);
  for (const auto& [other, variant] : schema.variants)
    if (variant.name == name && is_synonym(schema, other, variant)) text += fmt::format(", `\"{}\"`", other);
  return text;
}

/// The page as it grows, and which types stand on it already: a connection takes the types of a joint, which are told once.
class Page {
 public:
  void write_table(const TableSchema& schema, const std::string& heading, const std::string& prefix,
                   int level) {
    out += std::string(static_cast<std::size_t>(level), '#') + " " + heading + "\n\n";
    if (!schema.doc.empty()) out += schema.doc + "\n\n";
    write_rows(schema.keys, out);
    write_nested(schema.keys, prefix, level + 1);
    std::string again;
    for (const auto& [name, variant] : schema.variants) {
      if (is_synonym(schema, name, variant)) continue;
      if (const Told* const before = told_before(name, variant))
        again += fmt::format("| {} | {} | {} |\n", variant_heading(schema, name), before->where,
                             key_names(variant));
      else
        write_table(variant, variant_heading(schema, name), prefix, level + 1);
    }
    if (!again.empty()) out += "| | as in | keys |\n|---|---|---|\n" + again + "\n";
    // Only now: two types of one table never stand for each other.
    for (const auto& [name, variant] : schema.variants) told_.try_emplace(name, heading, &variant);
  }

  std::string out;

 private:
  struct Told {
    std::string where;
    const TableSchema* variant;
  };

  /// The type of this name of another table, where it has the same words and all of these keys.
  const Told* told_before(const std::string& name, const TableSchema& variant) const {
    const auto found = told_.find(name);
    if (found == told_.end() || found->second.variant->doc != variant.doc ||
        variant.keys.empty() != found->second.variant->keys.empty())
      return nullptr;
    const std::vector<Key>& known = found->second.variant->keys;
    const auto stands_there = [&](const Key& key) {
      return std::any_of(known.begin(), known.end(),
                         [&](const Key& k) { return k.name == key.name && k.doc == key.doc; });
    };
    return std::all_of(variant.keys.begin(), variant.keys.end(), stands_there) ? &found->second : nullptr;
  }

  static std::string key_names(const TableSchema& variant) {
    std::string list;
    for (const Key& key : variant.keys) list += (list.empty() ? "`" : ", `") + key.name + "`";
    return list;
  }

  void write_nested(const std::vector<Key>& keys, const std::string& prefix, int level) {
    for (const Key& key : keys) {
      if (!key.table) continue;
      const std::string path = prefix.empty() ? key.name : prefix + "." + key.name;
      const std::string heading = key.kind == Kind::tables      ? "`[[" + path + "]]`"
                                  : key.kind == Kind::table_map ? "`[" + path + ".NAME]`"
                                                                : "`[" + path + "]`";
      write_table(*key.table, heading, key.kind == Kind::table_map ? path + ".NAME" : path, level);
    }
  }

  std::map<std::string, Told> told_;
};

}  // namespace

std::string reference_page(const TableSchema& schema) {
  Page page;
  page.write_table(schema, schema.name, "", 1);
  return page.out;
}

}  // namespace flexura::input
