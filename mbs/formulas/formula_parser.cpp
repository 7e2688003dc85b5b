// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/formula_parser.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "mbs/base/documents/formula_text.hpp"
#include "mbs/base/documents/shown_text.hpp"
#include "mbs/base/documents/units.hpp"
#include "mbs/formulas/operations.hpp"

namespace flexura::mbs {
namespace {

using namespace operations;

struct NamedFunction {
  std::string_view name;
  int code;
  int n_args = 1;  // -1: one or more
};
constexpr NamedFunction functions[] = {
    {"sin", sine},           {"cos", cosine},         {"tan", tangent},
    {"asin", arc_sine},      {"acos", arc_cosine},    {"atan", arc_tangent},
    {"sinh", sinh},          {"cosh", cosh},          {"tanh", tanh},
    {"asinh", asinh},        {"acosh", acosh},        {"atanh", atanh},
    {"exp", exponential},    {"ln", logarithm},       {"log", logarithm},
    {"log10", logarithm_10}, {"log2", logarithm_2},   {"sqrt", square_root},
    {"abs", absolute},       {"sign", signum},        {"rint", round_to_integer},
    {"floor", round_down},   {"ceil", round_up},      {"atan2", arc_tangent_2, 2},
    {"pow", power, 2},       {"mod", modulo, 2},      {"min", minimum, -1},
    {"max", maximum, -1},    {"step", smooth_step, 5}};

struct BinarySign {
  std::string_view sign;
  int code;
};
// A level of the grammar: signs that bind alike.
using Level = std::vector<BinarySign>;
const Level kLevels[] = {{{"||", logical_or}},
                         {{"&&", logical_and}},
                         // Longer ones first: "<=" is no "<".
                         {{"<=", less_equal},
                          {">=", greater_equal},
                          {"==", equal},
                          {"!=", not_equal},
                          {"<", less},
                          {">", greater}},
                         {{"+", add}, {"-", subtract}},
                         {{"*", multiply}, {"/", divide}}};

class Parser {
 public:
  Parser(const std::string& text, const FormulaNames& names) : text_(text), names_(names) {}

  FormulaTree parse() {
    tree_.root = choice_();
    skip_blanks();
    if (at_ < text_.size())
      refuse_here(text_[at_] == ')' ? "there is no \"(\" to it" : "an operator is missing before it");
    return std::move(tree_);
  }

 private:
  // The name that begins here, or the one character.
  std::string word_here() const {
    std::size_t end = at_ + 1;
    if (at_ < text_.size() && input::is_name_character(text_[at_]))
      while (end < text_.size() && input::is_name_character(text_[end])) ++end;
    return text_.substr(at_, end - at_);
  }
  // "30*t deg" is written as "30 deg" is, which is a quantity and no formula.
  void refuse_unit() {
    skip_blanks();
    if (at_ == text_.size() || !input::is_name_character(text_[at_]) ||
        (text_[at_] >= '0' && text_[at_] <= '9'))
      return;
    double factor = 0.0;
    try {
      factor = input::parse_unit(word_here()).value;
    } catch (const std::invalid_argument&) {
      return;
    }
    refuse_here(fmt::format(
        "a unit stands behind a number alone, as in \"30 deg\", and formulas are in SI units (m, rad, s, "
        "kg): multiply what it belongs to by {:.12g}",
        factor));
  }
  [[noreturn]] void refuse_here(const std::string& why) const {
    const std::string what =
        at_ < text_.size() ? fmt::format("at character {}, \"{}\"", at_ + 1, input::shown_text(word_here()))
                           : "at its end";
    throw std::invalid_argument(fmt::format("{}: {}", what, why));
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }
  bool take(std::string_view sign) {
    skip_blanks();
    if (std::string_view(text_).substr(at_, sign.size()) != sign) return false;
    at_ += sign.size();
    return true;
  }

  int add_node(int code, std::vector<int> args) {
    FormulaNode node;
    node.code = code;
    node.args = std::move(args);
    return tree_.add(std::move(node));
  }

  // Counts nested calls: texts of parentheses alone would take the stack.
  struct Depth {
    explicit Depth(int& n) : n_(n) {
      if (++n_ > 400)
        throw std::invalid_argument("the formula is nested too deeply; take a part into a measure");
    }
    ~Depth() { --n_; }
    int& n_;
  };

  int choice_() {
    const Depth depth(depth_);
    const int condition = binary(0);
    if (!take("?")) return condition;
    const int yes = choice_();
    if (!take(":")) refuse_here("a \":\" and what holds otherwise are missing after \"?\"");
    const int no = choice_();
    return add_node(choice, {condition, yes, no});
  }

