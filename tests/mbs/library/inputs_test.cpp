// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>

#include "mbs/controls/filter.hpp"
#include "mbs/forces/joint_force.hpp"
#include "mbs/forces/joint_spring_damper.hpp"
#include "mbs/joints/prismatic.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/library/builder.hpp"
#include "mbs/library/simulation.hpp"

/// What a program changes between two steps of its loop acts from that time on, and not before.
namespace flexura::mbs {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const RigidBody kCart = {.mass = 1.0, .inertia = Matrix3d::Identity()};

/// A force along a coordinate that is a variable of the program.
class Push final : public ForceElement {
 public:
  Push(std::string name, CoordinateRef along, const double* force)
      : ForceElement(std::move(name)), along_(along), force_(force) {}
  std::string_view type() const override { return "push"; }
  ForceNature nature() const override { return ForceNature::load; }
  void apply(const Kinematics&, const double*, Loads& loads) const override { loads.apply(along_, *force_); }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    powers.input += *force_ * kin.speed(along_);
  }

 private:
  CoordinateRef along_;
  const double* force_;
};

/// The same of a damper.
class Brake final : public ForceElement {
 public:
  Brake(std::string name, CoordinateRef along, const double* damping)
      : ForceElement(std::move(name)), along_(along), damping_(damping) {}
  std::string_view type() const override { return "brake"; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(along_, -*damping_ * kin.speed(along_));
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    powers.dissipated += *damping_ * kin.speed(along_) * kin.speed(along_);
  }

 private:
  CoordinateRef along_;
  const double* damping_;
};

std::vector<SimulationOptions> all_integrators(double end_time) {
  std::vector<SimulationOptions> all;
  for (const Method method :
       {Method::automatic, Method::ida, Method::radau, Method::runge_kutta, Method::generalised_alpha})
    all.push_back({.method = method, .tolerance = 1e-8, .end_time = end_time});
  for (const Method method : {Method::runge_kutta, Method::generalised_alpha})
    all.push_back({.method = method, .tolerance = 1e-8, .end_time = end_time, .fixed_step = 1e-3});
  return all;
}

// 1 kg, pushed forwards for a second, backwards for another: x = 1/2 + 1 - 1/2, v = 0.
TEST(Inputs, CartPushedToAndFroStandsWhereItShould) {
  for (const SimulationOptions& options : all_integrators(2.0))
    for (const bool by_input : {true, false})
      for (const double step : {0.1, 0.05, 0.01}) {
        SCOPED_TRACE(fmt::format("method {} fixed {} input {} step {}", static_cast<int>(options.method),
                                 options.fixed_step, by_input, step));
        double force = 0.0;
        MechanismBuilder b;
        const auto cart = b.add("cart", kCart);
        auto rail = b.add<Prismatic>("rail", b.ground().marker(), cart.marker());
        b.input("u", "0");
        b.add<JointForce>("motor", rail.coordinate(), b.formula("u"));
        b.add<Push>("push", rail.coordinate(), &force);
        Simulation s(b.build(), options);
        while (s.time() < 2.0 - 1e-9) {
          const double now = s.time() < 1.0 - 1e-9 ? 1.0 : -1.0;
          if (by_input)
            s.set_input("u", now);
          else
            force = now;
          s.advance(step);
        }
        // Steps are exact for parabolas, but for their first one, whose error is within the tolerance; those of
        // generalised_alpha are of order 2 with that of the jerk, at a jump (1e-3)^2.
        const double error = options.method == Method::generalised_alpha ? 1e-6 : 1e-7;
        EXPECT_NEAR(s.output("rail.position"), 1.0, error);
        EXPECT_NEAR(s.output("rail.speed"), 0.0, error);
        EXPECT_NEAR(s.energy().error(), 0.0, 1e-6);
        EXPECT_NEAR(s.energy().gross_work, 1.0, 1e-5);  // 1/2 J in, 1/2 J out
      }
}

