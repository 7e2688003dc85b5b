// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/units.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numbers>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/base/documents/shown_text.hpp"

namespace flexura::input {
namespace {

struct Unit {
  std::string_view name;
  double factor;  // to SI
  Dimension dimension;
  bool takes_prefix = false;
};

constexpr double pi = std::numbers::pi;
constexpr double inch = 0.0254, pound = 0.45359237, standard_gravity = 9.80665;  // exact by definition
constexpr double pound_force = pound * standard_gravity;

// Exact names are looked up before prefixed ones, so "min" is a minute and "Pa" no pico-ampere.
constexpr Unit units[] = {
    {"m", 1, dim::length, true},
    {"g", 1e-3, dim::mass, true},
    {"s", 1, dim::time, true},
    {"rad", 1, dim::angle, true},
    {"N", 1, dim::force, true},
    {"Pa", 1, dim::pressure, true},
    {"J", 1, dim::energy, true},
    {"W", 1, dim::power, true},
    {"Hz", 1, dim::frequency, true},
    {"bar", 1e5, dim::pressure, true},
    {"l", 1e-3, dim::volume, true},
    {"L", 1e-3, dim::volume, true},
    {"t", 1e3, dim::mass},
    {"min", 60, dim::time},
    {"h", 3600, dim::time},
    {"deg", pi / 180, dim::angle},
    {"°", pi / 180, dim::angle},
    {"rev", 2 * pi, dim::angle},
    {"rpm", 2 * pi / 60, dim::angular_velocity},
    {"in", inch, dim::length},
    {"inch", inch, dim::length},
    {"ft", 12 * inch, dim::length},
    {"lb", pound, dim::mass},
    {"lbf", pound_force, dim::force},
    {"kgf", standard_gravity, dim::force},
    {"psi", pound_force / (inch * inch), dim::pressure},
    {"ksi", 1e3 * pound_force / (inch * inch), dim::pressure},
    {"gn", standard_gravity, dim::acceleration},
    {"%", 1e-2, dim::none},
};

struct Prefix {
  std::string_view name;
  double factor;
};

constexpr Prefix prefixes[] = {{"p", 1e-12}, {"n", 1e-9}, {"u", 1e-6}, {"µ", 1e-6}, {"μ", 1e-6},
                               {"m", 1e-3},  {"c", 1e-2}, {"d", 1e-1}, {"h", 1e2},  {"k", 1e3},
                               {"M", 1e6},   {"G", 1e9},  {"T", 1e12}};

struct KindName {
  Dimension dimension;
  std::string_view name, unit, example;
};

// The first entry of a dimension names it; N m is a torque before it is an energy.
constexpr KindName kinds[] = {
    {dim::none, "a plain number", "", "0.3"},
    {dim::length, "a length", "m", "12 mm"},
    {dim::mass, "a mass", "kg", "250 g"},
    {dim::time, "a time", "s", "10 ms"},
    {dim::angle, "an angle", "rad", "30 deg"},
    {dim::area, "an area", "m^2", "80 mm^2"},
    {dim::volume, "a volume", "m^3", "1.5 l"},
    {dim::density, "a density", "kg/m^3", "7850 kg/m^3"},
    {dim::velocity, "a velocity", "m/s", "0.5 m/s"},
    {dim::acceleration, "an acceleration", "m/s^2", "9.81 m/s^2"},
    {dim::angular_velocity, "an angular velocity", "rad/s", "600 rpm"},
    {dim::angular_acceleration, "an angular acceleration", "rad/s^2", "5 rad/s^2"},
    {dim::force, "a force", "N", "2 kN"},
    {dim::torque, "a torque", "N*m", "12 N*m"},
    {dim::pressure, "a pressure", "Pa", "210 GPa"},
    {dim::frequency, "a frequency", "Hz", "800 Hz"},
    {dim::inertia, "a moment of inertia", "kg*m^2", "0.02 kg*m^2"},
    {dim::stiffness, "a stiffness", "N/m", "20 N/mm"},
    {dim::damping, "a damping constant", "N*s/m", "15 N*s/m"},
    {dim::angular_stiffness, "a torsional stiffness", "N*m/rad", "50 N*m/rad"},
    {dim::angular_damping, "a torsional damping constant", "N*m*s/rad", "0.1 N*m*s/rad"},
    {dim::area_moment, "an area moment", "m^4", "1200 mm^4"},
    {dim::linear_density, "a mass per length", "kg/m", "2.5 kg/m"},
    {dim::power, "a power", "W", "3 kW"},
};

const KindName* find_kind(const Dimension& dimension) {
  for (const KindName& kind : kinds) {
    if (kind.dimension == dimension) return &kind;
  }
  return nullptr;
}

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '%' ||
         static_cast<unsigned char>(c) >= 0x80;
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}
bool is_space(char c) {
  return c == ' ' || c == '\t';
}

std::optional<Measured> find_unit(std::string_view name) {
  for (const Unit& unit : units) {
    if (unit.name == name) return Measured{unit.factor, unit.dimension, true};
  }
  for (const Prefix& prefix : prefixes) {
    if (!name.starts_with(prefix.name)) continue;
    for (const Unit& unit : units) {
      if (unit.takes_prefix && unit.name == name.substr(prefix.name.size())) {
        return Measured{prefix.factor * unit.factor, unit.dimension, true};
      }
    }
  }
  return std::nullopt;
}

std::vector<std::string> known_units() {
  std::vector<std::string> names;
  for (const Unit& unit : units) names.emplace_back(unit.name);
  for (const Unit& unit : units) {
    if (!unit.takes_prefix) continue;
    for (const Prefix& prefix : prefixes) names.push_back(std::string(prefix.name) + std::string(unit.name));
  }
  return names;
}

std::string unknown_unit(std::string_view name) {
  std::string message = fmt::format("has the unknown unit \"{}\"", shown_text(name, 40));
  if (const std::string near = nearest(std::string(name), known_units()); !near.empty()) {
    return message + fmt::format(", did you mean \"{}\"?", near);
  }
  return message +
         "; known are m, g, s, rad, N, Pa, J, W, Hz, bar, l with prefixes, and t, min, h, deg, rev, rpm, in, "
         "ft, lb, lbf, psi, %";
}

void multiply(Measured& product, const Measured& factor, int power) {
  product.value *= std::pow(factor.value, power);
  for (std::size_t i = 0; i < product.dimension.exponent.size(); ++i) {
    product.dimension.exponent[i] += power * factor.dimension.exponent[i];
  }
}

// unit    = factor { ("*" | "·" | space | "/") factor }, from left to right: N/m*s is (N/m) s
// factor  = ( name | "1" | "(" unit ")" ) [ ["^"] integer ]
class UnitParser {
 public:
  explicit UnitParser(std::string_view text) : text_(text) {}

