// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include "tests/mbs/moving/girder.hpp"

/// What is free to travel along a girder.
namespace flexura::mbs::moving {
namespace {

using cases::Series;
using cases::simulate;
using Eigen::VectorXd;
using Beam = moving::Series;
constexpr double kG = 9.81;

class Trolleys : public GirderTest {};

// A trolley of 200 kg that runs freely on the girder, with a pendulum of 300 kg on a rope of 3 m, let go at 40 degrees: the
// trolley is drawn to and fro and the girder bends under both.  Independent: Lagrange's equations of the particles
//
//     trolley (s, w),   bob (s + l sin theta, w - l cos theta),   w = sum q_n phi_n(s)
//
// with twelve modes of the girder, and Kutta's method: J^T m J z'' = J^T (F - m J' z') for z = (s, theta, q).
struct Pendulum {
  static constexpr int N = 12;
  double M = 200.0, m = 300.0, l = 3.0;

  VectorXd rates(const VectorXd& y) const {
    constexpr int n = 2 + N;
    const double s = y(0), theta = y(1), s_dot = y(n), theta_dot = y(n + 1);
    // Rows: x and z of the trolley, x and z of the bob.
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, n);
    Eigen::Vector4d bias = Eigen::Vector4d::Zero();
    double slope = 0.0, bend = 0.0, turn = 0.0;
    for (int i = 1; i <= N; ++i) {
      J(1, 1 + i) = J(3, 1 + i) = Beam::phi(i, s);
      slope += y(1 + i) * Beam::phi_1(i, s);
      bend += y(1 + i) * Beam::phi_2(i, s);
      turn += y(n + 1 + i) * Beam::phi_1(i, s);
    }
    J(0, 0) = J(2, 0) = 1.0;
    J(1, 0) = J(3, 0) = slope;
    J(2, 1) = l * std::cos(theta);
    J(3, 1) = l * std::sin(theta);
    bias(1) = bias(3) = 2.0 * turn * s_dot + bend * s_dot * s_dot;
    bias(2) -= l * std::sin(theta) * theta_dot * theta_dot;
    bias(3) += l * std::cos(theta) * theta_dot * theta_dot;
    const Eigen::Vector4d mass(M, M, m, m), force(0.0, -M * kG, 0.0, -m * kG);
    Eigen::MatrixXd A = J.transpose() * mass.asDiagonal() * J;
    VectorXd b = J.transpose() * (force - Eigen::Vector4d(mass.cwiseProduct(bias)));
    for (int i = 1; i <= N; ++i) {
      A(1 + i, 1 + i) += 0.5 * kMass * kL;
      b(1 + i) -= 0.5 * kMass * kL * std::pow(Beam::omega(i), 2) * y(1 + i);
    }
    VectorXd out(2 * n);
    out << y.tail(n), A.partialPivLu().solve(b);
    return out;
  }
};

TEST_F(Trolleys, WithAPendulumSwingsOnABendingGirder) {
  const Pendulum model;
  constexpr int n = 2 + Pendulum::N, kRows = 15, kSteps = 800;
  constexpr double kEnd = 1.5;
  VectorXd y = VectorXd::Zero(2 * n);
  y(0) = 4.0;
  y(1) = 40.0 * std::numbers::pi / 180.0;
  double t = 0.0;
  std::vector<Eigen::Vector3d> exact;
  const auto note = [&] {
    double middle = 0.0;
    for (int i = 1; i <= Pendulum::N; ++i) middle += y(1 + i) * Beam::phi(i, 0.5 * kL);
    exact.emplace_back(y(0), y(1), middle);
  };
  note();
  for (int row = 0; row < kRows; ++row) {
    for (int i = 0; i < kSteps; ++i)
      kutta([&](double, const VectorXd& at) { return model.rates(at); }, t, y, kEnd / (kRows * kSteps));
    note();
  }
  double travel = 0.0, sag = 0.0;
  for (const Eigen::Vector3d& row : exact) {
    travel = std::max(travel, std::abs(row(0) - 4.0));
    sag = std::max(sag, std::abs(row(2)));
  }
  EXPECT_GT(travel, 1.0);
  EXPECT_GT(sag, 5e-3);

  const std::string trolley = fmt::format(
      R"toml(
[body.trolley]
mass = {0}
inertia = [1, 1, 1]
position = [4, 0, 0]
[body.trolley.marker.hook]
axis = [0, -1, 0]
[body.bob]
mass = {1}
inertia = [1e-6, 1e-6, 1e-6]
position = [{2}, 0, {3}]
[body.bob.marker.rope]
position = [0, 0, {4}]
axis = [0, -1, 0]
[joint.rope]
type = "revolute"
from = "trolley.hook"
to = "bob.rope"
angle = "40 deg"
[force.weight]
type = "force"
marker = "trolley"
z = {5}
[force.load]
type = "force"
marker = "bob"
z = {6}
[constraint.rail]
type = "point_on_path"
to = "trolley"
)toml",
      model.M, model.m, 4.0 + model.l * std::sin(40.0 * std::numbers::pi / 180.0),
      -model.l * std::cos(40.0 * std::numbers::pi / 180.0), model.l, -model.M * kG, -model.m * kG);
  // Off by the line through nine markers, as the mass in moving_load_test.cpp.
  const double error = 3e-3;
  // Weights are forces on the two bodies: the girder's own would bend it beside them.
  const auto p =
      prepared("gravity = [0, 0, 0]\n" + girder("modal") + trolley + path + solve(kEnd, kRows, 1e-7));
  const Series run = simulate(p, {"rail.place", "z", "trolley.position_x", "bob.position_x"});
  double off_place = 0.0, off_sag = 0.0, off_bob = 0.0;
  for (std::size_t i = 0; i < run.t.size(); ++i) {
    off_place = std::max(off_place, std::abs(run.values[i](0) - exact[i](0)));
    off_sag = std::max(off_sag, std::abs(run.values[i](1) - exact[i](2)));
    off_bob = std::max(off_bob, std::abs(run.values[i](3) - exact[i](0) - model.l * std::sin(exact[i](1))));
  }
  EXPECT_LT(off_place, error * travel);
  EXPECT_LT(off_bob, error * travel);
  EXPECT_LT(off_sag, 2.0 * error * sag);
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

// A bead slides down a cantilever of exact beams that hangs far under its own weight: by no closed form, but what gravity
// does goes into motion and strain, nothing else; the reaction stands normal to the bent line.
TEST_F(Trolleys, BeadSlidesDownABeamThatBendsFar) {
  std::string text =
      "[body.rail]\nfidelity = \"beam\"\n[body.rail.beam]\nto = [1, 0, 0]\nelements = 6\nyoung = \"20 "
      "MPa\"\ndensity = \"1200 kg/m^3\"\nwidth = \"20 mm\"\nheight = \"20 mm\"\n";
  for (int i = 1; i < 8; ++i) text += fmt::format("point.p{}.at = {}\n", i, i / 8.0);
  text += R"toml(
[joint.clamp]
type = "fixed"
from = "ground"
to = "rail.root"
[body.bead]
mass = 0.1
inertia = [1e-5, 1e-5, 1e-5]
position = [0.1, 0, 0]
velocity = [0.5, 0, 0]
[constraint.slide]
type = "point_on_path"
to = "bead"
path = ["rail.root", "rail.p1", "rail.p2", "rail.p3", "rail.p4", "rail.p5", "rail.p6", "rail.p7", "rail.tip"]
[measure.z]
type = "position"
from = "ground"
to = "rail.tip"
direction = [0, 0, 1]
)toml";
  const auto p = prepared("gravity = [0, 0, -9.81]\n" + text + solve(0.4, 20, 1e-8));
  const Series run = simulate(p, {"slide.place", "slide.speed", "z", "slide.force_x", "slide.force"});
  const VectorXd& last = run.values.back();
  EXPECT_GT(last(0), 0.4);
  EXPECT_LT(last(2), -0.3);
  for (const VectorXd& row : run.values) EXPECT_LT(std::abs(row(3)), 1e-9 * (1.0 + row(4)));
  EXPECT_LT(std::abs(run.result.energy.relative_error()), 1e-6);
}

}  // namespace
}  // namespace flexura::mbs::moving
