// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/parameters.hpp"

#include <fmt/format.h>

#include <memory>
#include <vector>

#include "mbs/base/documents/shown_text.hpp"
#include "mbs/formulas/expression.hpp"

namespace flexura::mbs {
namespace {

/// What an Expression says against a formula, without the formula: whoever reads the number shows it and its
/// place.
std::string without_formula(const std::string& message, const std::string& formula) {
  const std::string opening = " = \"" + input::shown_text(formula) + "\"";
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
    if (expressions.back()->reads_time())
      throw input::InputError(
          fmt::format("{}: parameters.{} = \"{}\": varies with t; a parameter holds for "
                      "the whole run, a measure or an input may vary",
                      file, name, input::shown_text(formula)));
  }
  std::map<std::string, double> parameters;
  std::vector<double> values(names.size(), 0.0);
  // Each when all that it reads is known: what waits for a name stands behind it.
  std::vector<std::vector<std::size_t>> waiting(values.size());
  std::vector<std::size_t> ready, missing(formulas.size());
  for (std::size_t i = 0; i < formulas.size(); ++i) {
    missing[i] = expressions[i]->reads().size();
    for (const int place : expressions[i]->reads()) waiting[place].push_back(i);
    if (missing[i] == 0) ready.push_back(i);
  }
  for (std::size_t next = 0; next < ready.size(); ++next) {
    const auto& [name, formula] = formulas[ready[next]];
    const int place = names.find(name);
    try {
      values[place] = expressions[ready[next]]->evaluate(values.data());
    } catch (const std::runtime_error& error) {
      throw input::InputError(file + ": " + error.what());
    }
    parameters[name] = values[place];
    for (const std::size_t i : waiting[place])
      if (--missing[i] == 0) ready.push_back(i);
  }
  if (ready.size() < formulas.size()) {
    std::string circle;
    for (std::size_t i = 0; i < formulas.size(); ++i)
      if (missing[i] > 0) circle += (circle.empty() ? "" : ", ") + formulas[i].first;
    throw input::InputError(root.where("parameters") + ": " + input::shown_text(circle, 200) +
                            " depend on each other in a circle; give one of them as a number");
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
