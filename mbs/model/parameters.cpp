// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/parameters.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "mbs/model/expression.hpp"

namespace flexura::mbs {
namespace {

/// What an Expression says against a formula, without the formula: whoever reads the number shows it and its
/// place.
std::string without_formula(const std::string& message, const std::string& formula) {
  const std::string opening = " = \"" + formula + "\"";
  if (!message.starts_with(opening)) return message;
  const auto start = message.find_first_not_of(": ", opening.size());
  return start == std::string::npos ? message : message.substr(start);
}

}  // namespace

std::map<std::string, double> read_parameters(const input::Section& root) {
  const auto formulas = root.formulas("parameters");
  const std::string file = root.document().filename().string();
  SignalNames names;
  for (const auto& [name, formula] : formulas) {
    if (name == "t" || name == "pi")
      throw input::InputError(root.where("parameters") + "." + name + ": \"" + name +
                              "\" has a meaning of its own in formulas; choose another name");
    names.add(name);
  }
  std::vector<std::unique_ptr<Expression>> expressions;
  for (const auto& [name, formula] : formulas) {
    try {
      expressions.push_back(std::make_unique<Expression>("parameters." + name, formula, names,
                                                         std::map<std::string, double>{}));
    } catch (const std::invalid_argument& error) {
      throw input::InputError(file + ": " + error.what());
    }
  }
  std::map<std::string, double> parameters;
  std::vector<double> values(names.size(), 0.0);
  std::vector<bool> known(names.size(), false);
  for (std::size_t left = formulas.size(); left > 0;) {
    const std::size_t before = left;
    for (std::size_t i = 0; i < formulas.size(); ++i) {
      const int place = names.find(formulas[i].first);
      if (known[place]) continue;
      if (!std::ranges::all_of(expressions[i]->reads(), [&](int k) { return known[k]; })) continue;
      try {
        values[place] = expressions[i]->evaluate(values.data());
      } catch (const std::runtime_error& error) {
        throw input::InputError(file + ": " + error.what());
      }
      known[place] = true;
      parameters[formulas[i].first] = values[place];
      --left;
    }
    if (left == before) {
      std::string circle;
      for (std::size_t i = 0; i < formulas.size(); ++i)
        if (!known[names.find(formulas[i].first)]) circle += (circle.empty() ? "" : ", ") + formulas[i].first;
      throw input::InputError(root.where("parameters") + ": " + circle + " depend on each other in a circle");
    }
  }
  return parameters;
}

input::FormulaEvaluator evaluate_with(const std::map<std::string, double>& parameters) {
  return [parameters](const std::string& formula) -> std::optional<double> {
    const bool computes = formula.find_first_of("*/+^(") != std::string::npos;
    if (parameters.empty() && !computes) return std::nullopt;  // a text that is no number, rather
    try {
      const Expression expression("", formula, SignalNames(), parameters);
      if (expression.reads_time())
        throw std::invalid_argument("varies with t where a number is wanted that holds for the whole run");
      const double time = 0.0;
      return expression.evaluate(&time);
    } catch (const std::exception& error) {
      throw std::invalid_argument(without_formula(error.what(), formula));
    }
  };
}

}  // namespace flexura::mbs
