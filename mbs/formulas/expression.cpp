// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/formula_text.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/formulas/formula_parser.hpp"
#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {

using namespace operations;

namespace {

constexpr std::size_t stack_size = 64;

}  // namespace

int SignalNames::add(const std::string& name) {
  const auto [entry, is_new] = place_.try_emplace(name, size());
  if (is_new) names_.push_back(name);
  return entry->second;
}

int SignalNames::find(const std::string& name) const {
  const auto entry = place_.find(name);
  return entry == place_.end() ? -1 : entry->second;
}

SignalNames SignalNames::within(const std::string& prefix) const {
  if (prefix.empty()) return *this;
  SignalNames scoped;
  for (int i = 1; i < size(); ++i) {
    const bool own = names_[i].starts_with(prefix);
    scoped.names_.push_back(own ? names_[i].substr(prefix.size()) : "");
    if (own) scoped.place_[scoped.names_.back()] = i;
  }
  return scoped;
}

Expression::Expression(std::string where, std::string text, const SignalNames& signals,
                       const std::map<std::string, double>& constants, const Curves& tables,
                       SignalNames* held)
    : where_(std::move(where)), text_(std::move(text)) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("{} = \"{}\": {}", where_, input::shown_text(text_), why));
  };
  const auto refuse_unknown = [&](const std::string& token) {
    // What the file gives its names to comes first.
    std::vector<std::string> known;
    for (const auto& [name, value] : constants) known.push_back(name);
    for (const auto& [name, curve] : tables) known.push_back(name);
    known.insert(known.end(), signals.names().begin(), signals.names().end());
    std::erase(known, "");
    for (const std::string& name : known)
      if (name.find_first_not_of(input::name_characters) != std::string::npos &&
          text_.find(name) != std::string::npos)
        refuse(fmt::format("the name \"{}\" cannot stand in a formula; take one of letters, digits and _",
                           input::shown_text(name)));
    const std::vector<std::string> functions = function_names();
    known.insert(known.end(), functions.begin(), functions.end());
    known.insert(known.end(), {"pi", "e"});
    refuse(
        fmt::format("\"{}\" is not known here{}", input::shown_text(token), input::suggestion(token, known)));
  };
  FormulaNames names;
  names.value = [&](const std::string& name) -> std::optional<FormulaNode> {
    FormulaNode node;
    node.code = constant;
    if (const auto found = constants.find(name); found != constants.end())
      node.value = found->second;
    else if (const int place = signals.find(name); place >= 0)
      node.code = signal, node.place = place;
    else if (name == "pi")
      node.value = std::numbers::pi;
    else if (name == "e")
      node.value = std::numbers::e;
    else
      return {};
    return node;
  };
  names.table = [&](const std::string& name) -> std::shared_ptr<const Curve> {
    const auto found = tables.find(name);
    return found == tables.end() ? nullptr : found->second;
  };
  try {
    tree_ = parse_formula(text_, names);
  } catch (const UnknownName& unknown) {
    refuse_unknown(unknown.name);
  } catch (const std::invalid_argument& error) {
    refuse(error.what());
  }
  std::vector<int> node_of;
  const std::size_t most = compile(tree_.root, 0, node_of);
  if (most > stack_size) refuse("the formula is nested too deeply; take a part into a measure");
  if (held) find_conditions(*held, node_of);
}

