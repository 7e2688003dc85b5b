// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <numbers>
#include <numeric>

#include "mbs/bodies/modal_basis.hpp"
#include "tests/mbs/flexible/beam_superelement.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;
using testing::HasSubstr;

/// Static deformation of the free superelement under self-equilibrated loads p, as the strain energy's
/// p^T K^+ p: the same in every frame.
double compliance(const superelement::Superelement& se, const VectorXd& p) {
  // K + M R R^T M has the rigid motions' stiffness added and solves K u = p with R^T M u = 0.
  const MatrixXd MR = se.M_se * superelement::rigid_motions(se);
  const double scale = se.K_se.norm() / (MR * MR.transpose()).norm();
  return p.dot((se.K_se + scale * MR * MR.transpose()).ldlt().solve(p));
}

TEST(ResponseModes, GiveWayUnderInterfaceLoadsAsTheSuperelementDoes) {
  const auto l = lattice::make_lattice(6);
  BasisOptions truncated;
  truncated.modes = 3;
  BasisOptions attached = truncated;
  attached.loads.resize(l.se.n(), 12);
  attached.loads << interface_loads(l.se, 0), interface_loads(l.se, 1);
  BasisReport report;
  const ModalData without = modal_data(l.se, truncated), with = modal_data(l.se, attached, &report);
  EXPECT_EQ(report.kept, 3);
  EXPECT_EQ(report.responses, static_cast<int>(with.stiffness.size()) - 3);
  // A pull and a twist between the two interfaces, each in equilibrium.
  const Vector3d r = l.se.interfaces[1].p_BoN_B - l.se.interfaces[0].p_BoN_B;
  const MatrixXd left = interface_loads(l.se, 0), right = interface_loads(l.se, 1),
                 left_seen_from_right = interface_loads(l.se, 0, r);
  for (int k = 0; k < 6; ++k) {
    const VectorXd p = right.col(k) - left_seen_from_right.col(k);
    const double exact = compliance(l.se, p);
    const auto of = [&](const ModalData& data) {
      const VectorXd f = data.Y.transpose() * p;
      return f.dot(f.cwiseQuotient(data.stiffness));
    };
    EXPECT_NEAR(of(with), exact, 1e-9 * exact) << k;  // condition of K, some 1e5, times round-off
    EXPECT_LT(of(without), 0.999 * exact) << k;
  }
}

TEST(ResponseModes, AtAFrequencyAreTheForcedVibrationThere) {
  const auto l = lattice::make_lattice(6);
  BasisOptions options;
  options.modes = 1;
  options.loads = interface_loads(l.se, 1).col(4);
  const ModalData all = modal_data(l.se);
  const double Omega = 0.5 * (std::sqrt(all.stiffness(1)) + std::sqrt(all.stiffness(2)));
  options.response_frequency = Omega / (2 * pi);
  const ModalData data = modal_data(l.se, options);
  ASSERT_EQ(data.stiffness.size(), 2);
  const auto amplitude = [&](const ModalData& d) {  // of the loaded dof under the unit load at Omega
    const VectorXd f = d.Y.transpose() * options.loads;
    return f.dot(f.cwiseQuotient(VectorXd(d.stiffness.array() - Omega * Omega)));
  };
  EXPECT_NEAR(amplitude(data), amplitude(all), 1e-9 * std::abs(amplitude(all)));
  // At a natural frequency there is none.
  options.response_frequency = std::sqrt(all.stiffness(2)) / (2 * pi);
  EXPECT_THROW(modal_data(l.se, options), std::invalid_argument);
}

