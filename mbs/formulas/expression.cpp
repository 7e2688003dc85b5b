// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/expression.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/formula_text.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {
namespace {

using namespace operations;

// The functions muparser shall know; their addresses tell them apart in its byte code.

template <int code>
double f1(double x) {
  return apply_unary(code, x);
}
double f_atan2(double y, double x) {
  return std::atan2(y, x);
}
double f_pow(double x, double y) {
  return std::pow(x, y);
}
double f_mod(double x, double y) {
  return modulo_of(x, y);
}
double f_min(const double* x, int n) {
  return *std::min_element(x, x + n);
}
double f_max(const double* x, int n) {
  return *std::max_element(x, x + n);
}
double f_table(void* curve, double x) {
  return (*static_cast<const Curve*>(curve))(x);
}
double f_step(double x, double x0, double y0, double x1, double y1) {
  return smooth_step_of(x, x0, y0, x1, y1);
}

struct NamedFunction {
  const char* name;
  int code;
  mu::fun_type1 f;
};
constexpr NamedFunction functions_1[] = {{"sin", sine, f1<sine>},
                                         {"cos", cosine, f1<cosine>},
                                         {"tan", tangent, f1<tangent>},
                                         {"asin", arc_sine, f1<arc_sine>},
                                         {"acos", arc_cosine, f1<arc_cosine>},
                                         {"atan", arc_tangent, f1<arc_tangent>},
                                         {"sinh", sinh, f1<sinh>},
                                         {"cosh", cosh, f1<cosh>},
                                         {"tanh", tanh, f1<tanh>},
                                         {"asinh", asinh, f1<asinh>},
                                         {"acosh", acosh, f1<acosh>},
                                         {"atanh", atanh, f1<atanh>},
                                         {"exp", exponential, f1<exponential>},
                                         {"ln", logarithm, f1<logarithm>},
                                         {"log", logarithm, f1<logarithm>},
                                         {"log10", logarithm_10, f1<logarithm_10>},
                                         {"log2", logarithm_2, f1<logarithm_2>},
                                         {"sqrt", square_root, f1<square_root>},
                                         {"abs", absolute, f1<absolute>},
                                         {"sign", signum, f1<signum>},
                                         {"rint", round_to_integer, f1<round_to_integer>},
                                         {"floor", round_down, f1<round_down>},
                                         {"ceil", round_up, f1<round_up>}};

template <class F>
bool is(const mu::generic_callable_type& called, F* f) {
  return called._pRawFun == reinterpret_cast<mu::erased_fun_type>(f);
}

int function_code(const mu::generic_callable_type& called) {
  for (const NamedFunction& f : functions_1)
    if (is(called, f.f)) return f.code;
  if (is(called, f1<minus>)) return minus;
  if (is(called, f1<plus>)) return plus;
  if (is(called, f_atan2)) return arc_tangent_2;
  if (is(called, f_pow)) return power;
  if (is(called, f_mod)) return modulo;
  if (is(called, f_min)) return minimum;
  if (is(called, f_max)) return maximum;
  if (is(called, f_step)) return smooth_step;
  throw std::logic_error("an expression called a function without a translation");
}

int operator_code(mu::ECmdCode code) {
  switch (code) {
    case mu::cmLE:
      return less_equal;
    case mu::cmGE:
      return greater_equal;
    case mu::cmNEQ:
      return not_equal;
    case mu::cmEQ:
      return equal;
    case mu::cmLT:
      return less;
    case mu::cmGT:
      return greater;
    case mu::cmADD:
      return add;
    case mu::cmSUB:
      return subtract;
    case mu::cmMUL:
      return multiply;
    case mu::cmDIV:
      return divide;
    case mu::cmPOW:
      return power;
    case mu::cmLAND:
      return logical_and;
    case mu::cmLOR:
      return logical_or;
    default:
      throw std::logic_error("an expression holds an operation without a translation");
  }
}

constexpr std::size_t stack_size = 64;

/// The names in a formula, each once.  The parser is told of these alone: all that a file knows, for each of
/// its formulas, took a time that grew with the square of its length.
std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t start = text.find_first_not_of("0123456789.", i);  // "2load": the parser will object
    if (start == std::string::npos) break;
    std::size_t end = start;
    while (end < text.size() && input::is_name_character(text[end])) ++end;
    if (end > start) names.push_back(text.substr(start, end - start));
    i = std::max(end, start + 1);
  }
  std::ranges::sort(names);
  const auto again = std::ranges::unique(names);
  names.erase(again.begin(), again.end());
  return names;
}

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
  double plain = 0.0;
  if (const auto [end, failure] = std::from_chars(text_.data(), text_.data() + text_.size(), plain);
      failure == std::errc() && end == text_.data() + text_.size() && std::isfinite(plain)) {
    program_.push_back({.code = constant, .value = plain});
    FormulaNode number;
    number.code = constant;
    number.value = plain;
    tree_.root = tree_.add(std::move(number));
    return;
  }
  if (const std::string why = input::wrong_with_formula(text_); !why.empty()) refuse(why);

  const std::vector<std::string> names = names_in(text_);
  std::vector<int> places;  // of the signals that it reads
  for (const std::string& name : names)
    if (const int place = signals.find(name); place >= 0) places.push_back(place);
  std::vector<double> values(places.size(), 1.0);
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
    for (const NamedFunction& f : functions_1) known.push_back(f.name);
    known.insert(known.end(), {"atan2", "pow", "mod", "min", "max", "step", "pi", "e"});
    refuse(
        fmt::format("\"{}\" is not known here{}", input::shown_text(token), input::suggestion(token, known)));
  };
  mu::Parser parser;
  parser.EnableOptimizer(false);
  parser.ClearConst();
  parser.ClearFun();
  parser.ClearInfixOprt();
  parser.DefineNameChars(input::name_characters);
  try {
    for (const NamedFunction& f : functions_1) parser.DefineFun(f.name, f.f);
    parser.DefineFun("atan2", f_atan2);
    parser.DefineFun("pow", f_pow);
    parser.DefineFun("mod", f_mod);
    parser.DefineFun("min", f_min);
    parser.DefineFun("max", f_max);
    parser.DefineFun("step", f_step);
    for (const std::string& name : names)
      if (const auto found = tables.find(name); found != tables.end())
        parser.DefineFunUserData(name, f_table, const_cast<Curve*>(found->second.get()));
    parser.DefineInfixOprt("-", f1<minus>);
    parser.DefineInfixOprt("+", f1<plus>);
    if (!constants.contains("pi")) parser.DefineConst("pi", std::numbers::pi);
    if (!constants.contains("e")) parser.DefineConst("e", std::numbers::e);
    for (const std::string& name : names)
      if (const auto found = constants.find(name); found != constants.end())
        parser.DefineConst(name, found->second);
    for (std::size_t i = 0; i < places.size(); ++i) parser.DefineVar(signals.names()[places[i]], &values[i]);
    parser.SetExpr(text_);
    parser.Eval();
  } catch (const mu::Parser::exception_type& error) {
    if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN) refuse_unknown(error.GetToken());
    refuse(input::shown_text(error.GetMsg(), 160));
  }

  const mu::ParserByteCode& code = parser.GetByteCode();
  if (code.GetMaxStackSize() > stack_size)
    refuse("the formula is nested too deeply; take a part into a measure");
  const mu::SToken* token = code.GetBase();
  const int n = static_cast<int>(code.GetSize());
  // One instruction for each token, so that the offsets of jumps stay what they are.
  for (int i = 0; i < n && token[i].Cmd != mu::cmEND; ++i) {
    Instruction instruction{constant};
    switch (token[i].Cmd) {
      case mu::cmVAL:
        instruction.value = token[i].Val.data2;
        break;
      case mu::cmVAR: {
        instruction.code = signal;
        instruction.place = places[static_cast<std::size_t>(token[i].Val.ptr - values.data())];
        reads_time_ = reads_time_ || instruction.place == 0;
        if (instruction.place > 0 && std::ranges::find(reads_, instruction.place) == reads_.end())
          reads_.push_back(instruction.place);
        break;
      }
      case mu::cmIF:
        instruction = {jump_if_zero, i + token[i].Oprt.offset};
        break;
      case mu::cmELSE:
        instruction = {jump, i + token[i].Oprt.offset};
        break;
      case mu::cmENDIF:
        instruction = {jump, i};
        break;
      case mu::cmFUNC:
        if (is(token[i].Fun.cb, f_table)) {
          instruction = {table, static_cast<int>(tables_.size())};
          for (const auto& [name, curve] : tables)
            if (curve.get() == token[i].Fun.cb._pUserData) tables_.push_back(curve);
          break;
        }
        instruction = {function_code(token[i].Fun.cb), std::abs(token[i].Fun.argc)};
        break;
      default:
        instruction.code = operator_code(token[i].Cmd);
    }
    program_.push_back(instruction);
  }
  std::vector<int> stack, node_of(program_.size(), -1);
  build_tree(0, program_.size(), stack, node_of);
  tree_.root = stack.back();
  if (held) find_conditions(*held, node_of);
}

// ~moving in place of moving: kinks are not held.
template <class T>
T Expression::run(const double* signals, const T& time, int moving) const {
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
        if constexpr (std::is_same_v<T, Jet>)
          if (in.place != 0 && in.place == moving) stack[top].first = 1.0;
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

double Expression::evaluate(const double* signals) const {
  double value = run<double>(signals, signals[0]);
  // A trial step beyond a kink that is held may leave where the formula has values: max(0, x)^1.5.
  if (!std::isfinite(value)) value = run<double>(signals, signals[0], ~0);
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

}  // namespace flexura::mbs
