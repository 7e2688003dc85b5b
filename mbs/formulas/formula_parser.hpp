// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/formulas/formula_tree.hpp"

/// The grammar of formulas, in mechanism and in part files.  Loosest first; signs of one line group from the left, but ^ and
/// ? : from the right, and a sign binds looser than ^ before it and tighter behind it: -2^2 = -4, 2^-1 = 0.5.
///
///     choice      or [ "?" choice ":" choice ]
///     or          and { "||" and }
///     and         comparison { "&&" comparison }
///     comparison  sum { ( "<" | "<=" | ">" | ">=" | "==" | "!=" ) sum }
///     sum         product { ( "+" | "-" ) product }
///     product     signed { ( "*" | "/" ) signed }
///     signed      ( "+" | "-" ) signed | power
///     power       primary [ "^" exponent ],   exponent  ( "+" | "-" ) exponent | power
///     primary     number | name | name "(" choice { "," choice } ")" | "(" choice ")"
namespace flexura::mbs {

/// What names mean.
struct FormulaNames {
  std::function<std::optional<FormulaNode>(const std::string&)>
      value;  ///< a constant or a signal; none: not known
  std::function<std::shared_ptr<const Curve>(const std::string&)>
      table;  ///< a function of one argument; null: not known
};

/// A name that means nothing.
struct UnknownName : std::invalid_argument {
  explicit UnknownName(const std::string& name) : std::invalid_argument(name), name(name) {}
  std::string name;
};

/// The formula's tree.  Throws UnknownName, and std::invalid_argument saying what is wrong and where.
FormulaTree parse_formula(const std::string& text, const FormulaNames& names);

/// Names of all functions, for suggestions.
std::vector<std::string> function_names();

}  // namespace flexura::mbs