// m x'' + d x' + k x = u, u piecewise constant, on from (x, v) over h: the root of the characteristic equation turns
// z = v - conj(r) (x - u / k).
struct Oscillator {
  double m, d, k, x = 0.0, v = 0.0;
  void go(double u, double h) {
    using C = std::complex<double>;
    const C r = (-d + std::sqrt(C(d * d - 4.0 * m * k))) / (2.0 * m), q = std::conj(r);
    const C z = (v - q * (x - u / k)) * std::exp(r * h);
    x = u / k + z.imag() / r.imag();
    v = z.real() + q.real() * (x - u / k);
  }
};

// The loop of a program against the closed form, and against a formula of t with the same steps: any integrator, any lengths
// of steps, values set at some of them, by inputs or by variables of the program.
TEST(Inputs, RandomStepsOfInputsAreThoseOfTheClosedForm) {
  std::mt19937 random(20);  // NOLINT(cert-msc51-cpp): repeatable
  const auto draw = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  const std::vector<SimulationOptions> all = all_integrators(10.0);
  for (int round = 0; round < 210; ++round) {
    SimulationOptions options = all[static_cast<std::size_t>(round) % all.size()];
    Oscillator exact{draw(0.5, 3.0), draw(0.0, 1.0), draw(20.0, 200.0)};
    const bool by_input = draw(0.0, 1.0) < 0.5, is_known = by_input && round % 3 == 0;
    const double step = draw(0.005, 0.1);
    SCOPED_TRACE(fmt::format("round {} method {} fixed {} input {} step {}", round,
                             static_cast<int>(options.method), options.fixed_step, by_input, step));
    std::vector<double> values;
    for (int i = 0; i < 20; ++i)
      values.push_back(i > 0 && draw(0.0, 1.0) < 0.4 ? values.back() : draw(-10.0, 10.0));
    std::string table = "0";
    for (int i = 19; i >= 0; --i) table = fmt::format("t < {} ? {} : ({})", (i + 1) * step, values[i], table);
    double force = 0.0;
    const auto make = [&](const std::string& input) {
      MechanismBuilder b;
      const auto cart = b.add("cart", RigidBody{.mass = exact.m, .inertia = Matrix3d::Identity()});
      auto rail = b.add<Prismatic>("rail", b.ground().marker(), cart.marker());
      b.input("u", input);
      b.add<JointForce>("motor", rail.coordinate(),
                        b.formula(fmt::format("u - {} * rail.position - {} * rail.speed", exact.k, exact.d)));
      b.add<Push>("push", rail.coordinate(), &force);
      return b.build();
    };
    Simulation s(make("0"), options);
    double largest = 0.0, error = 0.0;
    for (int i = 0; i < 20; ++i) {
      if (by_input)
        s.set_input("u", values[i]);
      else
        force = values[i];
      s.advance(step);
      exact.go(values[i], step);
      largest = std::max({largest, std::abs(exact.x), std::abs(values[i]) / exact.k});
      error = std::max(error, std::abs(s.output("rail.position") - exact.x));
    }
    // Errors within 1e-8 of 1 rad or 1 m in each of up to some hundred steps; a fixed step of generalised_alpha is off by
    // (omega h)^2 / 12 of the phase, (14e-3)^2 / 12 of up to 28 rad, and by as much at each of 20 jumps.
    const bool is_second = options.method == Method::generalised_alpha;
    EXPECT_LT(error, is_second && options.fixed_step > 0.0 ? 3e-3 * largest : 3e-6);
    force = 0.0;
    if (!is_known) continue;
    Simulation known(make(table), options);
    known.advance(20.0 * step);
    EXPECT_NEAR(s.output("rail.position"), known.output("rail.position"),
                is_second && options.fixed_step > 0.0 ? 6e-3 * largest : 6e-6);
  }
}

