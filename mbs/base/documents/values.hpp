// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/section_data.hpp"

// What the sources of mbs/input share about TOML trees: overrides put into them before they are checked, and
// single values checked against their keys.
namespace flexura::input {

// --- Overrides: "key.path=value" from the command line or a run table ---

// The text as written, by path: for text keys, where name=12 is the text "12".
using Overrides = std::map<std::string, std::string>;

// The value of "key=value" and of a default, under the key "value": TOML if it is TOML, else text, so that
// quotes may be left out.
std::shared_ptr<toml::table> parse_value(const std::string& text);

// Throws InputError, also for a name of the user's own (a body's, a joint's) that the file does not have.
void apply_override(toml::table& root, const TableSchema& schema, const std::string& text,
                    Overrides& overrides);

// --- Values ---

inline int line_of(const toml::source_region& region) {
  return static_cast<int>(region.begin.line);
}

// A node as it stands in the file, shortened, for messages.
std::string shown(const toml::node& node);

// Where a node stands, for a message.
struct Place {
  std::string path;
  int line = 0;
  bool overridden = false;
  bool is_default = false;
};

class ValueReader {
 public:
  ValueReader(std::shared_ptr<const std::filesystem::path> document, const Overrides& overrides)
      : document_(std::move(document)), overrides_(overrides) {}

  // From now on a text in place of a number may be a formula.
  void set_formulas(FormulaEvaluator formulas) { formulas_ = std::move(formulas); }

  const std::shared_ptr<const std::filesystem::path>& document() const { return document_; }
  [[noreturn]] void refuse(const Place& place, const toml::node* node, const std::string& rule,
                           const std::string& remedy = {}) const;
  Place place_of(const toml::node& node, const std::string& path) const;
  // The path itself or a table or list above it came from the command line.
  bool is_overridden(const std::string& path) const;

  static std::string missing_remedy(const Key& key);
  // "a length", "a text", "a list of 3 numbers"
  static std::string wanted(const Key& key);

  std::string text(const toml::node& node, const Key& key, const Place& place) const;
  bool flag(const toml::node& node, const Key& key, const Place& place) const;
  int whole(const toml::node& node, const Key& key, const Place& place) const;
  double number(const toml::node& node, const Key& key, const Place& place) const;
  std::string formula(const toml::node& node, const Key& key, const Place& place) const;
  const toml::array& list(const toml::node& node, const Key& key, const Place& place, int size) const;
  // A list of numbers and quantities, or in one text with one unit: "0, 0, 12 mm".
  std::vector<double> numbers(const toml::node& node, const Key& key, const Place& place, int size) const;
  std::vector<double> normalised(const toml::node& node, const Key& key, const Place& place) const;
  void matrix(const toml::node& node, const Key& key, const Place& place, Value& value) const;

  // Of what was read so far; see Section::remarks().
  std::shared_ptr<const std::vector<std::string>> remarks() const { return remarks_; }

 private:
  double measured(const std::string& text, const toml::node& node, const Key& key, const Place& place) const;
  void check_range(double value, const toml::node& node, const Key& key, const Place& place) const;
  void remark_on_angle(double value, const Place& place) const;

  std::shared_ptr<const std::filesystem::path> document_;
  const Overrides& overrides_;
  FormulaEvaluator formulas_;
  std::shared_ptr<std::vector<std::string>> remarks_ = std::make_shared<std::vector<std::string>>();
};

}  // namespace flexura::input
