// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/units.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "mbs/base/documents/document.hpp"

namespace flexura::input {
namespace {

using ::testing::HasSubstr;

std::string refusal(std::string_view text, const Dimension& wanted) {
  try {
    parse_quantity(text, wanted);
  } catch (const std::invalid_argument& failure) {
    return failure.what();
  }
  return "accepted";
}

// Two factors and a power, each rounded once: four units in the last place.
TEST(Units, ValuesAreTheDefinedOnes) {
  constexpr double pi = std::numbers::pi;
  EXPECT_DOUBLE_EQ(parse_quantity("12 mm", dim::length), 0.012);
  EXPECT_DOUBLE_EQ(parse_quantity("12mm", dim::length), 0.012);
  EXPECT_DOUBLE_EQ(parse_quantity("210 GPa", dim::pressure), 2.1e11);
  EXPECT_DOUBLE_EQ(parse_quantity("7.85 g/cm^3", dim::density), 7850.0);
  EXPECT_DOUBLE_EQ(parse_quantity("7.85 t/m3", dim::density), 7850.0);
  EXPECT_DOUBLE_EQ(parse_quantity("80 mm²", dim::area), 80e-6);
  EXPECT_DOUBLE_EQ(parse_quantity("1 in^4", dim::area_moment), 0.0254 * 0.0254 * 0.0254 * 0.0254);
  EXPECT_DOUBLE_EQ(parse_quantity("180 deg", dim::angle), pi);
  EXPECT_DOUBLE_EQ(parse_quantity("600 rpm", dim::angular_velocity), 20 * pi);
  EXPECT_DOUBLE_EQ(parse_quantity("10 rev/s", dim::angular_velocity), 20 * pi);
  EXPECT_DOUBLE_EQ(parse_quantity("1.5 kHz", dim::frequency), 1500.0);
  EXPECT_DOUBLE_EQ(parse_quantity("6 bar", dim::pressure), 6e5);
  EXPECT_DOUBLE_EQ(parse_quantity("2 l", dim::volume), 2e-3);
  EXPECT_DOUBLE_EQ(parse_quantity("20 N/mm", dim::stiffness), 2e4);
  EXPECT_DOUBLE_EQ(parse_quantity("5 N*mm/deg", dim::angular_stiffness), 5e-3 * 180 / pi);
  EXPECT_DOUBLE_EQ(parse_quantity("3 kg/(m*s^2)", dim::pressure), 3.0);
  EXPECT_DOUBLE_EQ(parse_quantity("9.81 m s^-2", dim::acceleration), 9.81);
  EXPECT_DOUBLE_EQ(parse_quantity("-2.5e3", dim::force), -2500.0);
  EXPECT_DOUBLE_EQ(parse_quantity("3 %", dim::none), 0.03);
  // BIPM and NIST SP 811, appendix B.8: 1 psi = 6894.757 Pa, 1 lbf = 4.448222 N, 1 ft = 0.3048 m, printed
  // digits.
  EXPECT_NEAR(parse_quantity("1 psi", dim::pressure), 6894.757, 5e-4);
  EXPECT_NEAR(parse_quantity("1 lbf", dim::force), 4.448222, 5e-7);
  EXPECT_NEAR(parse_quantity("1 ft", dim::length), 0.3048, 1e-15);
  for (const char* name : {"in", "inch"})
    EXPECT_NEAR(parse_quantity(std::string("1 ") + name, dim::length), 0.0254, 1e-15);
}

TEST(Units, PerRadianMayBeLeftOutButARadianMayNot) {
  EXPECT_DOUBLE_EQ(parse_quantity("5 N*m", dim::angular_stiffness), 5.0);
  EXPECT_DOUBLE_EQ(parse_quantity("5 N*m*s", dim::angular_damping), 5.0);
  EXPECT_THAT(refusal("5 1/s", dim::angular_velocity),
              HasSubstr("is a frequency, an angular velocity is wanted, like \"600 rpm\""));
  EXPECT_THAT(refusal("5 Hz", dim::angular_velocity),
              HasSubstr("one hertz as a speed of rotation is \"1 rev/s\""));
  EXPECT_THAT(refusal("5 rad/s", dim::frequency), HasSubstr("is an angular velocity, a frequency is wanted"));
  EXPECT_THAT(refusal("5 deg", dim::length), HasSubstr("is an angle, a length is wanted, like \"12 mm\""));
  EXPECT_THAT(refusal("5 N*m/rad", dim::torque), HasSubstr("is a torsional stiffness, a torque is wanted"));
}

TEST(Units, RefusalsNameTheKindAndTheRemedy) {
  EXPECT_EQ(refusal("12 kg", dim::length), "is a mass, a length is wanted, like \"12 mm\"");
  EXPECT_EQ(refusal("12 Mpa", dim::pressure), "has the unknown unit \"Mpa\", did you mean \"MPa\"?");
  EXPECT_EQ(refusal("3 newton", dim::force).substr(0, 29), "has the unknown unit \"newton\"");
  EXPECT_THAT(refusal("7850 kg/m^", dim::density), HasSubstr("has the malformed unit \"kg/m^\""));
  EXPECT_THAT(refusal("7850 kg//m", dim::density), HasSubstr("malformed unit"));
  EXPECT_THAT(refusal("steel", dim::density),
              HasSubstr("is not a number with a unit, a density is wanted, like \"7850 kg/m^3\""));
  EXPECT_THAT(refusal("", dim::length), HasSubstr("is not a number with a unit"));
  EXPECT_THAT(refusal("1e999 m", dim::length), HasSubstr("is not a number"));
  EXPECT_THAT(refusal("1e300 Tm^2", dim::area), HasSubstr("is not finite"));
  EXPECT_THAT(refusal("nan", dim::length), HasSubstr("is not a number"));
  EXPECT_THAT(refusal("2 s^2", dim::length), HasSubstr("is a quantity in s^2, a length is wanted"));
}

TEST(Units, FormulasAreNoQuantities) {
  EXPECT_TRUE(try_parse_measured("12 mm"));
  EXPECT_TRUE(try_parse_measured("-4"));
  EXPECT_FALSE(try_parse_measured("2*t"));
  EXPECT_FALSE(try_parse_measured("sin(t)"));
  EXPECT_FALSE(try_parse_measured("4 - t"));
  EXPECT_FALSE(try_parse_measured("2 newton"));
}

TEST(Units, EverySiUnitReadsBackAsItself) {
  for (const Dimension& dimension : {dim::length,
                                     dim::mass,
                                     dim::time,
                                     dim::angle,
                                     dim::area,
                                     dim::volume,
                                     dim::density,
                                     dim::velocity,
                                     dim::acceleration,
                                     dim::angular_velocity,
                                     dim::angular_acceleration,
                                     dim::force,
                                     dim::torque,
                                     dim::pressure,
                                     dim::frequency,
                                     dim::inertia,
                                     dim::stiffness,
                                     dim::damping,
                                     dim::angular_stiffness,
                                     dim::angular_damping,
                                     dim::area_moment,
                                     dim::linear_density,
                                     dim::power,
                                     Dimension{{3, -1, 2, -2}}}) {
    EXPECT_DOUBLE_EQ(parse_quantity("7 " + si_unit(dimension), dimension), 7.0) << si_unit(dimension);
    const Measured unit = parse_unit(si_unit(dimension));
    EXPECT_EQ(unit.dimension, dimension) << si_unit(dimension);
  }
}

TEST(Nearest, FindsSlipsAndNothingElse) {
  const std::vector<std::string> known = {"density", "young", "poisson", "damping"};
  EXPECT_EQ(nearest("densty", known), "density");
  EXPECT_EQ(nearest("Density", known), "density");
  EXPECT_EQ(nearest("pioson", known), "poisson");
  EXPECT_EQ(nearest("damp", known), "damping");
  EXPECT_EQ(nearest("colour", known), "");
  EXPECT_EQ(suggestion("colour", known), "; known are density, young, poisson, damping");
  EXPECT_EQ(suggestion("yuong", known), ", did you mean \"young\"?");
}

}  // namespace
}  // namespace flexura::input
