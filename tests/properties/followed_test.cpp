// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// 0 = g(p, c, s, t, u): constraints and drives that follow inputs, states of controls, algebraic states and time move masses as the
// motion with the constraint eliminated by hand says, and need the force that this takes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/app/command.hpp"
#include "tests/mbs/cases/case_run.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using mbs::chance::Chance;

// A function of time with its derivatives.
struct Timed {
  double value = 0.0, first = 0.0, second = 0.0;
};
Timed operator+(const Timed& a, const Timed& b) {
  return {a.value + b.value, a.first + b.first, a.second + b.second};
}
Timed operator*(double k, const Timed& a) {
  return {k * a.value, k * a.first, k * a.second};
}
// f(a), with f' and f'' at a.
Timed of(const Timed& a, double f, double df, double ddf) {
  return {f, df * a.first, ddf * a.first * a.first + df * a.second};
}

// a + q a^3 = x: a' and a'' by differentiating twice.
Timed root(const Timed& x, double q) {
  double a = 0.0;
  // The slope is 1 at least: Newton's method comes within round-off in a few steps.
  for (int i = 0; i < 50; ++i) {
    const double step = (a + q * a * a * a - x.value) / (1 + 3 * q * a * a);
    a -= step;
    if (std::abs(step) < 1e-15) break;
  }
  const double slope = 1 + 3 * q * a * a, first = x.first / slope;
  return {a, first, (x.second - 6 * q * a * first * first) / slope};
}

// What is followed: u = A sin(W t), c'' = u - r c' - c, and what is made of them.
struct Signals {
  double A, W, r, q;
  int kind;
  std::string text() const {
    std::string out = fmt::format(
        "[input.u]\nvalue = \"{}*sin({}*t)\"\n[control.c]\ntype = \"state\"\nrate = \"c2\"\nstart = 0.1\n"
        "[control.c2]\ntype = \"state\"\nrate = \"u - {}*c2 - c\"\nstart = -0.2\n",
        A, W, r);
    if (kind == 2 || kind == 5)
      out += fmt::format("[control.al]\ntype = \"algebraic\"\nequation = \"al + {}*al^3 - c\"\n", q);
    if (kind == 4)
      out += fmt::format(
          "[measure.m]\ntype = \"expression\"\nvalue = \"c^2 + u\"\n[control.al]\ntype = \"algebraic\"\n"
          "equation = \"al + {}*al^3 - m\"\n",
          q);
    if (kind == 5)
      out += fmt::format("[control.be]\ntype = \"algebraic\"\nequation = \"be + {}*be^3 - al - u\"\n", q);
    return out;
  }
  std::string formula() const {
    static constexpr std::array kFormulas = {"u", "c", "al", "sin(c) + 0.3*u*t", "m + 0.5*al", "be"};
    return kFormulas[static_cast<std::size_t>(kind)];
  }
  Timed u(double t) const {
    return {A * std::sin(W * t), A * W * std::cos(W * t), -A * W * W * std::sin(W * t)};
  }
  Timed at(double t, double c_now, double c_dot) const {
    const Timed v = u(t), c{c_now, c_dot, v.value - r * c_dot - c_now};
    const Timed m = of(c, c.value * c.value, 2 * c.value, 2) + v;
    switch (kind) {
      case 0:
        return v;
      case 1:
        return c;
      case 2:
        return root(c, q);
      case 3:
        return of(c, std::sin(c.value), std::cos(c.value), -std::sin(c.value)) +
               Timed{0.3 * v.value * t, 0.3 * (v.first * t + v.value), 0.3 * (v.second * t + 2 * v.first)};
      case 4:
        return m + 0.5 * root(m, q);
      default:
        return root(root(c, q) + v, q);
    }
  }
};

