// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "beam/ancf/element/ancf_element.hpp"
#include "tests/beam/ancf/samples.hpp"

/// The solid beam against the reference files of Chrono's element 3243 (data/README.md).
///
/// The files hold 15 significant digits (5e-16 relative); our sums of 25 points add some ten round-offs of
/// the largest entry.  2e-14 of the largest entry bounds both.
namespace flexura::beam::ancf {
namespace {

constexpr double kDigits = 2e-14;

Eigen::MatrixXd read_matrix(const std::string& name, int rows, int cols) {
  const std::string path = FLEXURA_SOURCE_DIR "/tests/beam/ancf/data/UT_ANCFBeam_3243_" + name + ".txt";
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(rows, cols);
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < cols; ++j) file >> m(i, j);
  EXPECT_FALSE(file.fail()) << path;
  return m;
}

class ChronoElement3243 : public testing::Test {
 protected:
  Eigen::VectorXd e_0 = beam_coordinates(1.0, 0.0);
  double nu = 0.3, k = 10 * (1 + nu) / (12 + 11 * nu);
  std::unique_ptr<Element> element = make_solid_beam(
      {.E = 210e9, .nu = nu, .rho = 7850, .width = 0.1, .height = 0.1, .k_y = k, .k_z = k}, 1.0, e_0.data());
};

TEST_F(ChronoElement3243, MassMatrix) {
  const Eigen::MatrixXd reference = read_matrix("MassMatrix", 8, 8);
  EXPECT_LT((element->compact_mass() - reference).cwiseAbs().maxCoeff(), kDigits * reference.maxCoeff());
}

TEST_F(ChronoElement3243, GravityVector) {
  const Eigen::VectorXd reference = read_matrix("Grav", 24, 1);
  for (int s = 0; s < 8; ++s) {
    EXPECT_EQ(reference[3 * s], 0.0);
    EXPECT_EQ(reference[3 * s + 1], 0.0);
    EXPECT_NEAR(-9.80665 * element->compact_weight()[s], reference[3 * s + 2], kDigits * 384.9) << s;
  }
}

TEST_F(ChronoElement3243, InternalForceAtSmallDisplacement) {
  const Eigen::VectorXd reference = read_matrix("IntFrcSmallDispNoVel", 24, 1);
  Eigen::VectorXd e = e_0, still = Eigen::VectorXd::Zero(24), f = Eigen::VectorXd::Zero(24);
  e[14] = 0.001;
  element->add_force(e.data(), still.data(), nullptr, f.data(), nullptr, nullptr);
  // Chrono's vector is the force on the nodes.  Strains of order 1e-3 come from coordinates of order 1 and
  // leave round-offs of 2e-16 E A (0.5e-6 N) at each point; the weights sum to 1.
  EXPECT_LT((f + reference).cwiseAbs().maxCoeff(), 4 * 2.2e-16 * 210e9 * 0.01);
}

TEST_F(ChronoElement3243, TangentStiffnessAtRest) {
  const Eigen::MatrixXd reference = read_matrix("JacNoDispNoVelNoDamping", 24, 24);
  Eigen::VectorXd still = Eigen::VectorXd::Zero(24), f = still;
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(24, 24);
  element->add_force(e_0.data(), still.data(), nullptr, f.data(), K.data(), nullptr);
  EXPECT_LT((K - reference).cwiseAbs().maxCoeff(), kDigits * reference.maxCoeff());
}

}  // namespace
}  // namespace flexura::beam::ancf
