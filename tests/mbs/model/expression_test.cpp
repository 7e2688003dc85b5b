// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/formulas/expression.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace flexura::mbs {
namespace {

const std::map<std::string, double> parameters = {{"load", 3.0}, {"omega", 2.0}};

double value(const std::string& text, double t = 0.0) {
  const SignalNames names;
  return Expression("force.f", text, names, parameters).evaluate(&t);
}

std::string refusal(const std::string& text) {
  SignalNames names;
  names.add("crank.angle");
  names.add("crank.speed");
  try {
    Expression("force.f.value", text, names, parameters);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return {};
}

TEST(Expression, EvaluatesArithmeticAndFunctions) {
  EXPECT_DOUBLE_EQ(value("1 + 2*3 - 4/8"), 6.5);
  EXPECT_DOUBLE_EQ(value("-2^2"), -4.0);
  EXPECT_DOUBLE_EQ(value("2^-1"), 0.5);
  EXPECT_DOUBLE_EQ(value("2^3^2"), 512.0);
  EXPECT_DOUBLE_EQ(value("load*omega"), 6.0);
  EXPECT_DOUBLE_EQ(value("sin(pi/2) + cos(0) + ln(e)"), 3.0);
  EXPECT_DOUBLE_EQ(value("min(3, 1, 2) + 10*max(3, 5)"), 51.0);
  EXPECT_DOUBLE_EQ(value("t > 1 ? 10 : 20", 2.0), 10.0);
  EXPECT_DOUBLE_EQ(value("t > 1 ? 10 : 20", 0.5), 20.0);
  EXPECT_DOUBLE_EQ(value("(t > 1 ? 1 : t < -1 ? -1 : t) + 100", -3.0), 99.0);
  EXPECT_DOUBLE_EQ(value("t >= 1 && t <= 2 || t == 5", 1.5), 1.0);
  EXPECT_DOUBLE_EQ(value("t != 5", 5.0), 0.0);
  EXPECT_DOUBLE_EQ(value("step(t, 0, 1, 2, 5)", 1.0), 3.0);
  EXPECT_DOUBLE_EQ(value("step(t, 0, 1, 2, 5)", 9.0), 5.0);
  EXPECT_DOUBLE_EQ(value("atan2(1, -1)"), 0.75 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(value("pow(2, 10) + sqrt(16) + abs(-3) + sign(-2)"), 1030.0);
  EXPECT_DOUBLE_EQ(value("floor(-1.5) + 10*ceil(-1.5) + 100*rint(2.6)"), 288.0);
  EXPECT_DOUBLE_EQ(value("mod(7, 3) + 10*mod(-1, 3) + 100*mod(1, -3)"), -179.0);
}

// The grammar of formula_parser.hpp: which signs bind tighter, and from which side they group.
TEST(Expression, GroupsAsTheGrammarSays) {
  EXPECT_DOUBLE_EQ(value("10 - 4 - 3"), 3.0);
  EXPECT_DOUBLE_EQ(value("64/4/2"), 8.0);
  EXPECT_DOUBLE_EQ(value("2 + 3*4^2/8"), 8.0);
  EXPECT_DOUBLE_EQ(value("-2*-3"), 6.0);
  EXPECT_DOUBLE_EQ(value("2*-3^2"), -18.0);
  EXPECT_DOUBLE_EQ(value("2^-2^2"), 0.0625);
  EXPECT_DOUBLE_EQ(value("- -2 - +1"), 1.0);
  EXPECT_DOUBLE_EQ(value("1 + 1 < 3"), 1.0);
  EXPECT_DOUBLE_EQ(value("3 > 2 > 1"), 0.0);  // (3 > 2) > 1
  EXPECT_DOUBLE_EQ(value("0 && 0 || 1"), 1.0);
  EXPECT_DOUBLE_EQ(value("1 || 0 && 0"), 1.0);
  EXPECT_DOUBLE_EQ(value("0 ? 1 : 1 ? 2 : 3"), 2.0);
  EXPECT_DOUBLE_EQ(value("1 ? 0 ? 1 : 2 : 3"), 2.0);
  EXPECT_DOUBLE_EQ(value("1 < 2 ? 5 + 1 : 7"), 6.0);
  EXPECT_DOUBLE_EQ(value("max(1, 2 ? 3 : 4)"), 3.0);
  EXPECT_DOUBLE_EQ(value(" ( ( 1.5e1 ) ) \t* .5\n"), 7.5);
  EXPECT_DOUBLE_EQ(value("1e3 + 2.e-1"), 1000.2);
}

TEST(Expression, SaysWhereAFormulaIsWrong) {
  const std::pair<const char*, const char*> wrong[] = {
      {"2 *", "at its end: a number, a name or a \"(\" is missing"},
      {"2 * * 3", "at character 5, \"*\": a number, a name or a \"(\" is missing before it"},
      {"2 3", "at character 3, \"3\": an operator is missing before it"},
      {"(1 + 2)) + 1", "at character 8, \")\": there is no \"(\" to it"},
      {"sin(1", "at its end: the \")\" of sin is missing"},
      {"sin + 1", "the function sin needs its arguments in parentheses"},
      {"sin(1, 2)", "sin takes 1 argument, not 2"},
      {"step(t, 1)", "step takes 5 arguments, not 2"},
      {"min()", "min takes one argument or more, not 0"},
      {"t ? 1", "at its end: a \":\" and what holds otherwise are missing"},
      {"2load", "at character 1, \"2load\": a name begins with a letter, a product needs a \"*\""},
      {"load(2)", "load is no function; a product needs a \"*\""},
      {"1e999", "is no number that can be computed with"},
      {"1 & 2", "at character 3, \"&\": an operator is missing before it"},
      {"30*t deg", "at character 6, \"deg\": a unit stands behind a number alone"},
      {"30 deg*t", "at character 4, \"deg\": a unit stands behind a number alone"},
      {"30deg*t", "\"deg\": a unit stands behind a number alone"},
      {"sin(30*t deg)", "\"deg\": a unit stands behind a number alone"},
      {"2*(t deg)", "\"deg\": a unit stands behind a number alone"},
      {"t mm", "multiply what it belongs to by 0.001"},
      {"t inch", "multiply what it belongs to by 0.0254"},
      {"t rpm", "multiply what it belongs to by 0.10471975512"}};
  for (const auto& [text, why] : wrong) EXPECT_THAT(refusal(text), ::testing::HasSubstr(why)) << text;
  EXPECT_THAT(refusal(std::string(5000, '(')), ::testing::HasSubstr("nested too deeply"));
  EXPECT_THAT(refusal(std::string(5000, '-')), ::testing::HasSubstr("nested too deeply"));
  std::string nested = "1";
  for (int k = 0; k < 100; ++k) nested = "1 + (" + nested + ")";
  EXPECT_THAT(refusal(nested), ::testing::HasSubstr("nested too deeply"));
}

TEST(Expression, ReadsMeasuredQuantitiesByDottedName) {
  SignalNames names;
  names.add("crank.angle");
  const int speed = names.add("crank.speed");
  const Expression f("force.f", "t - 2.5*crank.speed", names, parameters);
  EXPECT_EQ(f.reads(), std::vector<int>{speed});
  const double signals[] = {1.0, 7.0, 3.0};
  EXPECT_DOUBLE_EQ(f.evaluate(signals), -6.5);
}

TEST(Expression, TimeDerivativesAreExact) {
  // Against eighth-order central differences of the same formula: with h = 0.02 their truncation h^8 f^(10)
  // is below 1e-10 for these functions, round-off 1e-16/h^2 = 3e-13.
  const char* formulas[] = {"sin(2*t)*exp(-t/3)",
                            "t^3 - 2/t",
                            "sqrt(1+t*t)",
                            "atan2(sin(t), 2+cos(t))",
                            "tan(t/4) + asin(t/5) + acos(t/7) + atan(t)",
                            "ln(2+t) + log10(3+t) + log2(4+t)",
                            "sinh(t/2)*cosh(t/3) - tanh(t)",
                            "asinh(t) + acosh(3+t) + atanh(t/6)",
                            "(2+t)^(1+t/2)",
                            "pow(t, 2.5)",
                            "abs(-t)*t",
                            "t > 0 ? cos(t) : 7",
                            "step(t, -1, 2, 4, 6)",
                            "max(t, -100)*min(t, 100)",
                            "load*sin(omega*t + pi/3)"};
  const double c1[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  const double c2[] = {8.0 / 5, -1.0 / 5, 8.0 / 315, -1.0 / 560};
  const double t = 1.3, h = 0.02;
  for (const char* text : formulas) {
    const SignalNames names;
    const Expression f("drive", text, names, parameters);
    const auto at = [&](double x) { return f.evaluate(&x); };
    double first = 0, second = -205.0 / 72 * at(t);
    for (int k = 1; k <= 4; ++k) {
      first += c1[k - 1] * (at(t + k * h) - at(t - k * h)) / h;
      second += c2[k - 1] * (at(t + k * h) + at(t - k * h));
    }
    second /= h * h;
    const Jet jet = f.time_derivatives(t);
    EXPECT_DOUBLE_EQ(jet.value, at(t)) << text;
    EXPECT_NEAR(jet.first, first, 1e-8 * (1 + std::abs(first))) << text;
    EXPECT_NEAR(jet.second, second, 1e-8 * (1 + std::abs(second))) << text;
  }
}

TEST(Expression, StartsFromRestWhereInnerDerivativesAreInfinite) {
  const SignalNames names;
  const Jet jet = Expression("drive", "sqrt(0) + 0^2 + t^2", names, {}).time_derivatives(0.0);
  EXPECT_DOUBLE_EQ(jet.value, 0.0);
  EXPECT_DOUBLE_EQ(jet.first, 0.0);
  EXPECT_DOUBLE_EQ(jet.second, 2.0);
}

TEST(Expression, RefusalsNameTheRemedy) {
  EXPECT_THAT(refusal("2*crank.angel"),
              ::testing::HasSubstr("force.f.value = \"2*crank.angel\": \"crank.angel\" is "
                                   "not known here, did you mean \"crank.angle\"?"));
  EXPECT_THAT(refusal("sine(t)"), ::testing::HasSubstr("did you mean \"sin"));
  EXPECT_EQ(refusal("t = 5"), "force.f.value = \"t = 5\": a formula must not assign; compare with ==");
  EXPECT_THAT(refusal("2*(3+t"), ::testing::HasSubstr("force.f.value = \"2*(3+t\": "));
  EXPECT_THAT(refusal(""), ::testing::HasSubstr("force.f.value = \"\": "));
  EXPECT_EQ(refusal("t == 5"), "");
}

TEST(Expression, NonFiniteResultNamesElementAndTime) {
  const SignalNames names;
  const Expression f("force.f.value", "1/(t-2)", names, {});
  const double t = 2.0;
  try {
    f.evaluate(&t);
    FAIL() << "infinity went through";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(
        error.what(),
        "force.f.value = \"1/(t-2)\" is inf at t = 2 s, a finite number is wanted; correct the formula "
        "or what it reads");
  }
}

}  // namespace
}  // namespace flexura::mbs