// Masses m on a slide h and n on a slide k, on which a spring acts: h = a k + b k^2 + w.
struct Slides {
  double m, n, a, b, stiffness;
  Signals w;
  // k, k', c, c'.
  using Y = std::array<double, 4>;
  double k_ddot(double t, const Y& y) const {
    const double s = a + 2 * b * y[0];
    return (-stiffness * y[0] - m * s * (2 * b * y[1] * y[1] + w.at(t, y[2], y[3]).second)) / (m * s * s + n);
  }
  Y rate(double t, const Y& y) const { return {y[1], k_ddot(t, y), y[3], w.u(t).value - w.r * y[3] - y[2]}; }
  // The classical Runge-Kutta method: its error with this step is some 1e-12.
  Y step(double t, const Y& y, double h) const {
    const auto moved = [&](const Y& by, double f) {
      Y out = y;
      for (std::size_t i = 0; i < 4; ++i) out[i] += f * by[i];
      return out;
    };
    const Y k1 = rate(t, y), k2 = rate(t + 0.5 * h, moved(k1, 0.5 * h)),
            k3 = rate(t + 0.5 * h, moved(k2, 0.5 * h)), k4 = rate(t + h, moved(k3, h));
    Y out = y;
    for (std::size_t i = 0; i < 4; ++i) out[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    return out;
  }
  Timed h(double t, const Y& y) const {
    const Timed k{y[0], y[1], k_ddot(t, y)};
    return of(k, a * y[0] + b * y[0] * y[0], a + 2 * b * y[0], 2 * b) + w.at(t, y[2], y[3]);
  }
};

const std::string two_slides = R"toml(gravity = [0, 0, 0]
[ground.marker.o]
axis = [1,0,0]
[ground.marker.p]
position = [0,1,0]
axis = [1,0,0]
[body.a.marker.l]
axis = [1,0,0]
[body.b.marker.l]
axis = [1,0,0]
[joint.k]
type = "prismatic"
from = "ground.p"
to = "b.l"
position = 0.3
speed = 0.2
[force.spring]
type = "joint_spring_damper"
joint = "k"
)toml";

struct Method {
  const char* name;
  double tolerance;
  double error;  ///< of motions over 1 s, some hundred times the tolerance, of order two ten times more
};
constexpr std::array kMethods = {Method{"ida", 1e-9, 2e-7}, Method{"radau", 1e-9, 2e-7},
                                 Method{"runge_kutta", 1e-9, 2e-7}, Method{"generalised_alpha", 1e-7, 1e-4}};

TEST(Followed, MassesMoveAsWithTheConstraintEliminated) {
  const test::Folder folder;
  for (int seed = 0; seed < 240; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const int kind = chance.below(3);  // expression, coupler, drive
    Slides s{chance.between(0.5, 3),
             chance.between(0.5, 3),
             chance.either_sign(0.3, 1.5),
             kind == 0 ? chance.either_sign(0.1, 0.8) : 0.0,
             chance.between(0, 20),
             {chance.between(0.05, 0.3), chance.between(1, 6), chance.between(0.2, 2), chance.between(0.1, 2),
              chance.below(6)}};
    if (kind == 2) s.a = 0;
    std::string text = two_slides;
    text += fmt::format(
        "stiffness = {}\n[body.a]\nmass = {}\ninertia = [1,1,1]\n[body.b]\nmass = {}\ninertia = [1,1,1]\n",
        s.stiffness, s.m, s.n);
    text += s.w.text() + "[joint.h]\ntype = \"prismatic\"\nfrom = \"ground.o\"\nto = \"a.l\"\n";
    if (kind == 0)
      text += fmt::format(
          "[constraint.x]\ntype = \"expression\"\nunit = \"m\"\nvalue = \"h.position - {}*k.position - "
          "{}*k.position^2 - ({})\"\n",
          s.a, s.b, s.w.formula());
    if (kind == 1)
      text += fmt::format(
          "[constraint.x]\ntype = \"coupler\"\njoints = [\"h\",\"k\"]\nfactors = [1, {}]\noffset = \"{}\"\n",
          -s.a, s.w.formula());
    if (kind == 2) text += fmt::format("drive = \"{}\"\n", s.w.formula());
    const Method& method = kMethods[static_cast<std::size_t>(seed) % kMethods.size()];
    text += fmt::format("[solver]\nend_time = 1\noutput_step = 0.1\ntolerance = {}\nmethod = \"{}\"\n",
                        method.tolerance, method.name);
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
    const std::string force = kind == 0 ? "x.force" : kind == 1 ? "x.force_1" : "h.drive_force";
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("slides.toml", text));
    const mbs::cases::Series run =
        mbs::cases::simulate(p, {"h.position", "h.speed", "k.position", "k.speed", "h.acceleration", force});
    Slides::Y y{0.3, 0.2, 0.1, -0.2};
    ASSERT_EQ(run.t.size(), 11u);
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      const double t = run.t[i];
      const Timed h = s.h(t, y);
      const Eigen::VectorXd& row = run.values[i];
      EXPECT_NEAR(row(0), h.value, method.error) << t;
      EXPECT_NEAR(row(1), h.first, 10 * method.error) << t;
      EXPECT_NEAR(row(2), y[0], method.error) << t;
      EXPECT_NEAR(row(3), y[1], 10 * method.error) << t;
      // Accelerations answer to states by what the signals' rates are made of: W^2, stiffness over mass.
      EXPECT_NEAR(row(4), h.second, 400 * method.error) << t;
      EXPECT_NEAR(row(5), s.m * h.second, 400 * s.m * method.error) << t;
      constexpr int kSteps = 200;
      for (int j = 0; j < kSteps; ++j) y = s.step(t + 0.1 * j / kSteps, y, 0.1 / kSteps);
    }
    if (HasFailure()) return;
  }
}

