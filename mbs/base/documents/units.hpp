// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

/// Quantities in input files: "210 GPa", "7850 kg/m^3", "12 mm", "30 deg".  Everything inside the programs is
/// SI.
namespace flexura::input {

/// Exponents of m, kg, s, rad (angles are kept apart from plain numbers so that a "deg" cannot pass for a
/// length).
struct Dimension {
  std::array<int, 4> exponent{};
  friend bool operator==(const Dimension&, const Dimension&) = default;
};

namespace dim {
inline constexpr Dimension none{{0, 0, 0, 0}}, length{{1, 0, 0, 0}}, mass{{0, 1, 0, 0}}, time{{0, 0, 1, 0}},
    angle{{0, 0, 0, 1}}, area{{2, 0, 0, 0}}, volume{{3, 0, 0, 0}}, density{{-3, 1, 0, 0}},
    velocity{{1, 0, -1, 0}}, acceleration{{1, 0, -2, 0}}, angular_velocity{{0, 0, -1, 1}},
    angular_acceleration{{0, 0, -2, 1}}, force{{1, 1, -2, 0}}, torque{{2, 1, -2, 0}},
    pressure{{-1, 1, -2, 0}}, frequency{{0, 0, -1, 0}}, inertia{{2, 1, 0, 0}}, stiffness{{0, 1, -2, 0}},
    damping{{0, 1, -1, 0}}, angular_stiffness{{2, 1, -2, -1}}, angular_damping{{2, 1, -1, -1}},
    area_moment{{4, 0, 0, 0}}, linear_density{{-1, 1, 0, 0}}, energy{{2, 1, -2, 0}}, power{{2, 1, -3, 0}};
}  // namespace dim

/// "m/s^2", "rad/s", ... in SI base and common derived units.
std::string si_unit(const Dimension& dimension);

/// What a dimension is called, with its article: "a length", "an angle"; "a quantity in m*kg" when it has no
/// name.
std::string kind_name(const Dimension& dimension);

/// A number as it stands in the file, in SI, with the dimension its unit gives it.
struct Measured {
  double value = 0.0;
  Dimension dimension;
  bool has_unit = false;
};

/// "12 mm" or "3.5"; nothing when the text is something else (a formula, a name).
std::optional<Measured> try_parse_measured(std::string_view text);

/// SI value of one unit of this expression, "N*mm/rad"; throws std::invalid_argument like parse_quantity.
Measured parse_unit(std::string_view text);

/// Throws std::invalid_argument unless a quantity of this dimension may stand where `wanted` is asked for.
/// A bare number is taken as SI.  "per radian" may be left out (N m for N m/rad), since that is common
/// writing; a wanted radian may not (1/s or Hz for an angular velocity could as well mean revolutions).
void check_kind(const Measured& quantity, const Dimension& wanted);

/// Parses a number with an optional unit; a bare number is SI.  Units are products and quotients with powers
/// ("kg/m^3", "N*mm/rad", "1/s") of prefixed names.  Throws std::invalid_argument whose text names what is
/// wrong and a remedy: unknown unit ("did you mean ...?"), wrong kind ("is a mass, a length is wanted, like
/// \"12 mm\"").
double parse_quantity(std::string_view text, const Dimension& wanted);

}  // namespace flexura::input
