// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "mbs/constraints/coupler.hpp"
#include "mbs/constraints/geometric.hpp"
#include "mbs/controls/filter.hpp"
#include "mbs/forces/applied.hpp"
#include "mbs/forces/joint_force.hpp"
#include "mbs/forces/spring_damper.hpp"
#include "mbs/joints/fixed.hpp"
#include "mbs/joints/prismatic.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/joints/six_dof.hpp"
#include "mbs/library/builder.hpp"
#include "mbs/library/simulation.hpp"
#include "mbs/measures/relative_measure.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// Mechanisms and simulations without a file.
namespace flexura::mbs {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr double g = 9.81;

// A rod that hangs from its end and turns about z, gravity along -y: I theta'' = -m g c sin(theta).
MechanismBuilder pendulum(double theta_0) {
  MechanismBuilder b("pendulum");
  b.gravity({0, -g, 0});
  const auto rod = b.add("rod", RigidBody{.mass = 2.0,
                                          .center = {0, -0.5, 0},
                                          .inertia = Vector3d(2.0 / 12.0, 1e-3, 2.0 / 12.0).asDiagonal()});
  b.add<Revolute>("hinge", b.ground().marker(), rod.marker()).start(theta_0);
  return b;
}

TEST(Library, PendulumIsOnItsOtherSideAfterHalfItsPeriod) {
  const double theta_0 = 1.2;
  const Mechanism m = pendulum(theta_0).build();
  // T = 4 sqrt(I / (m g c)) K(sin(theta_0 / 2)).
  const double I = 2.0 / 12.0 + 2.0 * 0.25,
               half = 2.0 * std::sqrt(I / (2.0 * g * 0.5)) * std::comp_ellint_1(std::sin(0.5 * theta_0));
  for (const Method method : {Method::automatic, Method::ida, Method::radau, Method::runge_kutta}) {
    Simulation s(m, {.method = method, .tolerance = 1e-8});
    for (int k = 0; k < 20; ++k) s.advance(half / 20.0);
    EXPECT_NEAR(s.time(), half, 1e-12);
    // 1e-8 in each of some hundred steps.
    EXPECT_NEAR(s.output("hinge.angle"), -theta_0, 1e-5);
    EXPECT_NEAR(s.output("hinge.speed"), 0.0, 1e-5);
    EXPECT_NEAR(s.energy().error(), 0.0, 1e-5);
  }
}

// A name of its own for each that the mechanism file has.
TEST(Library, EveryIntegratorIsAMethod) {
  std::set<Method> seen = {Method::automatic};
  const Mechanism m = pendulum(0.1).build();
  for (const IntegratorKind& kind : integrator_kinds()) {
    SCOPED_TRACE(kind.name);
    EXPECT_TRUE(seen.insert(kind.method).second);
    if (!kind.integrates) continue;
    Simulation s(m, {.method = kind.method});
    s.advance(0.01);
    EXPECT_LT(s.output("hinge.angle"), 0.1);
  }
}

TEST(Library, AdvancingInPiecesIsTheRunInOne) {
  const Mechanism m = pendulum(0.7).build();
  Simulation s(m, {.end_time = 1.0});
  SolverOptions o = {.output_step = 0.01};
  StartedMechanism whole;
  whole.options = o;
  whole.mechanism = std::make_unique<Mechanism>(m.description());
  whole.state = whole.mechanism->initial_state();
  assemble_start(whole, {whole.mechanism->given_positions(), whole.mechanism->given_velocities()});
  whole.options.method_is_open = true;
  std::vector<State> rows;
  RunCallbacks callbacks;
  callbacks.row = [&](const State& state, const Eigen::VectorXd&, const EnergyAccount&) {
    rows.push_back(state);
  };
  ASSERT_TRUE(run(*whole.mechanism, whole.state, whole.v_dot, whole.options, callbacks).complete);
  ASSERT_EQ(rows.size(), 101);
  for (std::size_t k = 1; k < rows.size(); ++k) {
    s.advance(0.01);
    // 1e-6 in each of some hundred steps, which end elsewhere.
    ASSERT_NEAR(s.state().p(0), rows[k].p(0), 2e-5) << k;
    ASSERT_NEAR(s.state().v(0), rows[k].v(0), 1e-4) << k;
  }
  EXPECT_THAT([&] { s.advance(0.01); }, ThrowsMessage<std::runtime_error>(HasSubstr("end_time")));
}

TEST(Library, MassOnASpringSwingsAsACosine) {
  MechanismBuilder b;
  const auto mass = b.add("mass", RigidBody{.mass = 3.0, .inertia = Matrix3d::Identity()});
  const auto rail = b.add<Prismatic>("rail", b.ground().marker(), mass.marker()).start(0.5);
  const auto hook = b.ground().marker({Matrix3d::Identity(), {0, 0, -1.0}});
  b.add<SpringDamper>("spring", hook, mass.marker(), {.stiffness = 300.0, .free_length = 1.0});
  b.add<RelativeMeasure>("stretch", hook, mass.marker(), RelativeQuantity::distance());
  Simulation s(b.build(), {.tolerance = 1e-9});
  const double omega = std::sqrt(300.0 / 3.0);
  for (int k = 1; k <= 30; ++k) {
    s.advance(0.05);
    const double x = 0.5 * std::cos(omega * s.time());
    // 1e-9 of 1 m in each of the hundred steps of a swing, over two and a half swings.
    EXPECT_NEAR(s.output("rail.position"), x, 1e-6);
    EXPECT_NEAR(s.output("stretch"), 1.0 + x, 1e-6);
    EXPECT_NEAR(s.output("spring.force"), 300.0 * x, 1e-3);
  }
  (void)rail;
}

// Crank 0.2 along x at angle a about (0, 0), rocker 0.5 about (0.6, 0), coupler 0.7 between their ends.
TEST(Library, DrivenFourBarClosesAsItsCirclesDo) {
  MechanismBuilder b;
  const Matrix3d I = 1e-3 * Matrix3d::Identity();
  const auto at = [](double x, double y) { return Pose{Matrix3d::Identity(), {x, y, 0}}; };
  const auto crank = b.add("crank", RigidBody{.mass = 1, .inertia = I}),
             coupler = b.add("coupler", RigidBody{.mass = 1, .inertia = I}),
             rocker = b.add("rocker", RigidBody{.mass = 1, .inertia = I});
  b.add<Revolute>("main", b.ground().marker(), crank.marker()).drive("2 * t");
  b.add<Revolute>("pin", crank.marker(at(0.2, 0)), coupler.marker()).start(0.7);
  b.add<Revolute>("base", b.ground().marker(at(0.6, 0)), rocker.marker()).start(1.6);
  b.add<Revolute>("loop", coupler.marker(at(0.7, 0)), rocker.marker(at(0.5, 0)));
  Simulation s(b.build());
  for (int k = 0; k < 60; ++k) {
    s.advance(0.05);
    const double a = 2.0 * s.time();
    // The coupler's end from the crank's pin P and the rocker's bearing Q: circles of 0.7 and 0.5, the upper point.
    const Eigen::Vector2d P(0.2 * std::cos(a), 0.2 * std::sin(a)), Q(0.6, 0.0), d = Q - P;
    const double l = d.norm(), x = (0.49 - 0.25 + l * l) / (2.0 * l), y = std::sqrt(0.49 - x * x);
    const Eigen::Vector2d C = P + x * d / l + y * Eigen::Vector2d(-d.y(), d.x()) / l;
    const double rocker_angle = std::atan2(C.y() - Q.y(), C.x() - Q.x());
    EXPECT_NEAR(std::remainder(s.output("base.angle") - rocker_angle, 2.0 * std::numbers::pi), 0.0, 1e-9)
        << s.time();
  }
}

TEST(Library, SuperelementBendsUnderItsTipLoadAsABeam) {
  const beams::StraightBeam beam{.length = 2.0,
                                 .elements = 12,
                                 .EA = 1e7,
                                 .GI_t = 2e3,
                                 .EI_y = 3e3,
                                 .EI_z = 3e3,
                                 .mass_per_length = 4.0};
  const ModalBody body(beams::beam_superelement(beam));
  EXPECT_EQ(body.report().kept, body.report().available);
  MechanismBuilder b;
  const auto arm = b.add("arm", body);
  b.add<Fixed>("clamp", b.ground().marker(), arm.marker("root"));
  const auto tip = arm.marker("tip");
  b.add<Applied>("load", false, tip, -1, -1, Applied::Components{nullptr, b.formula("-5e-3"), nullptr});
  b.add<RelativeMeasure>("sag", b.ground().marker(), tip, RelativeQuantity::position(), Vector3d::UnitY());
  Simulation s(b.build(), {.method = Method::quasi_statics});
  s.advance(1.0);
  // The frame turns with the load, 1e-12 of it; statics come to rest within 1e-7.
  EXPECT_NEAR(s.output("sag"), -5e-3 * 8.0 / (3.0 * beam.EI_z), 1e-12);
  EXPECT_THAT([&] { arm.marker("elbow"); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("no interface \"elbow\"")));
}

/// A force of the user's own: strength / r^2 between two points.
class Attraction final : public ForceElement {
 public:
  Attraction(std::string name, int P, int Q, double strength)
      : ForceElement(std::move(name)), P_(P), Q_(Q), strength_(strength) {}
  std::string_view type() const override { return "attraction"; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const Vector3d r = kin.markers[Q_].X_WP.p - kin.markers[P_].X_WP.p;
    const Vector3d f = -strength_ / (r.squaredNorm() * r.norm()) * r;
    loads.apply(Q_, Spatial{Vector3d::Zero(), f});
    loads.apply(P_, Spatial{Vector3d::Zero(), -f});
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    powers.potential -= strength_ / (kin.markers[Q_].X_WP.p - kin.markers[P_].X_WP.p).norm();
  }

