// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <numbers>

#include "mbs/bodies/one_way_body.hpp"
#include "mbs/solver/linear/linearise.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;

enum class Fidelity { rigid, ked, modal };

BodyDescription body_of(const superelement::Superelement& se, const BasisOptions& options,
                        Fidelity fidelity) {
  BodyDescription body{.name = "beam"};
  if (fidelity == Fidelity::rigid) body.inertia = rigid_inertia(se);
  if (fidelity == Fidelity::ked) body.flexible = std::make_shared<OneWayBody>(modal_data(se, options));
  if (fidelity == Fidelity::modal) body.flexible = std::make_shared<ModalBody>(modal_data(se, options));
  return body;
}

/// A marker on an interface in each fidelity.
int interface_marker(MechanismDescription& d, int body, const superelement::Superelement& se, int interface,
                     Fidelity fidelity) {
  const superelement::Interface& i = se.interfaces[interface];
  if (fidelity != Fidelity::rigid) return d.add_marker(body, i.name, {}, interface);
  return d.add_marker(body, i.name, {Matrix3d::Identity(), i.p_BoN_B});
}

TEST(OneWayDeformation, LeavesTheRigidMotionAlone) {
  const auto l = lattice::make_lattice(3);
  const auto mechanism = [&](Fidelity fidelity) {
    Random random(3);
    MechanismDescription d;
    d.gravity = {0.3, -9.0, 1.0};
    const int carrier = d.add_body({.name = "carrier", .inertia = random.inertia()});
    d.add_joint("base", "six_dof", d.add_marker(0, "o"), d.add_marker(carrier, "o"));
    const int beam = d.add_body(body_of(l.se, {}, fidelity));
    d.add_joint("root", "revolute", d.add_marker(carrier, "hand", random.pose()),
                interface_marker(d, beam, l.se, 0, fidelity));
    const int weight = d.add_body({.name = "weight", .inertia = random.inertia()});
    d.add_joint("tip", "spherical", interface_marker(d, beam, l.se, 1, fidelity),
                d.add_marker(weight, "in", random.pose()));
    return Mechanism(d);
  };
  const Mechanism rigid = mechanism(Fidelity::rigid), ked = mechanism(Fidelity::ked);
  ASSERT_EQ(ked.sizes().n_v, rigid.sizes().n_v);
  const int m = l.se.n() - 6;
  ASSERT_EQ(ked.sizes().n_dyn, 2 * m);
  State s = random_state(rigid, 8);
  const Sizes n = ked.sizes();
  Random random(4);
  const VectorXd v_dot = random.vector(n.n_v);
  VectorXd r(n.n_v), r_rigid(n.n_v), c_rate(n.n_dyn), none(0), b(0);
  rigid.momentum(s, v_dot, *rigid.make_scratch(), r_rigid, none, b);
  s.c = random.vector(n.n_dyn, 0.1);
  ked.momentum(s, v_dot, *ked.make_scratch(), r, c_rate, b);
  EXPECT_EQ(r, r_rigid);
  // The first half of the states changes at the rate that the second half holds.
  EXPECT_EQ(c_rate.head(m), s.c.tail(m));
  EXPECT_EQ(ked.name_of_dynamic(m), "beam.mode_1_rate");
}