  Measured parse() {
    Measured product = parse_product(0);
    if (!rest().empty()) malformed();
    return product;
  }

 private:
  static constexpr int deepest = 20;  // parentheses; bounds the recursion on hostile input

  Measured parse_product(int depth) {
    Measured product{1.0, dim::none, true};
    int sign = 1;
    for (;;) {
      skip_space();
      const Measured factor = parse_factor(depth);
      multiply(product, factor, sign * parse_power());
      skip_space();
      if (rest().empty() || rest().front() == ')') return product;
      sign = accept("/") ? -1 : 1;
      if (sign > 0 && !accept("*")) accept("·");
    }
  }

  Measured parse_factor(int depth) {
    if (accept("(")) {
      if (depth == deepest) malformed();
      Measured inner = parse_product(depth + 1);
      if (!accept(")")) malformed();
      return inner;
    }
    if (accept("1")) return {1.0, dim::none, true};
    const std::size_t start = at_;
    while (at_ < text_.size() && is_letter(text_[at_]) && !rest().starts_with("²") &&
           !rest().starts_with("³") && !rest().starts_with("·")) {
      ++at_;
    }
    const std::string_view name = text_.substr(start, at_ - start);
    if (name.empty()) malformed();
    if (const auto unit = find_unit(name)) return *unit;
    throw std::invalid_argument(unknown_unit(name));
  }