// A mass on a slide that passes 1 m beside the link's end: x = sqrt(L^2 - 1), pulled by m x'' L / x.
TEST(Followed, ALinkPullsAsItsLengthSays) {
  const test::Folder folder;
  for (int seed = 0; seed < 200; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double m = chance.between(0.5, 3);
    const bool by_time = chance.flip(0.3);
    const Signals w{chance.between(0.05, 0.2), chance.between(1, 5), chance.between(0.2, 2),
                    chance.between(0.1, 2), chance.below(6)};
    const double rate = chance.between(0.05, 0.3);
    const std::string length =
        by_time ? fmt::format("2 + {}*t^2", rate) : fmt::format("2.2 + {}", w.formula());
    std::string text = fmt::format(
        "gravity = [0, 0, 0]\n[ground.marker.o]\n[ground.marker.s]\nposition = [0,1,0]\naxis = "
        "[1,0,0]\n[body.a]\nmass = {}\n"
        "inertia = [1,1,1]\nposition = [1.7,1,0]\n[body.a.marker.l]\naxis = [1,0,0]\n[joint.h]\ntype = "
        "\"prismatic\"\nfrom = "
        "\"ground.s\"\nto = \"a.l\"\n[constraint.x]\ntype = \"distance\"\nfrom = \"ground.o\"\nto = "
        "\"a.l\"\nlength = "
        "\"{}\"\n",
        m, length);
    if (!by_time) text += w.text();
    const Method& method = kMethods[static_cast<std::size_t>(seed) % kMethods.size()];
    text += fmt::format("[solver]\nend_time = 1\noutput_step = 0.1\ntolerance = {}\nmethod = \"{}\"\n",
                        method.tolerance, method.name);
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("link.toml", text));
    const mbs::cases::Series run =
        mbs::cases::simulate(p, {"h.position", "h.speed", "h.acceleration", "x.tension", "power.input"});
    const Slides of_states{1, 1, 0, 0, 0, w};
    Slides::Y y{0, 0, 0.1, -0.2};
    for (std::size_t i = 0; i < run.t.size(); ++i) {
      const double t = run.t[i];
      const Timed L =
          by_time ? Timed{2 + rate * t * t, 2 * rate * t, 2 * rate} : Timed{2.2} + w.at(t, y[2], y[3]);
      const double x = std::sqrt(L.value * L.value - 1), slope = L.value / x;
      const Timed h = of(L, x, slope, -1 / (x * x * x));
      EXPECT_NEAR(run.values[i](0), h.value, method.error) << t;
      EXPECT_NEAR(run.values[i](1), h.first, 10 * method.error) << t;
      EXPECT_NEAR(run.values[i](2), h.second, 400 * method.error) << t;
      EXPECT_NEAR(run.values[i](3), -m * h.second * slope, 400 * m * slope * method.error) << t;
      // What the link works is what moves the mass.
      EXPECT_NEAR(run.values[i](4), m * h.second * h.first, 400 * m * slope * method.error) << t;
      constexpr int kSteps = 200;
      for (int j = 0; j < kSteps; ++j) y = of_states.step(t + 0.1 * j / kSteps, y, 0.1 / kSteps);
    }
    if (HasFailure()) return;
  }
}

}  // namespace
}  // namespace flexura::properties
