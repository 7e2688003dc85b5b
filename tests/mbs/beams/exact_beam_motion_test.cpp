// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "mbs/mechanism/beam_part.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/position/quasi_static_start.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/statics/statics.hpp"

/// Geometrically exact beams, rods and cables in motion, against published and closed solutions.
namespace flexura::mbs {
namespace {

using beam::exact::Kind;
using Eigen::VectorXd;
using std::numbers::pi;

struct Chain {
  MechanismDescription d;
  Segments beam;

  int marker(int station, const std::string& name, const Pose& X = {}) {
    const Segments::Seat& seat = beam.seats[static_cast<std::size_t>(station)];
    return d.add_marker(seat.body, name, {X.R, seat.p + X.p}, seat.node);
  }
};

Chain chain(const BeamPart& part, Kind kind) {
  Chain out;
  const int root = out.d.add_body({.name = "beam"});
  out.beam = add_exact_elements(out.d, root, part, kind);
  return out;
}

/// The beam on a shaft along `axis`, its root on the shaft's, turned by a formula of t.
Chain on_driven_shaft(const BeamPart& part, Kind kind, const Matrix3d& axes, const std::string& angle,
                      const std::map<std::string, double>& parameters) {
  Chain out = chain(part, kind);
  const int hub = out.d.add_joint("hub", "revolute", out.d.add_marker(0, "shaft", {axes, Vector3d::Zero()}),
                                  out.marker(0, "root", {axes, Vector3d::Zero()}));
  out.d.joints[static_cast<std::size_t>(hub)].drives[0] =
      std::make_shared<Expression>("hub.drive", angle, SignalNames(), parameters);
  return out;
}

/// Of a beam's section in B, the frame of its root.
Pose tip_of(const Mechanism& mechanism, const Segments& beam, const State& s) {
  Pose X;
  for (const int piece : beam.bodies) {
    const FlexibleBody& body = *mechanism.description().bodies[static_cast<std::size_t>(piece)].flexible;
    X = X * body.node_pose(0, s.p.data() + mechanism.modal_position(piece));
  }
  return X;
}

// T. R. Kane, R. R. Ryan, A. K. Banerjee, J. Guid. Control Dyn. 10 (1987) 139, and S. C. Wu, E. J. Haug, Int. J. Numer. Meth.
// Eng. 26 (1988) 2211: a beam of 10 m on a hub that spins up to 6 rad/s within 15 s.  Numbers: tests/mbs/flexible/data/README.md.
TEST(ExactBeamInMotion, SpunUpBeamBendsBackAndStretches) {
  const double rho_I = 6e-4;
  BeamPart part;
  part.to_B = {10.0, 0.0, 0.0};
  part.elements = 4;
  part.C = Vector6d(2.8e7, 1e7, 1e7, 1e6, 1.4e6, 1.4e4).asDiagonal();
  part.mass_per_length = 1.2;
  part.rho_I_y = 100 * rho_I;
  part.rho_I_z = rho_I;
  const Chain beam =
      on_driven_shaft(part, Kind::beam, Matrix3d::Identity(),
                      "t < T ? W/T * (t^2/2 + (T/(2*pi))^2 * (cos(2*pi*t/T) - 1)) : W * (t - T/2)",
                      {{"W", 6.0}, {"T", 15.0}});
  Mechanism mechanism(beam.d);
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  SolverOptions solver;
  solver.method = "radau";
  solver.end_time = 20.0;
  solver.output_step = 0.02;
  solver.tolerance = 1e-4;
  double peak = 0.0, peak_time = 0.0, extension = 0.0;
  RunCallbacks callbacks;
  int rows = 0;
  callbacks.row = [&](const State& row, const VectorXd&, const EnergyAccount&) {
    const Vector3d u = tip_of(mechanism, beam.beam, row).p - part.to_B;
    if (u.y() < peak) {
      peak = u.y();
      peak_time = row.t;
    }
    if (row.t > 16.0) {
      extension += u.x();
      ++rows;
    }
  };
  const RunResult result = run(mechanism, s, v_dot, solver, callbacks);
  ASSERT_TRUE(result.complete) << result.stopped_because;
  // The reference is linear in the deflection, good to (w/L)^2 = 0.4 %.
  EXPECT_NEAR(peak, -0.57437, 0.005 * 0.57437);
  EXPECT_NEAR(peak_time, 6.762, 0.05);
  EXPECT_NEAR(extension / rows, 5.142857e-4, 0.01 * 5.142857e-4);
}

TEST(ExactBeamInMotion, RotatingCantileverStiffens) {
  // S. M. Hamza-Cherif, M. S. A. Houmat, ICAS 2004: L = m = EI = 1, slenderness 70.
  const double table[][3] = {
      {2, 4.1373, 3.6195}, {4, 5.5850, 3.888}, {6, 7.3603, 4.2393}, {8, 9.2568, 4.6105}, {10, 11.2023, 4.97}};
  const double EA = 4900, GA = EA * 5 / 6 / 2.6;
  BeamPart part;
  part.elements = 6;
  part.C = Vector6d(EA, GA, GA, 0.8, 1, 1).asDiagonal();
  part.rho_I_y = part.rho_I_z = 1 / EA;
  for (const auto& [mu, flap, chord] : table) {
    SCOPED_TRACE(mu);
    const Chain beam = on_driven_shaft(part, Kind::beam, Matrix3d::Identity(), "mu * t", {{"mu", mu}});
    Mechanism mechanism(beam.d);
    State s = mechanism.initial_state();
    VectorXd v_dot;
    assemble(mechanism, s, v_dot);
    start_quasi_static(mechanism, s, v_dot);
    double nearest_flap = 1e9, nearest_chord = 1e9;
    for (const NaturalMode& mode : natural_modes(linearise(mechanism, s))) {
      const double omega = 2 * pi * mode.frequency_hz;
      if (std::abs(omega - flap) < std::abs(nearest_flap - flap)) nearest_flap = omega;
      if (std::abs(omega - chord) < std::abs(nearest_chord - chord)) nearest_chord = omega;
    }
    // Linear theory against finite axial strain, mu^2/(2 EA) = 1 % at mu = 10, by which the beam gets longer too.
    EXPECT_NEAR(nearest_flap, flap, 0.015 * flap);
    EXPECT_NEAR(nearest_chord, chord, 0.015 * chord);
  }
}

// A light shaft clamped to a driven spindle, with a disc on its free end:
//     (k_11 - m w^2)(k_22 - theta_d w^2 + theta_p Omega w) = k_12^2,   K = EI/L^3 [12, -6L; -6L, 4L^2]
// gives the whirls w, forwards and backwards, in axes at rest; |w - Omega| in those of the shaft.
TEST(ExactBeamInMotion, OverhungRotorWhirls) {
  const double m = 2.0, theta_p = 0.06, theta_d = 0.035, L = 0.5, EI = 300.0, Omega = 150.0;
  BeamPart part;
  part.to_B = {L, 0.0, 0.0};
  part.elements = 2;
  part.C = Vector6d(1, 1, 1, 1e5, EI, EI).asDiagonal();
  part.mass_per_length = 1e-5;
  part.rho_I_y = part.rho_I_z = 1e-9;
  Matrix3d along_x;  // z of the bearing along the shaft
  along_x << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  Chain shaft = on_driven_shaft(part, Kind::rod, along_x, "W * t", {{"W", Omega}});
  shaft.d.gravity.setZero();
  const int disc =
      shaft.d.add_body({.name = "disc",
                        .inertia = RigidInertia::from_center(
                            m, Vector3d::Zero(), Vector3d(theta_p, theta_d, theta_d).asDiagonal())});
  shaft.d.add_joint("seat", "fixed", shaft.marker(1, "tip"), shaft.d.add_marker(disc, "in"));
  Mechanism mechanism(shaft.d);
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);

