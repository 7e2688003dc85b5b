// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/modes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::superelement {
namespace {

using testing::BoxBeam;
using ::testing::HasSubstr;
using testing::make_box_beam;

// The eigenvalues are backward stable relative to the largest 1/omega^2: the relative error of omega^2 is the
// machine epsilon times omega^2 over the lowest omega^2, here below 1e5, times the 15 dofs and the condition
// of the scaled stiffness, about 1e3.
constexpr double tolerance = 1e-7;

// The mode that stretches (or twists) only: its u_se has all its energy in that pair of dofs.
double omega2_of_pair(const ModeAnalysis& analysis, const Superelement& se, int dof, int internal) {
  for (const Mode& mode : analysis.modes) {
    if (mode.rigid) continue;
    double own = 0.0;
    for (const int i : {dof, 6 + dof, internal}) own += mode.u_se[i] * mode.u_se[i] * se.K_se(i, i);
    double all = (mode.u_se.array().square() * se.K_se.diagonal().array()).sum();
    if (own > 0.999 * all) return mode.omega2;
  }
  return 0.0;
}

TEST(NaturalModes, AFreeBodyHasSixRigidModesAndTheRodsFrequencies) {
  for (const double size : {1e-4, 1.0, 1e4}) {
    const BoxBeam beam{
        .L = 0.8 * size, .b = 0.03 * size, .h = 0.05 * size, .p_BoA_B = {0.3 * size, -size, 5 * size}};
    const Superelement se = make_box_beam(beam);
    const ModeAnalysis analysis = natural_modes(se, {});
    EXPECT_EQ(analysis.n_rigid, 6);
    ASSERT_EQ(analysis.modes.size(), 15u);
    const double L2 = beam.L * beam.L, c2 = beam.E / beam.rho, G = beam.E / (2 * (1 + beam.nu));
    // Free rod, Ritz with Legendre polynomials: P1 gives 12 c^2/L^2, P2 gives 60 c^2/L^2; P1 is the lower and
    // the first of the stretching modes. Torsion has P1 alone.
    EXPECT_NEAR(omega2_of_pair(analysis, se, 0, 14) / (12 * c2 / L2), 1.0, tolerance);
    EXPECT_NEAR(omega2_of_pair(analysis, se, 3, 3) / (12 * G / beam.rho / L2), 1.0, tolerance);
    EXPECT_NEAR(analysis.modes.back().omega2 / (60 * c2 / L2), 1.0, 0.5);  // among the highest
    for (const Mode& mode : analysis.modes) {
      EXPECT_NEAR(mode.u_se.dot(se.M_se * mode.u_se), 1.0, 1e-10);
      if (mode.rigid) continue;
      // Elastic modes of a free body carry no momentum.
      EXPECT_LT(mode.effective_mass.head<3>().maxCoeff(), 1e-12 * analysis.mass);
    }
    EXPECT_NEAR(analysis.mass, beam.rho * beam.b * beam.h * beam.L, 1e-12 * analysis.mass);
    EXPECT_LT((analysis.mass_centre - beam.p_BoA_B - Eigen::Vector3d(beam.L / 2, 0, 0)).norm(), 1e-12 * size);
  }
}

// Effective mass of the bubble x (L - x): (L^3/6)^2 / (L^5/30) / L = 5/6 of the mass; of x^2 (L - x)^2 with
// the rotary inertia of the section: (1/30)^2 / (1/630 + 2/105 I / (A L^2)).
TEST(NaturalModes, FixedInterfaceModesHaveTheirEffectiveMass) {
  const BoxBeam beam;
  const Superelement se = make_box_beam(beam);
  const ModeAnalysis analysis = natural_modes(se, interface_names(se));
  EXPECT_EQ(analysis.n_rigid, 0);
  ASSERT_EQ(analysis.modes.size(), 3u);
  Eigen::VectorXd omega2 = se.omega2;
  std::sort(omega2.begin(), omega2.end());
  const auto bend = [&](double width) {
    return 1.0 / 900 / (1.0 / 630 + 2.0 / 105 * width * width / 12 / (beam.L * beam.L));
  };
  const Eigen::Vector3d expected(5.0 / 6, bend(beam.b), bend(beam.h));
  for (int j = 0; j < 3; ++j) {
    const Mode& mode = analysis.modes[static_cast<std::size_t>(j)];
    EXPECT_NEAR(mode.omega2 / omega2[j], 1.0, 1e-12);
    // The thin direction (y, b < h) bends first; each mode moves along its own axis only. Quadrature to
    // round-off.
    const int axis = j == 0 ? 1 : j == 1 ? 2 : 0;
    EXPECT_NEAR(mode.effective_mass[axis] / analysis.mass, expected[axis], 1e-12);
    EXPECT_NEAR(mode.effective_mass.head<3>().sum() / analysis.mass, expected[axis], 1e-12);
  }
}

// A rod clamped at one end, Ritz with u = x and x (1 - x) in units of L and c: K = [1 0; 0 1/3],
// M = [1/3 1/12; 1/12 1/30], so w = omega^2 L^2/c^2 is the smaller root of (1 - w/3)(1/3 - w/30) - w^2/144 =
// 0.
TEST(NaturalModes, AClampedRodHasTheRitzFrequency) {
  const BoxBeam beam;
  const Superelement se = make_box_beam(beam);
  const ModeAnalysis analysis = natural_modes(se, {"left"});
  EXPECT_EQ(analysis.n_rigid, 0);
  const double a = 1.0 / 90 - 1.0 / 144, b = -(1.0 / 30 + 1.0 / 9), c = 1.0 / 3;
  const double w = (-b - std::sqrt(b * b - 4 * a * c)) / (2 * a);
  EXPECT_NEAR(omega2_of_pair(analysis, se, 0, 14) / (w * beam.E / beam.rho / (beam.L * beam.L)), 1.0,
              tolerance);
  EXPECT_NEAR(w, 2.4674, 0.03);  // the exact rod has (pi/2)^2
}

// An interface that keeps its three displacements only holds no rotation about its point: three rigid modes
// remain.
TEST(NaturalModes, RigidModesAreCountedByRank) {
  Superelement se = make_box_beam();
  se.interfaces.push_back(se.interfaces[0]);
  se.interfaces.back().name = "left_rotations";
  se.interfaces[0].directions.resize(3);
  se.interfaces[2].directions.erase(se.interfaces[2].directions.begin(),
                                    se.interfaces[2].directions.begin() + 3);
  std::swap(se.interfaces[1], se.interfaces[2]);
  se.interfaces[1].first_dof = 3;
  EXPECT_EQ(natural_modes(se, {"left"}).n_rigid, 3);
  EXPECT_EQ(natural_modes(se, {"left", "left_rotations"}).n_rigid, 0);
  EXPECT_EQ(natural_modes(se, {"left", "left_rotations"}).modes.size(), 9u);
  EXPECT_EQ(natural_modes(se, {"left"}, 4).modes.size(), 7u);
}

TEST(NaturalModes, DampingComesFromTheMatrixAndElseFromTheRatio) {
  Superelement se = make_box_beam();
  se.modal_damping = 0.01;
  for (const Mode& mode : natural_modes(se, {"left"}).modes) EXPECT_EQ(mode.damping, 0.01);
  se.D_se = 2e-6 * se.K_se;  // stiffness-proportional: ratio beta omega / 2
  for (const Mode& mode : natural_modes(se, {"left"}).modes)
    EXPECT_NEAR(mode.damping, 1e-6 * std::sqrt(mode.omega2), tolerance * (1 + mode.damping));
}

TEST(NaturalModes, RefusalsNameWhatThereIs) {
  const Superelement se = make_box_beam();
  try {
    natural_modes(se, {"middle"});
    FAIL();
  } catch (const std::invalid_argument& failure) {
    EXPECT_STREQ(failure.what(),
                 "there is no interface \"middle\" in superelement \"box beam\"; it has left, right");
  }
  Superelement loose = se;
  loose.K_se.row(14).setZero();
  loose.K_se.col(14).setZero();
  // Shape 14 moves without strain: a mechanism, not a fault.  With less than no stiffness there is no body.
  const ModeAnalysis analysis = natural_modes(loose, {});
  EXPECT_EQ(analysis.n_mechanisms, 1);
  EXPECT_EQ(analysis.modes.at(static_cast<std::size_t>(analysis.n_rigid)).frequency_hz, 0.0);
  loose.K_se(14, 14) = -se.K_se(14, 14);
  EXPECT_THROW(natural_modes(loose, {}), std::invalid_argument);
}

// The 4 x 1 x 1 m block of Abaqus, tet10, reduced statically to its two end faces: the boundary matrices and
// the free frequencies (Guyan_freefree_Hz) were computed independently, see data/README.md. Agreement to the
// 1e-6 of the judge.
TEST(NaturalModes, TheAbaqusBlockHasItsStaticallyReducedFrequencies) {
  std::ifstream in(std::string(FLEXURA_SOURCE_DIR) + "/tests/mbs/superelement/data/craig_bampton_C3D10.json");
  const nlohmann::json data = nlohmann::json::parse(in).at("C3D10");
  Superelement se;
  se.name = "block";
  se.n_b = 12;
  se.K_se.resize(12, 12);
  se.M_se.resize(12, 12);
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < 12; ++j) {
      se.K_se(static_cast<int>(i), static_cast<int>(j)) = data.at("Kbb_12x12")[i][j];
      se.M_se(static_cast<int>(i), static_cast<int>(j)) = data.at("Mbb_12x12")[i][j];
    }
  }
  for (std::size_t k = 0; k < 2; ++k) {
    Interface interface;
    interface.name = k == 0 ? "left" : "right";
    for (int a = 0; a < 3; ++a)
      interface.p_BoN_B[a] = data.at("interface_masters")[k][static_cast<std::size_t>(a)];
    for (int d = 0; d < 6; ++d) interface.directions.push_back(static_cast<Direction>(d));
    interface.first_dof = 6 * static_cast<int>(k);
    se.interfaces.push_back(interface);
  }
  // Mass, centre and inertia of the homogeneous block (rho = 2900).
  se.inertia.mass = 11600;
  se.inertia.S_x = 11600 * Eigen::Vector3d(2, 0.5, 0.5);
  se.inertia.S_xx = 11600 * (Eigen::Vector3d(2, 0.5, 0.5) * Eigen::RowVector3d(2, 0.5, 0.5));
  se.inertia.S_xx.diagonal() += 11600 * Eigen::Vector3d(16, 1, 1) / 12;
  const ModeAnalysis analysis = natural_modes(se, {});
  EXPECT_EQ(analysis.n_rigid, 6);
  const auto& expected = data.at("Guyan_freefree_Hz");
  ASSERT_EQ(analysis.modes.size(), 6 + expected.size());
  for (std::size_t j = 0; j < expected.size(); ++j) {
    EXPECT_NEAR(analysis.modes[6 + j].frequency_hz / expected[j].get<double>(), 1.0, 1e-6);
  }
}

}  // namespace
}  // namespace flexura::superelement