// A loop of bars, whose motor and whose brake the program sets, against one whose formulas know the times.
TEST(Inputs, LoopOfBarsGoesAsWithFormulasOfTime) {
  const auto make = [](const std::string& torque) {
    MechanismBuilder b;
    b.gravity({0, -9.81, 0});
    const Matrix3d I = 0.02 * Matrix3d::Identity();
    const auto at = [](double x) { return Pose{Matrix3d::Identity(), {x, 0, 0}}; };
    const auto crank = b.add("crank", RigidBody{.mass = 1, .inertia = I}),
               coupler = b.add("coupler", RigidBody{.mass = 1, .inertia = I}),
               rocker = b.add("rocker", RigidBody{.mass = 1, .inertia = I});
    auto main = b.add<Revolute>("main", b.ground().marker(), crank.marker()).start(0.4);
    b.add<Revolute>("pin", crank.marker(at(0.2)), coupler.marker()).start(0.7);
    b.add<Revolute>("base", b.ground().marker(at(0.6)), rocker.marker()).start(1.6);
    b.add<Revolute>("loop", coupler.marker(at(0.7)), rocker.marker(at(0.5)));
    b.input("torque", torque);
    b.add<JointForce>("motor", main.coordinate(), b.formula("torque - 0.2 * main.speed"));
    return b.build();
  };
  for (const SimulationOptions& options : all_integrators(1.0)) {
    SCOPED_TRACE(static_cast<int>(options.method));
    Simulation known(make("t < 0.3 ? 5 : t < 0.45 ? -8 : 2"), options);
    Simulation s(make("0"), options);
    for (int i = 0; i < 20; ++i) {
      s.set_input("torque", i < 6 ? 5.0 : i < 9 ? -8.0 : 2.0);
      s.advance(0.05);
      known.advance(0.05);
    }
    // Both within 1e-8 in each of some hundred steps; fixed steps of order 2, which end at other times, (20 h)^2 / 12.
    const bool is_second = options.method == Method::generalised_alpha;
    EXPECT_NEAR(s.output("main.angle"), known.output("main.angle"),
                is_second && options.fixed_step > 0.0 ? 1e-4 : 2e-6);
  }
}

TEST(Inputs, ConditionsAndFiltersReadWhatIsSet) {
  for (const SimulationOptions& options : all_integrators(3.0)) {
    SCOPED_TRACE(static_cast<int>(options.method));
    MechanismBuilder b;
    const auto cart = b.add("cart", kCart), wheel = b.add("wheel", kCart);
    auto rail = b.add<Prismatic>("rail", b.ground().marker(), cart.marker());
    auto axle = b.add<Revolute>("axle", b.ground().marker(), wheel.marker());
    b.input("u", "0.25");
    b.add<JointForce>("motor", rail.coordinate(), b.formula("u > 0.5 ? 1 : -1"));
    b.add<Filter>("lagged", b.formula("u"), 0.5, 0.0);
    b.add<JointForce>("turn", axle.coordinate(), b.formula("lagged"));
    Simulation s(b.build(), options);
    // x'' = -1, 1, -1, a second each; the filter starts in equilibrium with what is set before the first step.
    for (const double u : {0.0, 1.0, 0.4}) {
      s.set_input("u", u);
      for (int k = 0; k < 10; ++k) s.advance(0.1);
    }
    EXPECT_NEAR(s.output("rail.position"), -0.5 - 0.5 - 0.5, 2e-6);
    const double y_2 = 1.0 - std::exp(-2.0), y_3 = 0.4 + (y_2 - 0.4) * std::exp(-2.0);
    EXPECT_NEAR(s.output("lagged"), y_3, 2e-6);
    EXPECT_EQ(s.output("motor.force"), -1.0);
    s = Simulation(b.build(), options);
    EXPECT_EQ(s.output("motor.force"), -1.0);
    s.set_input("u", 0.75);
    EXPECT_EQ(s.output("motor.force"), 1.0);
  }
}

