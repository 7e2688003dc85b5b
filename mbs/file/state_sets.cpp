// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/state_sets.hpp"

#include <fmt/format.h>

#include <cctype>

#include "mbs/base/documents/shown_text.hpp"
#include "mbs/formulas/parameters.hpp"

namespace flexura::mbs {
namespace {

// A quantity with its kind, or a plain number by a formula.  Throws std::invalid_argument.
input::Measured value_of(const std::string& text, const input::FormulaEvaluator& formula) {
  if (const auto measured = input::try_parse_measured(text)) return *measured;
  // "12 mn" is a misspelt unit.
  const auto first = text.find_first_not_of(" \t+-.");
  const bool is_number = first != std::string::npos && std::isdigit(static_cast<unsigned char>(text[first]));
  if (!is_number || text.find_first_of("*/+-^(", first + 1) != std::string::npos)
    if (const auto computed = formula(text)) return {.value = *computed};
  return {.value = input::parse_quantity(text, input::dim::none)};
}

}  // namespace

input::TableSchema state_schema() {
  namespace in = input;
  in::TableSchema state;
  state.name = "state";
  state.doc =
      "A set of states to start from: `[run.NAME] state`, `--state NAME` or `solver.initial_state` choose "
      "one. "
      "States that it does not name keep the mechanism file's values; loops close by moving those rather "
      "than what "
      "it names. The set \"zero\" needs no table.";
  state.keys = {
      in::flag("zero",
               "every state is zero first; an orientation is then that of the joint's markers, and a driven "
               "coordinate follows its drive")
          .or_default("false"),
      in::text(
          "file",
          "a state file, as `--save-state` writes it, whole or with some of the states. Modal coordinates "
          "that "
          "the mechanism does not have, as of a body that is rigid here, are left out; those that the file "
          "does not have are zero"),
      in::formulas("values",
                   "states by name, like `hinge.angle = \"30 deg\"` or `rod.mode_1 = 0.002`: numbers in SI, "
                   "quantities, or "
                   "formulas of parameters; `flexura assemble` lists the names")
          .with_units(),
      in::quantity("time", in::dim::time,
                   "when a run starts from this state; without it the time in `file`, or solver.start_time"),
      in::flag("equilibrium", "from there the positions move into static equilibrium; speeds stay")
          .or_default("false")};
  return state;
}

std::vector<StateSet> read_state_sets(const input::Section& root) {
  std::vector<StateSet> sets;
  const auto tables = root.table_map("state");
  if (tables.empty()) return sets;
  const input::FormulaEvaluator formula = evaluate_with(read_parameters(root));
  for (const auto& [name, s] : tables) {
    if (name == kZeroState) s.refuse("", "is the set with every state zero", "choose another name");
    StateSet set{.name = name, .where = s.where(), .zero = s.flag("zero")};
    if (s.has("file")) set.file = s.file("file");
    if (s.has("time")) set.time = s.quantity("time");
    set.equilibrium = s.flag("equilibrium");
    for (const auto& [state, text] : s.formulas("values")) {
      StateSet::Value value{state, {}, s.where("values") + "." + state};
      try {
        value.value = value_of(text, formula);
      } catch (const std::invalid_argument& trouble) {
        throw input::InputError(value.where + " = \"" + input::shown_text(text) + "\": " + trouble.what());
      }
      set.values.push_back(std::move(value));
    }
    if (!set.zero && !set.equilibrium && set.file.empty() && set.values.empty())
      s.refuse("", "says nothing of any state", "give values, file, zero or equilibrium");
    sets.push_back(std::move(set));
  }
  return sets;
}

StateSet find_state_set(const std::vector<StateSet>& sets, const std::string& name,
                        const std::string& where) {
  if (name == kZeroState) return {.name = name, .where = where, .zero = true};
  std::vector<std::string> known = {kZeroState};
  for (const StateSet& set : sets) {
    if (set.name == name) return set;
    known.push_back(set.name);
  }
  throw input::InputError(fmt::format("{} = \"{}\": there is no [state.NAME] of this name{}", where,
                                      input::shown_text(name), input::suggestion(name, known)));
}

}  // namespace flexura::mbs
