// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Geometric stiffening of beam parts: columns that buckle, strings and blades that stiffen.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reduce/beams/beam_reduction.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "tests/beam/common.hpp"
#include "tests/beam/models.hpp"
#include "tests/beam/reduction_session.hpp"

namespace flexura::beam {
namespace {

using Eigen::MatrixXd;
using std::numbers::pi;
using testing::divided;
using testing::entry;
using testing::kSteel;
using testing::straight;

class BeamStiffening : public testing::WithSession {};

constexpr double kLong = 2.0, kAcross = 0.02, kHigh = 0.03;
const double kSection = kAcross * kHigh, kEI_y = 2.1e11 * kAcross * std::pow(kHigh, 3) / 12.0,
             kEI_z = 2.1e11 * kHigh * std::pow(kAcross, 3) / 12.0, kMass = 7850.0 * kSection;

Model bar(Theory theory) {
  return straight(entry("r", Rectangle{kAcross, kHigh}, kSteel, ShearFormula::zero_poisson), kLong, theory);
}

reduce::Reduction reduced(const Model& model, int elements, int n_modes,
                          const std::vector<reduce::BeamInterface>& interfaces = {{"a", 0}, {"b", 1}}) {
  reduce::ReductionOptions options;
  options.n_modes = n_modes;
  options.stiffening = true;
  return reduce::reduce_beams(BeamMesh(model, divided(elements)), interfaces, options).reduction;
}

// Rows and columns of the dofs that are not held.
MatrixXd without(const MatrixXd& A, const std::vector<int>& held) {
  std::vector<int> kept;
  for (int k = 0; k < A.rows(); ++k)
    if (std::find(held.begin(), held.end(), k) == held.end()) kept.push_back(k);
  return A(kept, kept);
}

// Lowest positive factors x of K + x K_0 = 0, ascending.
Eigen::VectorXd buckling_factors(const MatrixXd& K, const MatrixXd& K_0) {
  const Eigen::VectorXd mu = linalg::generalized_eigen(-K_0, K).values;
  return mu.reverse().head(4).cwiseInverse();
}

const std::vector<int> kRoot = {0, 1, 2, 3, 4, 5};

// Euler's column and, with shear deformation under the force along the bent axis, Engesser's
// (S. P. Timoshenko, J. M. Gere, Theory of Elastic Stability, art. 2.17): P = P_E / (1 + P_E / G A_s).
TEST_F(BeamStiffening, CantileverBucklesAtEulersAndEngessersLoad) {
  for (const Theory theory : {Theory::euler_bernoulli, Theory::timoshenko}) {
    const reduce::Reduction r = reduced(bar(theory), 12, 30);
    ASSERT_TRUE(r.stiffening);
    EXPECT_EQ(r.stiffening->held, kRoot);
    const Eigen::VectorXd P = buckling_factors(without(r.K_se, kRoot), without(-r.stiffening->K0F[6], kRoot));
    const double GA_s = 2.1e11 / 2.6 * kSection * 5.0 / 6.0;
    int k = 0;
    for (const double EI : {kEI_z, kEI_y}) {
      const double euler = EI * pi * pi / (4.0 * kLong * kLong);
      const double exact = theory == Theory::timoshenko ? euler / (1.0 + euler / GA_s) : euler;
      // Twelve cubic elements on a quarter of a wave: (pi/24)^4 / 720 = 4e-7; 15 pairs of modes leave less.
      EXPECT_NEAR(P(k), exact, 2e-6 * exact);
      ++k;
    }
  }
}

// A hinge at one end: the slope of the bar there is not the node's.  Beside it an equal bar without a hinge
// takes half the load and holds the node.
TEST_F(BeamStiffening, BarBetweenAClampAndAHingeBuckles) {
  Model model = bar(Theory::euler_bernoulli);
  model.members.push_back(model.members[0]);
  model.members[1].name = "second";
  model.members[0].end[1].released[5] = true;  // about z
  const reduce::Reduction r = reduced(model, 12, 40);
  std::vector<int> held = kRoot;
  for (int k = 7; k < 12; ++k) held.push_back(k);  // B slides along the axis
  const Eigen::VectorXd P = buckling_factors(without(r.K_se, held), without(-r.stiffening->K0F[6], held));
  // tan x = x at x = 4.493409458; twelve elements on 0.7 of a wave: (x/12)^4 / 720 = 3e-5.
  const double exact = 2.0 * kEI_z * std::pow(4.493409458 / kLong, 2);
  EXPECT_NEAR(P(0), exact, 5e-5 * exact);
}

// A pulled bar, its ends held but for rotation: omega_n^2 m = T (n pi / L)^2 + EI (n pi / L)^4.
TEST_F(BeamStiffening, PulledStringSings) {
  Model model = bar(Theory::euler_bernoulli);
  const reduce::Reduction r = reduced(model, 16, 60);
  const double T = 1e3 * kEI_z / (kLong * kLong);  // a hundred times what bending gives to the first mode
  std::vector<int> held;
  for (const int k : {0, 1, 2, 3, 6, 7, 8, 9}) held.push_back(k);
  const Eigen::VectorXd omega2 =
      linalg::generalized_eigen(without(r.K_se + T * r.stiffening->K0F[6], held), without(r.M_se, held))
          .values;
  for (int n = 1; n <= 2; ++n) {
    const double k2 = std::pow(n * pi / kLong, 2);
    const double rotary = 1.0 + kAcross * kAcross / 12.0 * k2;
    const double exact = (T * k2 + kEI_z * k2 * k2) / (kMass * rotary);
    // In the softer plane modes 1, 3, ... of the list; linear waves on cubic elements: (n pi/16)^4 / 720 and
    // the modes left out, below 1e-5.
    EXPECT_NEAR(omega2(2 * (n - 1)), exact, 1e-5 * exact);
  }
}

// A column under its own weight, q L^3 / EI = 7.8373 (Greenhill; Timoshenko, Gere, art. 2.12), and the blade
// of S. M. Hamza-Cherif and M. S. A. Houmat (ICAS 2004) that turns about z: flap 4.1373 at mu = 2.
TEST_F(BeamStiffening, OwnWeightAndRotation) {
  const reduce::Reduction r = reduced(bar(Theory::euler_bernoulli), 16, 60);
  const auto greenhill = buckling_factors(without(r.K_se, kRoot), without(r.stiffening->K0t[0], kRoot));
  const double exact = 7.8373475 * kEI_z / (kMass * std::pow(kLong, 3));
  EXPECT_NEAR(greenhill(0), exact, 1e-5 * exact);

  const double unit2 = kEI_y / (kMass * std::pow(kLong, 4));  // flap is bending about y
  const MatrixXd K = r.K_se + 4.0 * unit2 * r.stiffening->K0omega[2];
  const MatrixXd spin = r.inertia.S_phiphi[0] + r.inertia.S_phiphi[1];  // softens in the plane
  std::vector<int> held = kRoot;
  const Eigen::VectorXd omega2 =
      linalg::generalized_eigen(without(K - 4.0 * unit2 * spin, held), without(r.M_se, held)).values;
  double nearest = 0.0;
  for (const double x : omega2)
    if (std::abs(std::sqrt(x / unit2) - 4.1373) < std::abs(nearest - 4.1373)) nearest = std::sqrt(x / unit2);
  // Printed digits; the blade's slenderness of 231 instead of the paper's 70 changes rotary inertia by 1e-3.
  EXPECT_NEAR(nearest, 4.1373, 2e-3 * 4.1373);
}

// The terms belong to the beam, not to its place in the frame or to the nodes it hangs on by rigid arms.
TEST_F(BeamStiffening, DoesNotDependOnFrameAndArms) {
  Model plain = bar(Theory::timoshenko), turned = plain;
  plain.point_masses.push_back({.node = 1, .mass = 0.3, .p_NC_B = {0.05, 0.0, 0.0}});
  // The bar along z, its ends held by arms along x; its +y stays its width.
  turned.point_masses.push_back({.node = 1, .mass = 0.3, .p_NC_B = {-0.1, 0.0, 0.05}});
  turned.nodes[0].p_BoN_B = {0.1, 0, 0};
  turned.nodes[1].p_BoN_B = {0.1, 0, kLong};
  turned.members[0].end[0].offset_B = turned.members[0].end[1].offset_B = {-0.1, 0, 0};
  plain.members[0].direction_B = turned.members[0].direction_B = Eigen::Vector3d::UnitY();
  const reduce::Reduction a = reduced(plain, 6, 20), b = reduced(turned, 6, 20);
  const MatrixXd K_a = without(a.K_se, kRoot), K_b = without(b.K_se, kRoot);
  const auto compare = [&](const MatrixXd& X_a, const MatrixXd& X_b) {
    const Eigen::VectorXd x = linalg::generalized_eigen(without(X_a, kRoot), K_a).values,
                          y = linalg::generalized_eigen(without(X_b, kRoot), K_b).values;
    EXPECT_LT((x - y).norm(), 1e-8 * x.norm());
  };
  compare(a.stiffening->K0t[0], b.stiffening->K0t[2]);
  compare(a.stiffening->K0omega[2], b.stiffening->K0omega[0]);  // about an axis normal to it: z, x
  compare(a.stiffening->K0F[6], b.stiffening->K0F[8]);
}

TEST_F(BeamStiffening, SaysWhatItNeeds) {
  const std::string text = testing::refusal([] {
    reduced(bar(Theory::timoshenko), 4, 2, {{"a", 0, {0, 1, 2, 3}}, {"b", 1, {0, 1, 2, 4, 5}}});
  });
  EXPECT_THAT(text, ::testing::HasSubstr("needs an interface that keeps all six directions"));
}

}  // namespace
}  // namespace flexura::beam