TEST(BoundaryCondition, GivesTheFrequenciesOfTheHeldBeam) {
  // Clamped and pinned at the root: beta L of cos cosh = -1 and tan = tanh (Euler-Bernoulli; the finite
  // elements' error of mode k is (beta L / n)^4 / 720, n = 16 elements: 3e-6 of the square for beta L = 4.7).
  beams::StraightBeam b;
  b.EA = 1e6;
  b.GI_t = 1e4;
  b.EI_y = 400.0;
  b.elements = 16;
  const superelement::Superelement se = beams::beam_superelement(b);
  const MatrixXd root = interface_loads(se, 0);
  BasisOptions clamped, pinned;
  clamped.modes = pinned.modes = 2;
  clamped.fixed_interface = 0;
  clamped.held = root;
  const ModalData held = modal_data(se, clamped);  // the frame fixed there: the shapes' own frequencies
  EXPECT_NEAR(std::pow(held.stiffness(0), 0.25), 1.87510407, 1e-5);
  EXPECT_NEAR(std::pow(held.stiffness(1), 0.25), 4.69409113, 2e-5);
  // Nothing moves at the fixed interface.
  EXPECT_TRUE(held.nodes[0].Phi_t.isZero(0.0));
  EXPECT_TRUE(held.nodes[0].Phi_r.isZero(0.0));

  pinned.held.resize(se.n(), 5);
  pinned.held << root.leftCols(2), root.rightCols(3);  // free about z
  BasisReport report;
  modal_data(se, pinned, &report);
  EXPECT_NEAR(std::sqrt(2 * pi * report.eigen_hz[0]), 3.92660231, 2e-5);
  EXPECT_NEAR(std::sqrt(2 * pi * report.eigen_hz[1]), 7.06858275,
              2e-4);  // error (7.07/16)^4/1440 = 3e-5 of it
}

TEST(ChosenModes, AreThoseOfTheirNumbers) {
  const auto l = lattice::make_lattice(6);
  const ModalData all = modal_data(l.se);
  BasisOptions options;
  options.numbers = {1, 3, 7};
  BasisReport report;
  const ModalData chosen = modal_data(l.se, options, &report);
  ASSERT_EQ(chosen.stiffness.size(), 3);
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(chosen.stiffness(k), all.stiffness(options.numbers[static_cast<std::size_t>(k)] - 1));
  EXPECT_EQ(report.first_dropped_hz, std::sqrt(all.stiffness(1)) / (2 * pi));
  // As many as the last one alone leave nothing out.
  options.numbers.assign(static_cast<std::size_t>(all.stiffness.size()), 0);
  std::iota(options.numbers.begin(), options.numbers.end(), 1);
  EXPECT_EQ(modal_data(l.se, options).stiffness, all.stiffness);
  options.numbers = {7, 1, 3};  // in any order
  EXPECT_EQ(modal_data(l.se, options).stiffness, chosen.stiffness);
  for (const int none : {0, -1, static_cast<int>(all.stiffness.size()) + 1}) {
    options.numbers = {none};
    EXPECT_THROW(modal_data(l.se, options), std::invalid_argument) << none;
  }
}

TEST(ChosenModes, HoldTheShareOfEffectiveMass) {
  const auto l = lattice::make_lattice(8);
  BasisOptions options;
  options.held = interface_loads(l.se, 0);
  // The clamped interface's dofs struck: K phi = omega^2 M phi and the participation of each rigid motion of the support.
  const Eigen::Index n = l.se.n() - 6;
  ASSERT_EQ(l.se.interfaces[0].first_dof, 0);
  const MatrixXd R = superelement::rigid_motions(l.se), M = l.se.M_se;
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(l.se.K_se.bottomRightCorner(n, n),
                                                                 M.bottomRightCorner(n, n));
  const MatrixXd support = R.topRows(6).inverse();  // rigid motions of unit displacements of the interface
  const MatrixXd shares = (modes.eigenvectors().transpose() * M.bottomRows(n) * R * support).cwiseAbs2();
  const VectorXd whole = shares.colwise().sum();
  for (const double share : {0.3, 0.8, 0.95, 0.999}) {
    options.effective_mass = share;
    const auto kept = modal_data(l.se, options).stiffness.size();
    const auto least = [&](Eigen::Index count) {
      return (shares.topRows(count).colwise().sum().transpose().array() / whole.array()).minCoeff();
    };
    EXPECT_GE(least(kept), share - 1e-9);
    EXPECT_LT(least(kept - 1), share);
  }
  options.held.resize(l.se.n(), 0);
  EXPECT_THROW(modal_data(l.se, options), std::invalid_argument);
}