TEST(OneWayDeformation, DerivativesAgreeWithDifferences) {
  const auto l = lattice::make_lattice(3);
  MechanismDescription d;
  Random random(5);
  d.gravity = {0.3, -9.0, 1.0};
  const int beam = d.add_body(body_of(l.se, {}, Fidelity::ked));
  d.add_joint("root", "revolute", d.add_marker(0, "o", random.pose()),
              interface_marker(d, beam, l.se, 0, Fidelity::ked));
  const Mechanism m(d);
  const Sizes n = m.sizes();
  State s = random_state(m, 6);
  s.c = random.vector(n.n_dyn, 0.1);
  const VectorXd v_dot = random.vector(n.n_v);
  TangentMatrices tangents;
  const int n_z = n.n_v + n.n_dyn;
  tangents.z_p.setZero(n_z, n.n_p);
  tangents.z_v.setZero(n_z, n.n_v);
  tangents.z_c.setZero(n_z, n.n_dyn);
  tangents.z_a.setZero(n_z, 0);
  tangents.h_p.setZero(0, n.n_p);
  const auto scratch = m.make_scratch();
  ASSERT_TRUE(m.tangents(s, v_dot, TangentScope::everything, *scratch, tangents));
  const auto by = [&](VectorXd& x, int j) {
    VectorXd z[2] = {VectorXd::Zero(n_z), VectorXd::Zero(n_z)}, none(0);
    const double x_j = x(j), h = 1e-5;
    for (const int k : {0, 1}) {
      x(j) = x_j + (k == 0 ? h : -h);
      m.momentum(s, v_dot, *scratch, z[k].head(n.n_v), z[k].tail(n.n_dyn), none);
    }
    x(j) = x_j;
    return VectorXd((z[0] - z[1]) / (2.0 * h));
  };
  // Central differences: truncation h^2 and round-off eps / h are both below 1e-9 of the largest entry.
  const double scale = 1e-8 * tangents.z_c.cwiseAbs().maxCoeff();
  for (int j = 0; j < n.n_dyn; ++j)
    EXPECT_LE((by(s.c, j) - tangents.z_c.col(j)).cwiseAbs().maxCoeff(), scale) << j;
  for (int j = 0; j < n.n_v; ++j)
    EXPECT_LE((by(s.v, j) - tangents.z_v.col(j)).cwiseAbs().maxCoeff(), scale) << j;
  for (int j = 0; j < n.n_p; ++j)
    EXPECT_LE((by(s.p, j) - tangents.z_p.col(j)).cwiseAbs().maxCoeff(), scale) << j;
}

TEST(OneWayDeformation, VibratesBetweenTwoPinsAsAPinnedBeam) {
  // What the rigid motion's reactions cannot tell the body, that its ends are held, its frame must.
  beams::StraightBeam b;
  b.EA = 1e6;
  b.GI_t = b.EI_y = b.EI_z = 100.0;
  b.elements = 8;
  const superelement::Superelement se = beams::beam_superelement(b);
  BasisOptions options;
  options.held.resize(se.n(),
                      6);  // loads: torque, then force; the line between the ends, and no twist at the root
  const Eigen::MatrixXd root = interface_loads(se, 0), tip = interface_loads(se, 1);
  options.held << root.rightCols(3), tip.rightCols(2), root.col(0);
  options.frame = options.held;
  options.loads = interface_loads(se, {0, 1});
  options.modes = 6;
  const ModalData data = modal_data(se, options);
  const double pinned = std::pow(std::numbers::pi, 4) * 100.0 / (b.mass_per_length * std::pow(b.length, 4));
  // Eight cubic elements: (pi / 8)^4 / 720 = 3e-5 of omega^2.
  EXPECT_NEAR(data.stiffness(0), pinned, 1e-4 * pinned);
  EXPECT_NEAR(data.stiffness(1), pinned, 1e-4 * pinned);
  // The frame lies where the conditions hold it.
  EXPECT_LE((options.held.transpose() * data.Y).cwiseAbs().maxCoeff(), 1e-9 * data.Y.cwiseAbs().maxCoeff());
}

TEST(OneWayDeformation, IsTheForcedVibrationOfTheRigidMotion) {
  // A cantilever on a shaft that swings by a small angle about an axis through its root: the shaft is driven,
  // so deformation cannot change the motion, and KED and modal agree to second order in the angle.
  beams::StraightBeam b;
  b.EA = 1e6;
  b.GI_t = b.EI_y = 1e4;
  b.elements = 8;
  const superelement::Superelement se = beams::beam_superelement(b);
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  options.modes = 2;
  options.damping = 0.02;
  const auto history = [&](Fidelity fidelity) {
    MechanismDescription d;
    const int beam = d.add_body(body_of(se, options, fidelity));
    const int hub =
        d.add_joint("hub", "revolute", d.add_marker(0, "shaft"), interface_marker(d, beam, se, 0, fidelity));
    d.joints[hub].drives[0] = std::make_shared<Expression>("hub", "1e-3 * sin(2.5*t)", SignalNames(),
                                                           std::map<std::string, double>{});
    Mechanism mechanism(d);
    State s = mechanism.initial_state();
    VectorXd v_dot;
    assemble(mechanism, s, v_dot);
    SolverOptions solver;
    solver.method = "runge_kutta";  // two slow modes; BDF of low order takes a hundred times as long
    solver.end_time = 6.0;
    solver.output_step = 0.05;
    solver.tolerance = 1e-9;
    solver.absolute_factor = 1e-3;
    std::vector<double> tip;
    RunCallbacks callbacks;
    callbacks.row = [&](const State& row, const VectorXd&, const EnergyAccount&) {
      tip.push_back(mechanism.deforming(1)->node_pose(1, mechanism.modal_coordinates(1, row)).p.y());
    };
    EXPECT_TRUE(run(mechanism, s, v_dot, solver, callbacks).complete);
    return tip;
  };
  const std::vector<double> modal = history(Fidelity::modal), ked = history(Fidelity::ked);
  ASSERT_EQ(modal.size(), ked.size());
  double largest = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < modal.size(); ++k) {
    largest = std::max(largest, std::abs(modal[k]));
    difference = std::max(difference, std::abs(modal[k] - ked[k]));
  }
  EXPECT_GT(largest, 5e-4);
  // Second order: 1e-6 of it; the integrators' errors accumulate to some 1e-7.
  EXPECT_LE(difference, 3e-6 * largest);
}