// A brake put on at rest shows in no acceleration: the steps that follow meet it.
TEST(Inputs, BrakePutOnAtRestHoldsBack) {
  for (const SimulationOptions& options : all_integrators(2.0)) {
    SCOPED_TRACE(static_cast<int>(options.method));
    double damping = 0.0;
    MechanismBuilder b;
    const auto cart = b.add("cart", kCart);
    auto rail = b.add<Prismatic>("rail", b.ground().marker(), cart.marker());
    b.add<JointForce>("motor", rail.coordinate(), b.formula("t < 1 ? 0 : 1"));
    b.add<Brake>("brake", rail.coordinate(), &damping);
    Simulation s(b.build(), options);
    for (int k = 0; k < 20; ++k) {
      if (k == 5) damping = 3.0;
      s.advance(0.1);
    }
    EXPECT_NEAR(s.output("rail.speed"), (1.0 - std::exp(-3.0)) / 3.0, 2e-6);
  }
}

// On a mass that moves it shows, and acts from that time on.
TEST(Inputs, BrakePutOnInMotionActsFromThenOn) {
  for (const SimulationOptions& options : all_integrators(1.0)) {
    double damping = 0.0;
    MechanismBuilder b;
    const auto cart = b.add("cart", kCart);
    auto rail = b.add<Prismatic>("rail", b.ground().marker(), cart.marker()).speed(1.0);
    b.add<Brake>("brake", rail.coordinate(), &damping);
    Simulation s(b.build(), options);
    s.advance(0.5);
    damping = 4.0;
    s.begin_anew();
    s.advance(0.25);
    s.advance(0.25);
    EXPECT_NEAR(s.output("rail.speed"), std::exp(-2.0), 2e-6) << static_cast<int>(options.method);
  }
}

TEST(Inputs, SetBeforeTheFirstStepPlacesTheDrive) {
  MechanismBuilder b;
  const auto cart = b.add("cart", kCart);
  b.input("place", "0.1");
  b.input("pace", "2 * t");
  b.add<Filter>("smooth", b.formula("place"), 0.1, 0.0);
  b.add<Filter>("smoother", b.formula("smooth"), 0.1, 0.0);
  b.add<Prismatic>("rail", b.ground().marker(), cart.marker()).drive("smoother");
  const Mechanism m = b.build();
  Simulation s(m, {.end_time = 10.0});
  EXPECT_THAT(
      [&] { s.set_input("plaec", 1.0); },
      ThrowsMessage<std::invalid_argument>(HasSubstr("no input \"plaec\"; there are \"place\", \"pace\"")));
  EXPECT_THAT([&] { s.set_input("pace", 1.0); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("follows \"2 * t\", a formula of t")));
  EXPECT_THAT([&] { s.set_input("place", NAN); }, ThrowsMessage<std::invalid_argument>(HasSubstr("finite")));
  s.advance(1.0);
  s.set_input("place", 0.3);
  for (int k = 0; k < 30; ++k) s.advance(0.1);
  EXPECT_NEAR(s.output("rail.position"), 0.3, 1e-6);
}

// No position can jump: a drive straight from an input is refused at the first step behind a change.
TEST(Inputs, DriveCannotJump) {
  MechanismBuilder b;
  const auto cart = b.add("cart", kCart);
  b.input("place", "0.1");
  b.add<Prismatic>("rail", b.ground().marker(), cart.marker()).drive("place + 0.1 * t");
  Simulation s(b.build(), {.end_time = 10.0});
  s.set_input("place", 0.4);
  EXPECT_NEAR(s.output("rail.position"), 0.4, 1e-12);
  s.advance(1.0);
  EXPECT_NEAR(s.output("rail.position"), 0.5, 1e-9);
  s.set_input("place", 0.6);
  EXPECT_THAT([&] { s.advance(0.1); },
              ThrowsMessage<std::runtime_error>(HasSubstr("a filter between what is set and the drive")));
  EXPECT_NEAR(s.output("rail.position"), 0.5, 1e-9);
}

}  // namespace
}  // namespace flexura::mbs
