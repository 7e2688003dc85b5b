// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/schema.hpp"

#include <utility>

namespace flexura::input {
namespace {

Key make(Kind kind, std::string name, std::string doc, const Dimension& dimension = dim::none) {
  Key key;
  key.name = std::move(name);
  key.kind = kind;
  key.doc = std::move(doc);
  key.dimension = dimension;
  return key;
}

Key nested(Kind kind, std::string name, TableSchema schema, std::string doc) {
  Key key = make(kind, std::move(name), std::move(doc));
  key.table = std::make_shared<TableSchema>(std::move(schema));
  return key;
}

}  // namespace

Key&& Key::required() && {
  is_required = true;
  return std::move(*this);
}
Key&& Key::or_default(std::string text) && {
  default_text = std::move(text);
  return std::move(*this);
}
Key&& Key::above(double bound) && {
  lower = bound;
  lower_open = true;
  return std::move(*this);
}
Key&& Key::at_least(double bound) && {
  lower = bound;
  lower_open = false;
  return std::move(*this);
}
Key&& Key::below(double bound) && {
  upper = bound;
  upper_open = true;
  return std::move(*this);
}
Key&& Key::at_most(double bound) && {
  upper = bound;
  upper_open = false;
  return std::move(*this);
}
Key&& Key::sized(int n) && {
  size = n;
  return std::move(*this);
}
Key&& Key::with_units() && {
  keeps_units = true;
  return std::move(*this);
}

Key text(std::string name, std::string doc) {
  return make(Kind::text, std::move(name), std::move(doc));
}
Key flag(std::string name, std::string doc) {
  return make(Kind::flag, std::move(name), std::move(doc));
}
Key integer(std::string name, std::string doc) {
  return make(Kind::integer, std::move(name), std::move(doc));
}
Key quantity(std::string name, const Dimension& dimension, std::string doc) {
  return make(Kind::quantity, std::move(name), std::move(doc), dimension);
}
Key vector3(std::string name, const Dimension& dimension, std::string doc) {
  return make(Kind::vector3, std::move(name), std::move(doc), dimension);
}
Key quaternion(std::string name, std::string doc) {
  return make(Kind::quaternion, std::move(name), std::move(doc));
}
Key expression(std::string name, std::string doc) {
  return make(Kind::expression, std::move(name), std::move(doc));
}
Key expression(std::string name, const Dimension& dimension, std::string doc) {
  return make(Kind::expression, std::move(name), std::move(doc), dimension);
}
Key choice(std::string name, std::vector<std::string> choices, std::string doc) {
  Key key = make(Kind::choice, std::move(name), std::move(doc));
  key.choices = std::move(choices);
  return key;
}
Key texts(std::string name, std::string doc) {
  return make(Kind::texts, std::move(name), std::move(doc));
}
Key integers(std::string name, std::string doc) {
  return make(Kind::integers, std::move(name), std::move(doc));
}
Key selection(std::string name, std::string doc) {
  return make(Kind::selection, std::move(name), std::move(doc)).at_least(1);
}
Key quantities(std::string name, const Dimension& dimension, std::string doc) {
  return make(Kind::quantities, std::move(name), std::move(doc), dimension);
}
Key vectors3(std::string name, const Dimension& dimension, std::string doc) {
  return make(Kind::vectors3, std::move(name), std::move(doc), dimension);
}
Key matrix(std::string name, std::string doc) {
  return make(Kind::matrix, std::move(name), std::move(doc));
}
Key table(std::string name, TableSchema schema, std::string doc) {
  return nested(Kind::table, std::move(name), std::move(schema), std::move(doc));
}
Key tables(std::string name, TableSchema schema, std::string doc) {
  return nested(Kind::tables, std::move(name), std::move(schema), std::move(doc));
}
Key formulas(std::string name, std::string doc) {
  return make(Kind::formulas, std::move(name), std::move(doc));
}
Key table_map(std::string name, TableSchema schema, std::string doc) {
  return nested(Kind::table_map, std::move(name), std::move(schema), std::move(doc));
}

}  // namespace flexura::input