  int binary(std::size_t level) {
    if (level == std::size(kLevels)) return signed_();
    int left = binary(level + 1);
    for (;;) {
      const BinarySign* found = nullptr;
      for (const BinarySign& sign : kLevels[level])
        if (!found && take(sign.sign)) found = &sign;
      if (!found) return left;
      const int right = binary(level + 1);
      left = add_node(found->code, {left, right});
    }
  }

  int signed_() {
    const Depth depth(depth_);
    if (take("-")) return add_node(minus, {signed_()});
    if (take("+")) return add_node(plus, {signed_()});
    return power_();
  }

  int power_() {
    const int base = primary();
    refuse_unit();
    if (!take("^")) return base;
    const int exponent = exponent_();
    return add_node(power, {base, exponent});
  }

  int exponent_() {
    const Depth depth(depth_);
    if (take("-")) return add_node(minus, {exponent_()});
    if (take("+")) return add_node(plus, {exponent_()});
    return power_();
  }

  int primary() {
    if (take("(")) {
      const int inside = choice_();
      if (!take(")")) refuse_here("a \")\" is missing");
      return inside;
    }
    skip_blanks();
    if (at_ == text_.size()) refuse_here("a number, a name or a \"(\" is missing");
    const char c = text_[at_];
    if ((c >= '0' && c <= '9') || c == '.') return number();
    if (!input::is_name_character(c)) refuse_here("a number, a name or a \"(\" is missing before it");
    const std::size_t start = at_;
    while (at_ < text_.size() && input::is_name_character(text_[at_])) ++at_;
    const std::string name = text_.substr(start, at_ - start);
    if (take("(")) return call(name);
    const std::optional<FormulaNode> value = names_.value(name);
    if (!value) {
      for (const NamedFunction& f : functions)
        if (f.name == name)
          refuse_here(fmt::format("the function {} needs its arguments in parentheses", name));
      throw UnknownName(name);
    }
    return tree_.add(*value);
  }

  int number() {
    double value = 0.0;
    const auto [end, failure] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
    if (failure != std::errc() || !std::isfinite(value))
      refuse_here("is no number that can be computed with");
    const auto next = static_cast<std::size_t>(end - text_.data());
    if (next < text_.size() && input::is_name_character(text_[next])) {
      const std::size_t start = std::exchange(at_, next);
      refuse_unit();
      at_ = start;
      refuse_here("a name begins with a letter, a product needs a \"*\"");
    }
    at_ = next;
    FormulaNode node;
    node.code = constant;
    node.value = value;
    return tree_.add(std::move(node));
  }

  int call(const std::string& name) {
    std::vector<int> args;
    if (!take(")")) {
      do args.push_back(choice_());
      while (take(","));
      if (!take(")")) refuse_here(fmt::format("the \")\" of {} is missing", input::shown_text(name)));
    }
    const auto require = [&](int wanted) {
      if (wanted < 0 ? args.empty() : static_cast<int>(args.size()) != wanted)
        throw std::invalid_argument(fmt::format("{} takes {}, not {}", input::shown_text(name),
                                                wanted < 0    ? "one argument or more"
                                                : wanted == 1 ? "1 argument"
                                                              : fmt::format("{} arguments", wanted),
                                                args.size()));
    };
    for (const NamedFunction& f : functions) {
      if (f.name != name) continue;
      require(f.n_args);
      return add_node(f.code, std::move(args));
    }
    FormulaNode node;
    node.curve = names_.table(name);
    if (!node.curve) {
      if (names_.value(name))
        throw std::invalid_argument(
            fmt::format("{} is no function; a product needs a \"*\"", input::shown_text(name)));
      throw UnknownName(name);
    }
    require(1);
    node.code = table;
    node.args = std::move(args);
    return tree_.add(std::move(node));
  }

  const std::string& text_;
  const FormulaNames& names_;
  std::size_t at_ = 0;
  int depth_ = 0;
  FormulaTree tree_;
};

}  // namespace

FormulaTree parse_formula(const std::string& text, const FormulaNames& names) {
  if (const std::string why = input::wrong_with_formula(text); !why.empty()) throw std::invalid_argument(why);
  return Parser(text, names).parse();
}

std::vector<std::string> function_names() {
  std::vector<std::string> names;
  for (const NamedFunction& f : functions) names.emplace_back(f.name);
  return names;
}

}  // namespace flexura::mbs
