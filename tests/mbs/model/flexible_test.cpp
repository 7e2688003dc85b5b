// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "tests/mbs/model/checks.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs {
namespace {

using namespace checks;
using lattice::Lattice;
using lattice::make_lattice;

BasisOptions options(int modes, double max_frequency = std::numeric_limits<double>::infinity()) {
  BasisOptions o;
  o.modes = modes;
  o.max_frequency = max_frequency;
  return o;
}

std::shared_ptr<const FlexibleBody> flexible(const Lattice& l, int modes = 1000) {
  return std::make_shared<ModalBody>(modal_data(l.se, options(modes)));
}

TEST(Lattice, IsAValidSuperelement) {
  EXPECT_NO_THROW(superelement::validate(make_lattice(4).se));
}

TEST(ModalBasis, IsFreeFreeOrthonormalAndWithoutRigidMotion) {
  const Lattice l = make_lattice(5);
  BasisReport report;
  const ModalData data = modal_data(l.se, {}, &report);
  const int m = l.se.n() - 6;
  ASSERT_EQ(data.stiffness.size(), m);
  EXPECT_EQ(report.kept, m);
  // Round-off of products of 17 x 17 matrices with condition some thousands.
  EXPECT_LE((data.Y.transpose() * l.se.M_se * data.Y - MatrixXd::Identity(m, m)).cwiseAbs().maxCoeff(),
            1e-11);
  const MatrixXd K = data.Y.transpose() * l.se.K_se * data.Y;
  EXPECT_LE((K - MatrixXd(data.stiffness.asDiagonal())).cwiseAbs().maxCoeff(), 1e-11 * data.stiffness(m - 1));
  EXPECT_LE(data.inertia.S_phi.cwiseAbs().maxCoeff(), 1e-12);
  for (int c = 0; c < 3; ++c) {
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    EXPECT_LE((data.inertia.S_xphi.row(3 * a + b) - data.inertia.S_xphi.row(3 * b + a)).cwiseAbs().maxCoeff(),
              1e-12);
  }
  // The full free-free problem has the same spectrum behind six zeros.
  const VectorXd all = Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd>(l.se.K_se, l.se.M_se).eigenvalues();
  for (int i = 0; i < m; ++i) EXPECT_NEAR(data.stiffness(i), all(6 + i), 1e-9 * all(6 + i));
}

TEST(ModalBasis, TruncatesByCountAndFrequency) {
  const Lattice l = make_lattice(5);
  BasisReport all, report;
  modal_data(l.se, {}, &all);
  EXPECT_EQ(modal_data(l.se, options(3), &report).stiffness.size(), 3);
  EXPECT_GT(report.first_dropped_hz, report.highest_hz);
  EXPECT_EQ(modal_data(l.se, options(1000, report.highest_hz * (1 + 1e-12))).stiffness.size(), 3);
  BasisOptions damped_by_5_percent;
  damped_by_5_percent.damping = 0.05;
  const ModalData damped = modal_data(l.se, damped_by_5_percent);
  EXPECT_DOUBLE_EQ(damped.damping(2), 2 * 0.05 * std::sqrt(damped.stiffness(2)));
  try {
    modal_data(l.se, options(1000, 0.5 * all.lowest_hz));
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("no mode is left"), std::string::npos);
  }
}

TEST(FlexibleBody, InverseDynamicsIsSumOverPointMasses) {
  const Lattice l = make_lattice(5);
  const ModalBody body(modal_data(l.se));
  const MatrixXd Phi = l.T * body.data().Y;
  Random random(11);
  const int m = body.m();
  for (int trial = 0; trial < 3; ++trial) {
    const VectorXd s = random.vector(m, 0.3), s_dot = random.vector(m), s_ddot = random.vector(m, 5.0);
    const Spatial V{random.vector3(2.0), random.vector3(2.0)}, A{random.vector3(5.0), random.vector3(9.0)};
    const auto scratch = body.make_scratch();
    auto& work = *scratch;
    body.set_position(s.data(), work);
    VectorXd modal(m);
    const Spatial need =
        body.inverse_dynamics(s.data(), s_dot.data(), s_ddot.data(), V, A, work, modal.data());

    Spatial sum;
    VectorXd modal_sum = body.data().stiffness.cwiseProduct(s) + body.data().damping.cwiseProduct(s_dot);
    double T = 0.0;
    const Vector3d &w = V.angular, &alpha = A.angular;
    for (int k = 0; k < l.mass.size(); ++k) {
      const auto phi = Phi.middleRows(3 * k, 3);
      const Vector3d rho = l.x.col(k) + phi * s, u_dot = phi * s_dot, u_ddot = phi * s_ddot;
      const Vector3d f =
          l.mass(k) * (A.linear + alpha.cross(rho) + w.cross(w.cross(rho)) + 2 * w.cross(u_dot) + u_ddot);
      sum += Spatial{rho.cross(f), f};
      modal_sum += phi.transpose() * f;
      T += 0.5 * l.mass(k) * (V.linear + w.cross(rho) + u_dot).squaredNorm();
    }
    // Round-off: sums of 24 points in 17 coordinates with accelerations of some tens.
    EXPECT_LE((need.linear - sum.linear).norm(), 1e-11);
    EXPECT_LE((need.angular - sum.angular).norm(), 1e-11);
    EXPECT_LE((modal - modal_sum).cwiseAbs().maxCoeff(), 1e-11 * (1 + modal.cwiseAbs().maxCoeff()));
    EXPECT_NEAR(body.kinetic_energy(s_dot.data(), V, work), T, 1e-12 * T);
  }
}

