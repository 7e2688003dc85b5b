// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/base/documents/schema.hpp"

namespace flexura::input {

/// Bad input: the message names file, line or key, the value, the rule and the remedy.  The programs print it
/// as one line "error: ..." and exit with code 2.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Things chosen by their numbers, counted from 1.
struct Selection {
  int first = std::numeric_limits<int>::max();  ///< the first so many, where no numbers are given
  std::vector<int> numbers{};                   ///< ascending
};

/// One table of a checked document.  Getters return SI values; keys with a default never fail; asking for a
/// key the schema does not have is a programming error (std::logic_error).
class Section {
 public:
  bool has(const std::string& key) const;  ///< stands in the file
  bool is_from_command_line(const std::string& key) const;
  std::string text(const std::string& key) const;  ///< text and choice; the source of an expression
  std::string title() const;                       ///< its key "name"; without it the file's name
  bool flag(const std::string& key) const;
  int integer(const std::string& key) const;
  double quantity(const std::string& key) const;
  Eigen::Vector3d vector3(const std::string& key) const;
  Eigen::Vector4d quaternion(const std::string& key) const;  ///< (w, x, y, z), normalised
  std::vector<std::string> texts(const std::string& key) const;
  std::vector<int> integers(const std::string& key) const;
  Selection selection(const std::string& key) const;  ///< without the key all
  std::vector<double> quantities(const std::string& key) const;
  std::vector<Eigen::Vector3d> vectors3(const std::string& key) const;
  Eigen::MatrixXd matrix(const std::string& key) const;
  Section table(const std::string& key) const;
  std::vector<Section> tables(const std::string& key) const;
  std::vector<std::pair<std::string, Section>> table_map(const std::string& key) const;  ///< in file order

  std::vector<std::pair<std::string, std::string>> formulas(const std::string& key) const;  ///< in file order

  /// Of the whole document: what can be read and is hardly meant, as angles of many turns without a unit.
  const std::vector<std::string>& remarks() const;

  const std::string& path() const;  ///< "joint[2]" (counted from 1) or "body.rod", for messages
  /// The value of a text key as a path: a relative one starts at the folder of the document.
  std::filesystem::path file(const std::string& key) const;
  const std::filesystem::path& document() const;  ///< the file this was read from
  /// "engine.toml:12: joint[2].from"
  std::string where(const std::string& key = {}) const;
  /// Throws InputError "<where> = <value>: <rule>; <remedy>".
  [[noreturn]] void refuse(const std::string& key, const std::string& rule,
                           const std::string& remedy = {}) const;

  struct Data;
  explicit Section(std::shared_ptr<const Data> data);

 private:
  std::shared_ptr<const Data> data_;
};

/// The value [SI] of a formula of a document's own parameters that stands in place of a number; nothing when
/// formulas have nothing to say about it.  Throws std::invalid_argument: syntax, an unknown name, inf or NaN.
using FormulaEvaluator = std::function<std::optional<double>(const std::string& formula)>;
/// Makes one from the document's root, of which the table [parameters] alone is checked so far.
using FormulaReader = std::function<FormulaEvaluator(const Section& parameters)>;

/// Reads a TOML file, checks it against the schema and returns its root.  `overrides` are "key.path=value"
/// pairs from the command line or a run table, applied before the check.  Throws InputError for a missing
/// file, a TOML syntax error, an unknown key ("did you mean ...?"), a missing key, a wrong type, a wrong
/// unit, a value out of range. Lists count from 1 in overrides as in messages: "joint[2].axis=[0, 0, 1]".
/// With `formulas`, and a table [parameters] in the schema, any number may be a formula in quotes.
Section read_document(const std::filesystem::path& file, const TableSchema& schema,
                      const std::vector<std::string>& overrides = {}, const FormulaReader& formulas = {});

/// The same of a text, called `name` in messages.
Section read_text_document(const std::string& name, const std::string& text, const TableSchema& schema);

/// The entry of `known` nearest to `word` by edit distance, or "" when none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& known);

/// ", did you mean \"...\"?" or "; known are a, b, c" or "".
std::string suggestion(const std::string& word, const std::vector<std::string>& known);

}  // namespace flexura::input