// Appends what computes a node, `top` values being on the stack; returns how many there are at most meanwhile.
std::size_t Expression::compile(int k, std::size_t top, std::vector<int>& node_of) {
  const auto emit = [&](Instruction instruction, int node = -1) {
    program_.push_back(instruction);
    node_of.push_back(node);
    return program_.size() - 1;
  };
  const FormulaNode& node = tree_[k];
  std::size_t most = top + 1;
  if (node.code == choice) {
    most = std::max(most, compile(node.args[0], top, node_of));
    const std::size_t condition = emit({jump_if_zero});
    most = std::max(most, compile(node.args[1], top, node_of));
    const std::size_t yes = emit({jump});
    most = std::max(most, compile(node.args[2], top, node_of));
    program_[condition].count = static_cast<int>(yes);
    program_[yes].count = static_cast<int>(program_.size()) - 1;
    return most;
  }
  for (std::size_t i = 0; i < node.args.size(); ++i)
    most = std::max(most, compile(node.args[i], top + i, node_of));
  Instruction instruction{node.code};
  switch (node.code) {
    case constant:
      instruction.value = node.value;
      break;
    case signal:
      instruction.place = node.place;
      reads_time_ = reads_time_ || node.place == 0;
      if (node.place > 0 && std::ranges::find(reads_, node.place) == reads_.end())
        reads_.push_back(node.place);
      break;
    case table:
      instruction.count = static_cast<int>(tables_.size());
      tables_.push_back(node.curve);
      break;
    default:
      instruction.count = static_cast<int>(node.args.size());
  }
  emit(instruction, k);
  return most;
}

// ~moving in place of moving: kinks are not held.
template <class T>
T Expression::run(const double* signals, const T& time, int moving, const Jet* jets) const {
  const bool holds_kinks = moving >= 0;
  if (!holds_kinks) moving = ~moving;
  T stack[stack_size + 1];
  int top = -1;
  const int n = static_cast<int>(program_.size());
  const auto truth = [](bool b) { return constant_of<T>(b ? 1.0 : 0.0); };
  const auto held_at = [&](const Instruction& in) -> double {
    return held_integer(static_cast<int>(signals[in.place]));
  };
  for (int i = 0; i < n; ++i) {
    const Instruction& in = program_[i];
    switch (in.code) {
      case constant:
        stack[++top] = constant_of<T>(in.value);
        break;
      case signal:
        stack[++top] = in.place == 0 ? time : constant_of<T>(signals[in.place]);
        if constexpr (std::is_same_v<T, Jet>) {
          if (in.place != 0 && in.place == moving) stack[top].first = 1.0;
          if (in.place != 0 && jets) stack[top] = jets[in.place];
        }
        break;
      case jump_if_zero:
        if (value_of(stack[top--]) == 0.0) i = in.count;
        break;
      case jump:
        i = in.count;
        break;
      case add:
        --top;
        stack[top] = stack[top] + stack[top + 1];
        break;
      case subtract:
        --top;
        stack[top] = stack[top] - stack[top + 1];
        break;
      case multiply:
        --top;
        stack[top] = stack[top] * stack[top + 1];
        break;
      case divide:
        --top;
        stack[top] = stack[top] / stack[top + 1];
        break;
      case power:
        --top;
        stack[top] = power_of(stack[top], stack[top + 1]);
        break;
      case less:
        --top;
        stack[top] =
            truth(in.place > 0 && signals[in.place] != 0.0 ? held_at(in) != 0.0
                                                           : value_of(stack[top]) < value_of(stack[top + 1]));
        break;
      case less_equal:
        --top;
        stack[top] = truth(in.place > 0 && signals[in.place] != 0.0
                               ? held_at(in) != 0.0
                               : value_of(stack[top]) <= value_of(stack[top + 1]));
        break;
      case greater:
        --top;
        stack[top] =
            truth(in.place > 0 && signals[in.place] != 0.0 ? held_at(in) != 0.0
                                                           : value_of(stack[top]) > value_of(stack[top + 1]));
        break;
      case greater_equal:
        --top;
        stack[top] = truth(in.place > 0 && signals[in.place] != 0.0
                               ? held_at(in) != 0.0
                               : value_of(stack[top]) >= value_of(stack[top + 1]));
        break;
      case equal:
        --top;
        stack[top] = truth(value_of(stack[top]) == value_of(stack[top + 1]));
        break;
      case not_equal:
        --top;
        stack[top] = truth(value_of(stack[top]) != value_of(stack[top + 1]));
        break;
      case logical_and:
        --top;
        stack[top] = truth(value_of(stack[top]) != 0 && value_of(stack[top + 1]) != 0);
        break;
      case logical_or:
        --top;
        stack[top] = truth(value_of(stack[top]) != 0 || value_of(stack[top + 1]) != 0);
        break;
      case arc_tangent_2:
        --top;
        stack[top] = arc_tangent_2_of(stack[top], stack[top + 1]);
        break;
      case modulo:
        --top;
        stack[top] = in.place > 0 && signals[in.place] != 0.0
                         ? stack[top] - constant_of<T>(held_at(in)) * stack[top + 1]
                         : modulo_of(stack[top], stack[top + 1]);
        break;
      case minimum:
      case maximum: {
        top -= in.count - 1;
        if (holds_kinks && in.place > 0 && signals[in.place] != 0.0) {
          stack[top] = stack[top + static_cast<int>(held_at(in))];
          break;
        }
        for (int k = 1; k < in.count; ++k) {
          const double a = value_of(stack[top]), b = value_of(stack[top + k]);
          if (in.code == minimum ? b < a : b > a) stack[top] = stack[top + k];
        }
        break;
      }
      case table:
        stack[top] = table_of(*tables_[in.count], stack[top]);
        break;
      case smooth_step:
        top -= 4;
        stack[top] =
            smooth_step_of(stack[top], stack[top + 1], stack[top + 2], stack[top + 3], stack[top + 4]);
        break;
      default:
        if (in.place > 0 && signals[in.place] != 0.0 && (holds_kinks || in.code != absolute))
          stack[top] = in.code == absolute ? constant_of<T>(held_at(in) != 0.0 ? 1.0 : -1.0) * stack[top]
                                           : constant_of<T>(held_at(in));
        else
          stack[top] = apply_unary(in.code, stack[top]);
    }
  }
  return stack[0];
}