/// The first bending frequency [rad/s] of a beam with L = m = EI = 1 that is clamped to a free hub of inertia
/// J: y^(4) = beta^4 y with y(0) = 0, y''(0) = -J beta^4 y'(0), no moment and no shear force at 1, between
/// the clamped beam's beta = 1.8751 and the pinned one's 3.9266.
double hub_and_beam(double J) {
  const auto determinant = [J](double beta) {
    const double s = std::sin(beta), c = std::cos(beta), sh = std::sinh(beta), ch = std::cosh(beta);
    const double k = 0.5 * J * beta * beta * beta;  // y = A sin + B sinh + k (A + B) (cos - cosh)
    return (-s - k * (c + ch)) * (ch + k * (s - sh)) - (sh - k * (c + ch)) * (-c + k * (s - sh));
  };
  double low = 1.8751, high = 3.9267;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    ((determinant(middle) > 0.0) == (determinant(low) > 0.0) ? low : high) = middle;
  }
  return low * low;
}

TEST(OneWayDeformation, FailsWhereTheDeformationTurnsWhatCarriesIt) {
  beams::StraightBeam b;
  b.EA = 1e4;
  b.rho_I_y = b.rho_I_z = 1e-9;
  b.elements = 8;
  const superelement::Superelement se = beams::beam_superelement(b);
  BasisOptions options;
  options.held = interface_loads(se, 0);
  options.fixed_interface = 0;
  const double clamped = 3.516015, own = 1.0 / 3.0;  // the beam's inertia about its root
  const auto first_frequency = [&](double J, Fidelity fidelity) {
    MechanismDescription d;
    const int hub = d.add_body(
        {.name = "hub", .inertia = RigidInertia::from_center(1.0, {0, 0, 0}, J * Matrix3d::Identity())});
    d.add_joint("shaft", "revolute", d.add_marker(0, "shaft"), d.add_marker(hub, "shaft"));
    const int beam = d.add_body(body_of(se, options, fidelity));
    d.add_joint("clamp", "fixed", d.add_marker(hub, "rim"), interface_marker(d, beam, se, 0, fidelity));
    const Mechanism m(d);
    for (const NaturalMode& mode : natural_modes(linearise(m, m.initial_state())))
      if (mode.frequency_hz > 0.3) {
        // In the plane of the turn: the other first bending mode does not know of the hub.
        const double omega = 2.0 * std::numbers::pi * mode.frequency_hz;
        if (fidelity == Fidelity::ked || omega > 1.0001 * clamped) return omega;
      }
    return 0.0;
  };
  for (const double part : {100.0, 1.0, 0.1}) {
    SCOPED_TRACE(part);
    const double exact = hub_and_beam(part * own);
    // Eight cubic elements: (3.9 / 8)^4 / 720 = 8e-5 of omega^2 at most; stretch is 1e4 times as stiff.
    EXPECT_NEAR(first_frequency(part * own, Fidelity::modal) / exact, 1.0, 1e-4);
    // One-way the beam vibrates as on a hub that nothing turns, whatever its inertia.
    EXPECT_NEAR(first_frequency(part * own, Fidelity::ked) / clamped, 1.0, 1e-4);
  }
  // So KED is right by 1 % on a hub a hundred times as heavy, and useless on one as light as the beam.
  EXPECT_LT(hub_and_beam(100.0 * own) / clamped, 1.01);
  EXPECT_GT(hub_and_beam(own) / clamped, 1.3);
}

}  // namespace
}  // namespace flexura::mbs