 private:
  int P_, Q_;
  double strength_;
};

TEST(Library, ForceOfOnesOwnKeepsAPlanetOnItsEllipse) {
  MechanismBuilder b;
  const auto planet = b.add("planet", RigidBody{.mass = 1.0, .inertia = Matrix3d::Identity()});
  b.add<SixDof>("free", b.ground().marker(), planet.marker()).start(1.0, 4).speed(1.2, 4);
  b.add<Attraction>("sun", b.ground().marker(), planet.marker(), 1.0);
  // From r = 1 at v = 1.2: a = 1 / (2 - 1.44), T = 2 pi a^(3/2).
  const double a = 1.0 / (2.0 - 1.44), T = 2.0 * std::numbers::pi * std::pow(a, 1.5);
  Simulation s(b.build(), {.tolerance = 1e-9, .end_time = 2.0 * T});
  for (int k = 0; k < 10; ++k) s.advance(T / 20.0);
  EXPECT_NEAR(s.output("free.x"), 1.0 - 2.0 * a, 1e-5);  // the far end of the axis
  for (int k = 0; k < 10; ++k) s.advance(T / 20.0);
  EXPECT_NEAR(s.output("free.x"), 1.0, 1e-5);
  EXPECT_NEAR(s.output("free.y"), 0.0, 1e-5);
}

TEST(Library, ControlsMeasuresAndFormulasReadEachOther) {
  MechanismBuilder b;
  b.parameter("gain", 4.0);
  b.input("target", "1 + 0 * t");
  const auto cart = b.add("cart", RigidBody{.mass = 1.0, .inertia = Matrix3d::Identity()});
  const auto rail = b.add<Prismatic>("rail", b.ground().marker(), cart.marker());
  b.add<Filter>("lagged", b.formula("target - rail.position"), 0.1, 0.0);
  b.add<JointForce>("push", rail.coordinate(), b.formula("gain * lagged - 3 * rail.speed"));
  Simulation s(b.build(), {.end_time = 40.0});
  for (int k = 0; k < 30; ++k) s.advance(1.0);
  EXPECT_NEAR(s.output("rail.position"), 1.0, 1e-4);
}

TEST(Library, RefusesWhatHasNoMeaning) {
  MechanismBuilder b = pendulum(0.3);
  const auto is = [](const char* words) { return ThrowsMessage<std::invalid_argument>(HasSubstr(words)); };
  EXPECT_THAT([&] { b.add("rod", RigidBody{.mass = 1.0}); }, is("a body is called \"rod\" already"));
  EXPECT_THAT([&] { b.add("", RigidBody{.mass = 1.0}); }, is("needs a name"));
  EXPECT_THAT([&] { b.add<Revolute>("other", b.ground().marker(), MechanismBuilder::Marker{99}); },
              is("is none of mechanism"));
  EXPECT_THAT(
      [&] {
        b.add<SpringDamper>("far", MechanismBuilder::Marker{99}, b.ground().marker(), {.stiffness = 1.0});
      },
      is("is none of mechanism"));
  EXPECT_THAT(
      [&] {
        b.add<JointForce>("push", CoordinateRef{0, 3}, b.formula("1"));
      },
      is("is none of mechanism"));
  EXPECT_THAT(
      [&] {
        b.add<JointForce>("pull", CoordinateRef{7, 0}, b.formula("1"));
      },
      is("is none of mechanism"));
  EXPECT_THAT([&] { b.formula("hinge.angel"); }, is("hinge.angle"));
  EXPECT_THAT([&] { b.parameter("t", 1.0); }, is("means something"));
  Simulation s(b.build());
  EXPECT_THAT([&] { s.output("hinge.angel"); }, is("no quantity"));
  EXPECT_THAT([&] { s.advance(0.0); }, is("above 0"));
  EXPECT_THAT([&] { Simulation(b.build(), {.tolerance = -1.0}); }, is("tolerance"));
  EXPECT_THAT([&] { Simulation(b.build(), {.method = Method::ida, .fixed_step = 1e-3}); },
              is("a fixed step goes with"));
  EXPECT_THAT([&] { Simulation(b.build(), {.fixed_step = 1e-3}); }, is("a fixed step goes with"));
  EXPECT_THAT([&] { Simulation(b.build(), {.method = Method::radau, .max_step = NAN}); }, is("max_step"));
  const auto other = b.add("wheel", RigidBody{.mass = 1.0, .inertia = Matrix3d::Identity()});
  auto axle = b.add<Revolute>("axle", b.ground().marker(), other.marker()).drive("2 * t");
  EXPECT_THAT([&] { axle.start(1.0); }, is("is driven"));
  EXPECT_THAT([&] { axle.drive("t"); }, is("keep one of them"));
}

}  // namespace
}  // namespace flexura::mbs