void Expression::refuse_value(double value, double t) const {
  // Not a number has no sign for a user.
  throw std::runtime_error(fmt::format(
      "{} = \"{}\" is {} at t = {:.9g} s, a finite number is wanted; correct the formula or what it reads",
      where_, input::shown_text(text_), std::isnan(value) ? std::abs(value) : value, t));
}

double Expression::evaluate_or_not_finite(const double* signals) const {
  const double value = run<double>(signals, signals[0]);
  // A trial step beyond a kink that is held may leave where the formula has values: max(0, x)^1.5.
  return std::isfinite(value) ? value : run<double>(signals, signals[0], ~0);
}

double Expression::evaluate(const double* signals) const {
  const double value = evaluate_or_not_finite(signals);
  if (!std::isfinite(value)) refuse_value(value, signals[0]);
  return value;
}

double Expression::derivative(const double* signals, int place) const {
  Jet f = run<Jet>(signals, Jet{signals[0], 0.0, 0.0}, place);
  if (!std::isfinite(f.first)) f = run<Jet>(signals, Jet{signals[0], 0.0, 0.0}, ~place);
  // A vertical slope (sqrt at 0) counts as none: what is made of it must stay finite.
  return std::isfinite(f.first) ? f.first : 0.0;
}

Jet Expression::time_derivatives(double t) const {
  const Jet f = run<Jet>(nullptr, Jet{t, 1.0, 0.0});
  for (double x : {f.value, f.first, f.second})
    if (!std::isfinite(x)) refuse_value(x, t);
  return f;
}

Jet Expression::along(const double* signals, const Jet* jets) const {
  Jet f = run<Jet>(signals, jets[0], 0, jets);
  if (!std::isfinite(f.value)) f = run<Jet>(signals, jets[0], ~0, jets);
  for (double x : {f.value, f.first, f.second})
    if (!std::isfinite(x)) refuse_value(x, jets[0].value);
  return f;
}

}  // namespace flexura::mbs