/// The chain of two flexible bodies with a rigid one at its end.
MechanismDescription flexible_chain(const std::string& middle_joint) {
  static const Lattice a = make_lattice(2), b = make_lattice(1, 250.0);
  MechanismDescription d = chain_of(flexible(a, 8), flexible(b), middle_joint);
  Random random(6);
  const int last = d.add_body({.name = "last", .inertia = random.inertia()});
  d.add_joint("end", "revolute", d.add_marker(chain_second, "inside", random.pose()),
              d.add_marker(last, "in"));
  return d;
}

TEST(FlexibleTree, SatisfiesLagrangesEquations) {
  MechanismDescription d = flexible_chain("revolute");
  // Damping has no Lagrangian.
  for (BodyDescription& body : d.bodies) {
    if (!body.flexible) continue;
    ModalData data = *body.flexible->modal();
    data.damping.setZero();
    body.flexible = std::make_shared<ModalBody>(std::move(data));
  }
  const Mechanism mechanism(d);
  lagrange_equations_hold(mechanism, random_state(mechanism, 3, 0.3), 4);
}

TEST(FlexibleTree, SatisfiesAllIdentities) {
  for (const char* joint : {"revolute", "spherical", "six_dof", "fixed"}) {
    SCOPED_TRACE(joint);
    all_identities_hold(Mechanism(flexible_chain(joint)), 6);
  }
}

TEST(FlexibleClosure, BetweenDeformingMarkersSatisfiesAllIdentities) {
  for (const JointType& type : joint_types()) {
    SCOPED_TRACE(type.name);
    MechanismDescription d = flexible_chain("spherical");
    Random random(8);
    const int F = d.add_marker(chain_second, "loop", random.pose(0.2), 0),
              M = d.add_marker(chain_first, "loop", random.pose(0.2), 1);
    const int joint = d.add_joint("loop", type.name, F, M);
    d.joints[joint].cut = true;
    all_identities_hold(Mechanism(d), 9);
  }
}

TEST(FlexibleBody, FreeInSpaceNeedsNoForceForRigidMotion) {
  // Undeformed, not turning: every acceleration of Bo and no modal acceleration needs m a through the centre
  // alone.
  const Lattice l = make_lattice(3);
  MechanismDescription d;
  d.gravity = {1.0, 2.0, 3.0};
  d.add_body({.name = "beam", .flexible = flexible(l)});
  const Mechanism mechanism(d);
  const State s = mechanism.initial_state();
  VectorXd v_dot = VectorXd::Zero(mechanism.sizes().n_v);
  v_dot.segment<3>(3) = d.gravity;
  EXPECT_LE(momentum(mechanism, s, v_dot).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_EQ(mechanism.sizes().n_flx, l.se.n() - 6);
  EXPECT_EQ(mechanism.name_of_position(7), "beam.mode_1");
}

TEST(FlexibleLoop, PlanarFourBarWithFlexibleCouplerHasNoRedundancyInItsPlane) {
  // Revolute axes along z of the coupler's ends: what is redundant with rigid bodies is carried by the
  // elastic coupler.
  const Lattice l = make_lattice(6);
  MechanismDescription d;
  const auto inertia = RigidInertia::from_center(1.0, {0.2, 0, 0}, 0.02 * Matrix3d::Identity());
  const int crank = d.add_body({.name = "crank", .inertia = inertia});
  const int coupler = d.add_body({.name = "coupler", .flexible = flexible(l)});
  const int rocker = d.add_body({.name = "rocker", .inertia = inertia});
  const Vector3d span = l.se.interfaces[1].p_BoN_B - l.se.interfaces[0].p_BoN_B;
  const Pose tip{Matrix3d::Identity(), {0.4, 0, 0}};
  // All axes parallel to z of ground and of the coupler; z offsets follow the coupler.
  d.add_joint("A", "revolute", d.add_marker(0, "A"), d.add_marker(crank, "A"));
  d.add_joint("B", "revolute", d.add_marker(crank, "B", tip), d.add_marker(coupler, "B", {}, 0));
  d.add_joint("D", "revolute",
              d.add_marker(0, "D", {Matrix3d::Identity(), {span.x() + 0.1, span.y(), span.z()}}),
              d.add_marker(rocker, "D"));
  const int c =
      d.add_joint("C", "revolute", d.add_marker(coupler, "C", {}, 1), d.add_marker(rocker, "C", tip));
  d.joints[0].initial_coordinates[0] = 1.5;
  d.joints[2].initial_coordinates[0] = 1.5;
  d.joints[c].cut = true;
  d.joints[1].initial_coordinates[0] = -1.5;
  Mechanism mechanism(d);
  State s = mechanism.initial_state();
  assemble(mechanism, s);
  EXPECT_TRUE(mechanism.drop_redundant(0.0, s.p).empty());
  EXPECT_EQ(mechanism.sizes().n_lambda, 5);
}

}  // namespace
}  // namespace flexura::mbs
