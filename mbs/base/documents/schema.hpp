// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mbs/base/documents/units.hpp"

/// Schemas of input files: what may stand where.  One schema checks a file, words the refusals and prints the
/// reference page, so the three cannot disagree.
namespace flexura::input {

struct TableSchema;

enum class Kind {
  text,
  flag,
  integer,
  quantity,
  vector3,
  quaternion,
  expression,
  choice,
  texts,
  integers,
  selection,  ///< a whole number n for the first n, numbers in a list, or both as text: "1-5, 8"
  quantities,
  vectors3,
  matrix,
  table,
  tables,
  table_map,  ///< tables: [[key]]; table_map: [key.NAME]
  formulas    ///< a table with names of the user's own, each a formula, a number or a quantity
};

/// One key of a table.  Built with the chained setters, e.g.
///     quantity("density", dim::density, "mass per volume").required().above(0.0)
struct Key {
  std::string name;
  Kind kind = Kind::text;
  std::string doc;
  Dimension dimension = dim::none;
  bool is_required = false;
  std::string default_text;            ///< as it would stand in the file; empty = no default
  std::vector<std::string> choices;    ///< Kind::choice
  std::shared_ptr<TableSchema> table;  ///< Kind::table, tables, table_map
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  bool lower_open = false, upper_open = false;
  int size = -1;             ///< wanted number of entries of a list, -1 = any
  bool keeps_units = false;  ///< Kind::formulas: quantities stay as they are written

  Key&& required() &&;
  Key&& or_default(std::string text) &&;
  Key&& above(double bound) &&;  ///< value > bound
  Key&& at_least(double bound) &&;
  Key&& below(double bound) &&;
  Key&& at_most(double bound) &&;
  Key&& sized(int n) &&;
  Key&& with_units() &&;
};

/// The keys of one table.  When `selector` is not empty, the value of that key (a choice) adds the keys of
/// variants[value]: [[joint]] type = "revolute" adds what a revolute joint takes.
struct TableSchema {
  std::string name{};
  std::string doc{};
  std::vector<Key> keys{};
  std::string selector{};
  std::map<std::string, TableSchema> variants{};
};

Key text(std::string name, std::string doc);
Key flag(std::string name, std::string doc);
Key integer(std::string name, std::string doc);
Key quantity(std::string name, const Dimension& dimension, std::string doc);
Key vector3(std::string name, const Dimension& dimension, std::string doc);
Key quaternion(std::string name, std::string doc);
Key expression(std::string name, std::string doc);  ///< a formula in a string, or a plain number or quantity
Key expression(std::string name, const Dimension& dimension,
               std::string doc);  ///< a quantity in it is checked
Key choice(std::string name, std::vector<std::string> choices, std::string doc);
Key texts(std::string name, std::string doc);
Key integers(std::string name, std::string doc);
Key selection(std::string name, std::string doc);
Key quantities(std::string name, const Dimension& dimension, std::string doc);
Key vectors3(std::string name, const Dimension& dimension, std::string doc);
Key matrix(std::string name, std::string doc);
Key table(std::string name, TableSchema schema, std::string doc);
Key tables(std::string name, TableSchema schema, std::string doc);
Key table_map(std::string name, TableSchema schema, std::string doc);
Key formulas(std::string name, std::string doc);

/// The Markdown reference page of a schema: one section for each table, one row for each key.
std::string reference_page(const TableSchema& schema);

}  // namespace flexura::input
