// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/dynamics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "beam/ancf/ancf_kinematics.hpp"
#include "tests/beam/ancf/samples.hpp"

namespace flexura::beam::ancf {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The root of a planar line turns with a hub: r_x . n(theta(t)) = 0, while r_x may stretch.
class HubClamp : public Constraint {
 public:
  explicit HubClamp(std::function<double(double)> angle) : angle_(std::move(angle)) {}
  int rows() const override { return 1; }
  void evaluate(double t, const VectorXd& q, VectorRef g, Triplets* G) const override {
    const Vector2d n(-std::sin(angle_(t)), std::cos(angle_(t)));
    g[0] = n.dot(q.segment<2>(2));
    if (!G) return;
    G->emplace_back(0, 2, n[0]);
    G->emplace_back(0, 3, n[1]);
  }

 private:
  std::function<double(double)> angle_;
};

TEST(AncfDynamics, SpunUpBeamBendsBackStretchesAndDoesNotSoften) {
  // J. C. Simo, L. Vu-Quoc, J. Appl. Mech. 53 (1986) 855.  The peak is a converged modal computation with
  // centrifugal stiffness, linear in the deflection w: error of order (w/L)^2 = 0.3 %; the extension is rho A
  // W^2 L^3/(3 EA).
  const double L = 10, W = 6, T = 15;
  const LineSection section{.EA = 2.8e7, .EI = 1.4e4, .mass_per_length = 1.2};
  const auto angle = [=](double t) {
    const double c = T / (2 * M_PI);
    return t < T ? W / T * (t * t / 2 + c * c * (std::cos(2 * M_PI * t / T) - 1)) : W * (t - T / 2);
  };
  const AncfBody body = planar_line(section, straight_curve({0, 0, 0}, {L, 0, 0}, 8));
  Problem problem = held(body, {0, 1});
  problem.constraints.push_back(std::make_shared<HubClamp>(angle));
  double peak = 0, peak_time = 0, extension = 0;
  int samples = 0;
  const auto observe = [&](const DynamicState& s) {
    const Vector2d tip = s.q.segment<2>(body.index(8, 0));
    const Vector2d t(std::cos(angle(s.t)), std::sin(angle(s.t))), n(-t[1], t[0]);
    if (n.dot(tip) < peak) {
      peak = n.dot(tip);
      peak_time = s.t;
    }
    if (s.t > T + 1) {
      extension += t.dot(tip) - L;
      ++samples;
    }
  };
  // Bending turns at 4 to 7 rad/s: with dt = 0.01 s the period is right to (omega dt)^2/12 = 4e-4.
  simulate(problem, body.rest(), VectorXd::Zero(body.n_q()), 20.0, {.dt = 0.01, .rho_inf = 0.6}, observe);
  EXPECT_NEAR(peak, -0.57437, 0.01 * 0.57437);
  EXPECT_NEAR(peak_time, 6.762, 0.05);
  EXPECT_NEAR(extension / samples, 5.142857e-4, 0.01 * 5.142857e-4);
}

VectorXd tumbling(const AncfBody& body) {
  // A rigid motion plus a bending velocity that grows along the beam.
  VectorXd v(body.n_q());
  const int d = body.dim();
  const Vector3d spin(d == 3 ? 1.0 : 0.0, d == 3 ? -0.5 : 0.0, 2.0);
  for (int i = 0; i < body.n_q() / d; ++i) {
    Vector3d at = Vector3d::Zero();
    at.head(d) = body.rest().segment(d * i, d);
    v.segment(d * i, d) = spin.cross(at).head(d);
    if (i % body.vectors() == 0) {
      v[d * i] += 0.3;
      v[d * i + 1] += 0.8 * at[0] * at[0];
    }
    if (i % body.vectors() == 1) v[d * i + 1] += 1.6 * body.rest()[d * (i - 1)];
  }
  return v;
}

TEST(AncfDynamics, FreeFlightKeepsItsMomenta) {
  const auto curve = straight_curve({0, 0, 0}, {1, 0, 0}, 4);
  const LineSection line{.EA = 500, .EI = 0.4, .mass_per_length = 1};
  std::vector<std::pair<std::string, AncfBody>> bodies;
  bodies.emplace_back("planar line", planar_line(line, curve));
  bodies.emplace_back("spatial line", spatial_line(line, curve));
  bodies.emplace_back("spatial beam",
                      spatial_beam(uncoupled_section(500, 200, 200, 0.3, 0.4, 0.5, 1, 1e-3, 1.2e-3), curve));
  const Vector3d g(0, -9.81, 0);
  for (const auto& [name, body] : bodies) {
    Problem problem = held(body, {});
    problem.loads.push_back(constant_load(body.gravity_force(g)));
    const VectorXd v = tumbling(body);
    const double t_end = 0.5;
    const Momentum start = body.momentum(body.rest(), v);
    const double energy = body.kinetic_energy(v);
    double errors[2], energy_errors[2];
    for (int k = 0; k < 2; ++k) {
      const double dt = k == 0 ? 2e-3 : 1e-3;
      const auto s = simulate(problem, body.rest(), v, t_end, {.dt = dt, .rho_inf = 0.9, .tolerance = 1e-12});
      const Momentum end = body.momentum(s.q, s.v);
      // Linear momentum: the scheme integrates constant forces exactly, and internal forces cancel to
      // Newton's tolerance, 1e-12 of accelerations 1/dt^2 over t_end: 1e-12/dt per step, 1e-6 at worst;
      // measured far below.
      const Vector3d p = start.linear + body.total_mass() * g * t_end;
      EXPECT_LT((end.linear - p).norm(), 1e-9) << name;
      // Angular momentum about the origin changes by the moment of the weight: m g x (c_0 t + u_0 t^2/2),
      // with c_0 and u_0 centre and velocity of the mass; the scheme keeps it to second order.
      const Vector3d c_0(0.5, 0, 0), u_0 = start.linear / body.total_mass();
      const Vector3d moment = body.total_mass() * (c_0 * t_end + 0.5 * u_0 * t_end * t_end).cross(g);
      errors[k] = (end.angular - start.angular - moment).norm() / start.angular.norm();
      const Vector3d c_end = c_0 + u_0 * t_end + 0.5 * g * t_end * t_end;
      const double total =
          body.kinetic_energy(s.v) + body.strain_energy(s.q) - body.total_mass() * g.dot(c_end - c_0);
      energy_errors[k] = std::abs(total / energy - 1);
    }
    // Second order: a quarter for half the step; the size is that of (omega dt)^2 for the beam's slow
    // bending.
    EXPECT_LT(errors[0], 1e-5) << name;
    EXPECT_LT(errors[1], errors[0] / 3.5) << name;
    EXPECT_LT(energy_errors[0], 5e-5) << name;
    EXPECT_LT(energy_errors[1], energy_errors[0] / 3.5) << name;
  }
}

TEST(AncfDynamics, DampingTakesWhatItDissipates) {
  LineSection line{
      .EA = 500, .EI = 0.4, .mass_per_length = 1, .damping_time_axial = 2e-3, .damping_time_bending = 2e-2};
  const AncfBody body = planar_line(line, straight_curve({0, 0, 0}, {1, 0, 0}, 4));
  const Problem problem = held(body, {});
  const VectorXd v = tumbling(body);
  const double start = body.kinetic_energy(v);
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    const double dt = k == 0 ? 1e-3 : 5e-4;
    double lost = 0, last = body.dissipation(body.rest(), v), energy = start;
    simulate(problem, body.rest(), v, 0.3, {.dt = dt, .rho_inf = 1.0}, [&](const DynamicState& s) {
      if (s.t == 0.0) return;
      const double now = body.dissipation(s.q, s.v);
      lost += 0.5 * dt * (last + now);
      last = now;
      energy = body.kinetic_energy(s.v) + body.strain_energy(s.q);
    });
    EXPECT_GT(lost, 1e-3 * start);
    errors[k] = std::abs(start - energy - lost) / lost;
  }
  // Scheme (rho_inf = 1 loses nothing) and trapezoidal sum are of second order.
  EXPECT_LT(errors[0], 2e-3);
  EXPECT_LT(errors[1], errors[0] / 3.5);
}

TEST(AncfDynamics, RefusesOptionsOutOfRange) {
  const LineSection line{.EA = 500, .EI = 0.4, .mass_per_length = 1};
  const AncfBody body = planar_line(line, straight_curve({0, 0, 0}, {1, 0, 0}, 1));
  const Problem problem = held(body, {});
  const VectorXd still = VectorXd::Zero(body.n_q());
  using testing::HasSubstr;
  using testing::ThrowsMessage;
  EXPECT_THAT([&] { simulate(problem, body.rest(), still, 1, {.dt = -1}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("dt is -1 s")));
  EXPECT_THAT([&] { simulate(problem, body.rest(), still, 1, {.rho_inf = 2}); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("rho_inf is 2")));
  const Problem twice = held(body, {3, 3});
  EXPECT_THAT([&] { simulate(twice, body.rest(), still, 1); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("coordinate 3 is fixed or driven twice")));
}

}  // namespace
}  // namespace flexura::beam::ancf
