// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/solver/position/assemble.hpp"
#include "mbs/solver/run/run.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"

/// The choice of a body's reference frame: mean axes against a frame that is fixed to a joint.
namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

superelement::Superelement limb(double EI) {
  beams::StraightBeam b;  // L = m = 1
  b.EA = 100.0 * EI;
  b.GI_t = b.EI_y = b.EI_z = EI;
  b.rho_I_y = b.rho_I_z = 1e-3;
  b.elements = 4;
  return beams::beam_superelement(b);
}

BasisOptions basis(bool mean_axes) {
  BasisOptions options;
  options.fixed_interface = mean_axes ? -1 : 0;
  options.damping_law.rayleigh = Eigen::Vector2d(0.0, 2e-3);  // of the deformation, whatever the frame
  return options;
}

/// The free limb's mass matrix, of its frame's six motions and all deformations, undeformed.
MatrixXd mass_matrix(const ModalData& data) {
  MechanismDescription d;
  d.add_body({.name = "limb", .flexible = std::make_shared<ModalBody>(data)});
  const Mechanism m(d);
  MatrixXd M = MatrixXd::Zero(m.sizes().n_v, m.sizes().n_v);
  m.mass_matrix(m.initial_state().p, *m.make_scratch(), M);
  return M;
}

/// The tip's motion under harmonic unit loads there, (K - W^2 M)^-1 seen from the tip.
MatrixXd tip_compliance(const ModalData& data, double W) {
  const MatrixXd M = mass_matrix(data);
  const Eigen::Index n = data.stiffness.size();
  MatrixXd A = -W * W * M;
  A.diagonal().tail(n) += data.stiffness;
  // Rotations come first, the frame's origin lies 1 m from the tip.
  EXPECT_NEAR(M(3, 3), 1.0, 1e-12);
  MatrixXd L = MatrixXd::Zero(6, 6 + n);
  L.topLeftCorner<6, 6>().setIdentity();
  L.block<3, 1>(3, 1) = Vector3d::UnitY().cross(Vector3d::UnitX());
  L.block<3, 1>(3, 2) = Vector3d::UnitZ().cross(Vector3d::UnitX());
  L.topRightCorner(3, n) = data.nodes[1].Phi_r;
  L.bottomRightCorner(3, n) = data.nodes[1].Phi_t;
  return L * A.fullPivLu().solve(L.transpose());
}

TEST(ReferenceFrame, DoesNotMatterToLinearResults) {
  const superelement::Superelement se = limb(1.0);
  const ModalData mean = modal_data(se, basis(true)), fixed = modal_data(se, basis(false));
  for (const double W : {0.3, 3.0, 30.0}) {  // below, between and above the lowest frequencies
    SCOPED_TRACE(W);
    const MatrixXd a = tip_compliance(mean, W), b = tip_compliance(fixed, W);
    // Round-off of the solve with stiffnesses up to 1e6 of W^2.
    EXPECT_LT((a - b).norm(), 1e-9 * a.norm());
  }
}

/// The tip of a limb with a weight there, its hub turned by 1.5 rad within a second, at some times.
std::vector<Vector3d> swing(const superelement::Superelement& se, const BasisOptions& options) {
  MechanismDescription d;
  const int beam =
      d.add_body({.name = "limb", .flexible = std::make_shared<ModalBody>(modal_data(se, options))});
  const int hub = d.add_joint("hub", "revolute", d.add_marker(0, "shaft"), d.add_marker(beam, "root", {}, 0));
  d.joints[hub].drives[0] = std::make_shared<Expression>("hub", "1.5 * t^3 * (10 - 15*t + 6*t^2)",
                                                         SignalNames(), std::map<std::string, double>{});
  const int weight = d.add_body(
      {.name = "weight", .inertia = RigidInertia::from_center(0.5, {0, 0, 0}, 1e-3 * Matrix3d::Identity())});
  d.add_joint("hand", "fixed", d.add_marker(beam, "tip", {}, 1), d.add_marker(weight, "in"));
  const Mechanism m(d);
  State s = m.initial_state();
  VectorXd v_dot;
  assemble(m, s, v_dot);
  SolverOptions solver;
  solver.method = "radau";
  solver.end_time = 0.8;
  solver.output_step = 0.2;
  solver.tolerance = 1e-8;
  solver.absolute_factor = 1e-2;
  std::vector<Vector3d> tip;
  RunCallbacks callbacks;
  callbacks.row = [&](const State& row, const VectorXd&, const EnergyAccount&) {
    std::vector<Pose> poses;
    m.body_poses(row, *m.make_scratch(), poses);
    tip.push_back(poses[weight].p);
  };
  EXPECT_TRUE(run(m, s, v_dot, solver, callbacks).complete);
  return tip;
}

double largest_difference(const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
  return largest;
}

TEST(ReferenceFrame, ChangesMotionsToSecondOrderInTheDeformation) {
  double difference[3], deflection[3];
  for (int k = 0; k < 3; ++k) {
    const double EI = 400.0 * std::pow(4.0, k);
    const superelement::Superelement se = limb(EI);
    const auto mean = swing(se, basis(true)), fixed = swing(se, basis(false)),
               stiff = swing(limb(1e6), basis(false));
    difference[k] = largest_difference(mean, fixed);
    deflection[k] = largest_difference(fixed, stiff);
  }
  for (int k = 0; k < 2; ++k) {
    // A quarter of the deflection makes a sixteenth of the difference.
    EXPECT_NEAR(deflection[k] / deflection[k + 1], 4.0, 0.4);
    EXPECT_NEAR(difference[k] / difference[k + 1], 16.0, 3.0);
  }
  EXPECT_LT(difference[0], 2.0 * deflection[0] * deflection[0]);
}

TEST(ReferenceFrame, TruncatedModesOfBothConverge) {
  const superelement::Superelement se = limb(400.0);
  for (const bool mean_axes : {true, false}) {
    SCOPED_TRACE(mean_axes);
    BasisOptions options = basis(mean_axes);
    const auto all = swing(se, options);
    if (!mean_axes) options.held = interface_loads(se, 0);  // its modes are those of the clamped limb
    double error[3];
    const int modes[3] = {2, 8, 20};
    for (int k = 0; k < 3; ++k) {
      options.modes = modes[k];
      error[k] = largest_difference(swing(se, options), all);
    }
    // Free modes carry no moment at the hub and converge slowly only; those of the clamped limb are its own.
    EXPECT_LT(error[1], 0.7 * error[0]);
    EXPECT_LT(error[2], 0.5 * error[1]);
    // The same with response modes for both ends beside the first two.
    options.modes = 2;
    options.loads = interface_loads(se, {0, 1});
    EXPECT_LT(largest_difference(swing(se, options), all), 1e-3 * error[0]);
  }
}

}  // namespace
}  // namespace flexura::mbs