  const double k_11 = 12 * EI / (L * L * L), k_12 = 6 * EI / (L * L), k_22 = 4 * EI / L;
  // c_4 w^4 + c_3 w^3 + c_2 w^2 + c_1 w + c_0.
  const double c_4 = m * theta_d, c_3 = -m * theta_p * Omega, c_2 = -(m * k_22 + k_11 * theta_d),
               c_1 = k_11 * theta_p * Omega, c_0 = k_11 * k_22 - k_12 * k_12;
  Eigen::Matrix4d companion = Eigen::Matrix4d::Zero();
  companion.row(0) << -c_3 / c_4, -c_2 / c_4, -c_1 / c_4, -c_0 / c_4;
  companion(1, 0) = companion(2, 1) = companion(3, 2) = 1.0;
  const Eigen::Vector4cd whirls = companion.eigenvalues();
  const auto modes = natural_modes(linearise(mechanism, s));
  for (int i = 0; i < 4; ++i) {
    ASSERT_LT(std::abs(whirls(i).imag()), 1e-6);
    const double omega = std::abs(whirls(i).real() - Omega);
    double nearest = 1e9;
    for (const NaturalMode& mode : modes)
      if (std::abs(2 * pi * mode.frequency_hz - omega) < std::abs(nearest - omega))
        nearest = 2 * pi * mode.frequency_hz;
    EXPECT_NEAR(nearest, omega, 1e-4 * omega);  // the shaft's mass is 2.5e-6 of the disc's
  }
}

// A cable without bending stiffness that hangs from a point swings at j_0,n / 2 sqrt(g/L), j_0,n the zeros of Bessel's J_0
// (D. Bernoulli 1738).
TEST(ExactBeamInMotion, HangingCableSwingsAsBernoulliSays) {
  const double zeros[] = {2.404825557695773, 5.520078110286311, 8.653727912911013};
  const double L = 2.0, g = 9.81;
  double error[2][3];
  for (const int refined : {0, 1}) {
    BeamPart part;
    part.to_B = {0.0, 0.0, -L};
    part.elements = refined ? 16 : 8;
    part.C.setZero();
    part.C(0, 0) = 1e7;  // stretches by 1e-6 of the length
    part.mass_per_length = 0.5;
    part.rho_I_y = part.rho_I_z = 1e-10;
    Chain cable = chain(part, Kind::cable);
    cable.d.gravity = {0.0, 0.0, -g};
    cable.d.add_joint("hook", "spherical", cable.d.add_marker(0, "o"), cable.marker(0, "root"));
    Mechanism mechanism(cable.d);
    State s = mechanism.initial_state();
    solve_statics(mechanism, s);
    const auto modes = natural_modes(linearise(mechanism, s));
    for (const int n : {0, 1, 2}) {
      const double exact = 0.5 * zeros[n] * std::sqrt(g / L);
      double nearest = 1e9;
      for (const NaturalMode& mode : modes)
        nearest = std::min(nearest, std::abs(2 * pi * mode.frequency_hz - exact) / exact);
      error[refined][n] = nearest;
    }
  }
  for (const int n : {0, 1, 2}) {
    EXPECT_LT(error[0][n], 0.02);
    EXPECT_LT(error[1][n], 0.3 * error[0][n] + 2e-6);  // at least second order, down to the stretch
  }
}

// L. Prandtl, A. G. M. Michell 1899 (S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, 6.3): a narrow cantilever under a
// load P at its tip tips over at P = 4.0126 sqrt(EI_z GI_t) / L^2.  Its bending before, EI_z/EI_y = 1e-4, raises that by 1e-4.
TEST(ExactBeamInMotion, NarrowCantileverTipsOver) {
  const auto grows = [](double P) {
    BeamPart part;
    part.elements = 8;
    part.C = Vector6d(1, 1, 1, 1.0, 1e4, 1.0).asDiagonal();
    part.mass_per_length = 1e-6;
    part.rho_I_y = part.rho_I_z = 1e-8;
    Chain beam = chain(part, Kind::rod);
    beam.d.gravity = {0.0, 0.0, -P};
    beam.d.add_joint("clamp", "fixed", beam.d.add_marker(0, "wall"), beam.marker(0, "root"));
    const int load = beam.d.add_body(
        {.name = "load",
         .inertia = RigidInertia::from_center(1.0, Vector3d::Zero(), 1e-8 * Matrix3d::Identity())});
    beam.d.add_joint("hold", "fixed", beam.marker(1, "tip"), beam.d.add_marker(load, "in"));
    Mechanism mechanism(beam.d);
    State s = mechanism.initial_state();
    solve_statics(mechanism, s);
    double fastest = 0.0;
    for (const NaturalMode& mode : natural_modes(linearise(mechanism, s)))
      fastest = std::max(fastest, mode.eigenvalue.real());
    return fastest > 0.01;  // at rest all eigenvalues are imaginary, to round-off
  };
  EXPECT_FALSE(grows(0.99 * 4.0126));
  EXPECT_TRUE(grows(1.01 * 4.0126));
}

// Thrown, bent and spinning: no forces, no damping.  The run's own account of energy holds to what the tolerance allows.
TEST(ExactBeamInMotion, FreeFlightKeepsEnergyAndMomentum) {
  BeamPart part;
  part.elements = 3;
  part.C = Vector6d(1e3, 5e2, 5e2, 2.0, 3.0, 4.0).asDiagonal();
  part.mass_per_length = 1.0;
  part.rho_I_y = 2e-3;
  part.rho_I_z = 3e-3;
  Chain beam = chain(part, Kind::beam);
  beam.d.gravity.setZero();
  // Beside the tip, so that spin bends and twists the beam.
  const int mass = beam.d.add_body(
      {.name = "mass",
       .inertia = RigidInertia::from_center(1.0, {0.0, 0.2, 0.1}, 1e-3 * Matrix3d::Identity())});
  beam.d.add_joint("hold", "fixed", beam.marker(1, "tip"), beam.d.add_marker(mass, "in"));
  const int free = beam.d.add_joint("free", "six_dof", beam.d.add_marker(0, "o"), beam.marker(0, "root"));
  beam.d.joints[static_cast<std::size_t>(free)].initial_speeds = {{0, 3.0}, {1, -4.0}, {2, 5.0}, {4, 1.0}};
  Mechanism mechanism(beam.d);
  State s = mechanism.initial_state();
  VectorXd v_dot;
  assemble(mechanism, s, v_dot);
  SolverOptions solver;
  solver.method = "radau";
  solver.end_time = 0.3;
  solver.output_step = 0.02;
  solver.tolerance = 1e-7;
  double first = 0.0, largest_change = 0.0, strain = 0.0;
  const auto scratch = mechanism.make_scratch();
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const VectorXd& a, const EnergyAccount&) {
    const EnergyReport e = mechanism.energy(row, a, *scratch);
    if (row.t == 0.0) first = e.kinetic + e.strain;
    strain = std::max(strain, e.strain);
    largest_change = std::max(largest_change, std::abs(e.kinetic + e.strain - first));
  };
  const RunResult result = run(mechanism, s, v_dot, solver, callbacks);
  ASSERT_TRUE(result.complete) << result.stopped_because;
  EXPECT_GT(strain, 5e-3 * first);  // it does bend, and a thousandth of that is what may be lost
  EXPECT_LT(largest_change, 5e-6 * first);
}

}  // namespace
}  // namespace flexura::mbs