  int parse_power() {
    if (accept("²")) return 2;
    if (accept("³")) return 3;
    const bool hat = accept("^");
    if (!hat && (rest().empty() || !(is_digit(rest().front()) || rest().front() == '-'))) return 1;
    int power = 0;
    const auto [end, failure] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), power);
    if (failure != std::errc() || std::abs(power) > 12) malformed();
    at_ = static_cast<std::size_t>(end - text_.data());
    return power;
  }

  bool accept(std::string_view token) {
    if (!rest().starts_with(token)) return false;
    at_ += token.size();
    return true;
  }
  void skip_space() {
    while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  }
  std::string_view rest() const { return text_.substr(at_); }
  [[noreturn]] void malformed() const {
    throw std::invalid_argument(
        fmt::format("has the malformed unit \"{}\"; write for example \"kg/m^3\" or \"N*mm/rad\"",
                    shown_text(text_, 40)));
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

struct Split {
  double number;
  std::string_view unit;
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

std::optional<Split> split_number(std::string_view text) {
  text = trimmed(text);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  if (text.empty() || !(is_digit(text.front()) || text.front() == '-' || text.front() == '.'))
    return std::nullopt;
  double number = 0.0;
  const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failure != std::errc() || !std::isfinite(number)) return std::nullopt;
  return Split{number, trimmed(text.substr(static_cast<std::size_t>(end - text.data())))};
}

Measured with_unit(const Split& split) {
  if (split.unit.empty()) return {split.number, dim::none, false};
  if (split.unit.front() == ',')
    throw std::invalid_argument(
        "has a comma behind the number; the decimal sign is a point, like \"0.5 mm\"");
  Measured unit = UnitParser(split.unit).parse();
  unit.value *= split.number;
  return unit;
}

}  // namespace

std::string si_unit(const Dimension& dimension) {
  if (const KindName* kind = find_kind(dimension)) return std::string(kind->unit);
  constexpr std::string_view base[] = {"m", "kg", "s", "rad"};
  std::string above, below;
  for (std::size_t i = 0; i < dimension.exponent.size(); ++i) {
    const int e = dimension.exponent[i];
    if (e == 0) continue;
    std::string& side = e > 0 ? above : below;
    side += (side.empty() ? "" : e > 0 ? "*" : "/") + std::string(base[i]);
    if (std::abs(e) > 1) side += fmt::format("^{}", std::abs(e));
  }
  if (above.empty()) above = "1";
  return below.empty() ? above : above + "/" + below;
}

std::string kind_name(const Dimension& dimension) {
  if (const KindName* kind = find_kind(dimension)) return std::string(kind->name);
  return "a quantity in " + si_unit(dimension);
}

std::optional<Measured> try_parse_measured(std::string_view text) {
  const auto split = split_number(text);
  if (!split) return std::nullopt;
  // In a formula an operator follows the number ("2*t"); a unit starts with a letter, or is "1/s".
  if (!split->unit.empty() && !is_letter(split->unit.front()) && !split->unit.starts_with("1/"))
    return std::nullopt;
  try {
    return with_unit(*split);
  } catch (const std::invalid_argument&) {
    return std::nullopt;
  }
}

Measured parse_unit(std::string_view text) {
  return UnitParser(trimmed(text)).parse();
}

void check_kind(const Measured& quantity, const Dimension& wanted) {
  if (!quantity.has_unit || quantity.dimension == wanted) return;
  Dimension per_radian_left_out = wanted;
  if (wanted.exponent[3] < 0) per_radian_left_out.exponent[3] = 0;
  if (quantity.dimension == per_radian_left_out) return;

  std::string example;
  if (const KindName* kind = find_kind(wanted)) {
    example = kind->example;
  } else {
    example = "1 " + si_unit(wanted);
  }
  std::string remedy = fmt::format(", {} is wanted, like \"{}\"", kind_name(wanted), example);
  if (wanted == dim::angular_velocity && quantity.dimension == dim::frequency) {
    remedy += "; one hertz as a speed of rotation is \"1 rev/s\"";
  }
  throw std::invalid_argument("is " + kind_name(quantity.dimension) + remedy);
}

double parse_quantity(std::string_view text, const Dimension& wanted) {
  const auto split = split_number(text);
  if (!split) {
    const KindName* kind = find_kind(wanted);
    throw std::invalid_argument(fmt::format("is not a number with a unit, {} is wanted, like \"{}\"",
                                            kind_name(wanted),
                                            kind ? std::string(kind->example) : "1 " + si_unit(wanted)));
  }
  const Measured quantity = with_unit(*split);
  check_kind(quantity, wanted);
  if (!std::isfinite(quantity.value))
    throw std::invalid_argument("is not finite in SI units; use a smaller number");
  return quantity.value;
}

}  // namespace flexura::input