TEST(ReferenceFrame, SpansTheSameDeformations) {
  const auto l = lattice::make_lattice(6);
  BasisOptions options;
  options.modes = 5;
  options.loads = interface_loads(l.se, 1);
  const ModalData mean = modal_data(l.se, options);
  options.fixed_interface = 0;
  const ModalData fixed = modal_data(l.se, options);
  ASSERT_EQ(mean.stiffness.size(), fixed.stiffness.size());
  // The joint-fixed shapes less their rigid part are combinations of the mean-axis ones.
  const MatrixXd R = superelement::rigid_motions(l.se);
  MatrixXd all(l.se.n(), 6 + mean.Y.cols());
  all << R, mean.Y;
  const MatrixXd rest =
      fixed.Y - all * (all.transpose() * l.se.M_se * all).ldlt().solve(all.transpose() * l.se.M_se * fixed.Y);
  EXPECT_LE(rest.cwiseAbs().maxCoeff(), 1e-9 * fixed.Y.cwiseAbs().maxCoeff());
  EXPECT_TRUE(fixed.nodes[0].Phi_t.isZero(0.0));
  EXPECT_LE(mean.inertia.S_phi.cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_GT(fixed.inertia.S_phi.cwiseAbs().maxCoeff(), 1e-2);
}

TEST(ModalDamping, FollowsTheLaw) {
  const VectorXd omega2 = (VectorXd(4) << 100.0, 400.0, 1e4, 4e6).finished(),  // 1.59, 3.18, 15.9, 318 Hz
      plain = VectorXd::Constant(4, 0.5);
  DampingLaw law;
  EXPECT_EQ(modal_damping(law, omega2, plain), plain);
  law.ratio = 0.02;
  EXPECT_DOUBLE_EQ(modal_damping(law, omega2, plain)(1), 2 * 0.02 * 20);
  law.critical_above = 100.0;
  EXPECT_DOUBLE_EQ(modal_damping(law, omega2, plain)(3), 2 * 2000);
  EXPECT_DOUBLE_EQ(modal_damping(law, omega2, plain)(2), 2 * 0.02 * 100);
  DampingLaw by_mode;
  by_mode.by_mode = {0.01, 0.03};
  EXPECT_DOUBLE_EQ(modal_damping(by_mode, omega2, plain)(0), 2 * 0.01 * 10);
  EXPECT_DOUBLE_EQ(modal_damping(by_mode, omega2, plain)(3), 2 * 0.03 * 2000);
  DampingLaw table;
  table.table_hz = {2.0, 10.0};
  table.table = {0.01, 0.05};
  EXPECT_DOUBLE_EQ(modal_damping(table, omega2, plain)(0), 2 * 0.01 * 10);
  EXPECT_NEAR(modal_damping(table, omega2, plain)(1), 2 * 20 * (0.01 + 0.04 * (20 / (2 * pi) - 2) / 8),
              1e-15);
  EXPECT_DOUBLE_EQ(modal_damping(table, omega2, plain)(2), 2 * 0.05 * 100);
  DampingLaw rayleigh;
  rayleigh.rayleigh = Eigen::Vector2d(0.3, 1e-4);
  EXPECT_DOUBLE_EQ(modal_damping(rayleigh, omega2, plain)(2), 0.3 + 1e-4 * 1e4);
  table.table_hz = {10.0, 2.0};
  EXPECT_THROW(modal_damping(table, omega2, plain), std::invalid_argument);
}

TEST(Refusals, NameSuperelementRuleAndRemedy) {
  const auto l = lattice::make_lattice(5);
  BasisOptions options;
  options.stiffening = true;
  try {
    modal_data(l.se, options);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(),
                HasSubstr("superelement \"lattice\" has no geometric stiffening terms; reduce"));
  }
}

}  // namespace
}  // namespace flexura::mbs
