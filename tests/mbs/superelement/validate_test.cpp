// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "mbs/superelement/known_errors.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::superelement {
namespace {

using testing::BoxBeam;
using ::testing::HasSubstr;
using testing::make_box_beam;

template <typename Spoil>
std::string refusal(Spoil&& spoil) {
  Superelement se = make_box_beam();
  spoil(se);
  try {
    validate(se);
  } catch (const std::invalid_argument& failure) {
    return failure.what();
  }
  return "accepted";
}

TEST(Validate, AnExactSuperelementPasses) {
  EXPECT_NO_THROW(validate(make_box_beam()));
  EXPECT_NO_THROW(validate(make_box_beam({.L = 1e-4, .b = 1e-6, .h = 2e-6, .p_BoA_B = {1e-3, 0, 0}})));
  EXPECT_NO_THROW(validate(make_box_beam({.L = 500, .b = 1, .h = 2, .p_BoA_B = {100, 200, -300}})));
}

TEST(Validate, RigidMotionsMoveTheInterfacesAsOneBody) {
  const Superelement se = make_box_beam();
  const Eigen::MatrixXd R = rigid_motions(se);
  const Eigen::Vector3d w(0.1, -0.4, 0.7), x = se.interfaces[1].p_BoN_B;
  Eigen::Matrix<double, 6, 1> z;
  z << 1, 2, 3, w;
  const Eigen::VectorXd u = R * z;
  // Three products and sums of numbers around 1.
  EXPECT_LT((u.segment<3>(6) - (Eigen::Vector3d(1, 2, 3) + w.cross(x))).norm(), 1e-15);
  EXPECT_LT((u.segment<3>(9) - w).norm(), 1e-15);
  EXPECT_EQ(u.tail(3).norm(), 0.0);
}

TEST(Validate, EachBrokenRelationIsNamedWithItsFigures) {
  EXPECT_THAT(refusal([](auto& se) { se.M_se(2, 3) = std::nan(""); }),
              HasSubstr("M_se(2, 3) is nan, not a finite number"));
  EXPECT_THAT(refusal([](auto& se) { se.omega2[1] = INFINITY; }), HasSubstr("omega2(1, 0) is inf"));
  EXPECT_THAT(refusal([](auto& se) { se.K_se(1, 5) *= 1.001; }),
              HasSubstr("K_se is not symmetric: (5, 1) is "));
  EXPECT_THAT(refusal([](auto& se) { se.K_se(7, 7) *= 1.001; }),
              HasSubstr("rigid translation along y strains the body"));
  EXPECT_THAT(refusal([](auto& se) { se.K_se(4, 4) *= 1.001; }),
              HasSubstr("rigid rotation about y strains the body"));
  EXPECT_THAT(refusal([](auto& se) { se.K_se.resize(3, 3); }), HasSubstr("K_se is 3 x 3, 15 x 15 is wanted"));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.mass *= 1.00001; }),
              HasSubstr("mass along x is 9.42 by M_se but 9.4200942 by"));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.S_xx *= 1.001; }), HasSubstr("inertia about x is "));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.S_x *= 1.001; }), HasSubstr("disagree on the coupling of "));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.S_phi(1, 12) *= 1.001; }),
              HasSubstr("the integral S_phi of shape 12"));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.S_xphi(1, 5) *= 1.001; }),
              HasSubstr("the integral S_xphi of shape 5"));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.S_phiphi[1](12, 12) *= 1.001; }),
              HasSubstr("S_phiphi sums to 1.0009986 at (12, 12)"));
  EXPECT_THAT(refusal([](auto& se) { se.inertia.mass = -1; }),
              HasSubstr("its mass is -1 kg, it must be above 0"));
  EXPECT_THAT(refusal([](auto& se) { se.interfaces[1].name = "left"; }),
              HasSubstr("two interfaces are called \"left\""));
  EXPECT_THAT(refusal([](auto& se) { se.interfaces.clear(); }), HasSubstr("it has no interface"));
  EXPECT_THAT(refusal([](auto& se) { se.interfaces[1].first_dof = 7; }),
              HasSubstr("starts at column 7, 6 is wanted"));
  EXPECT_THAT(refusal([](auto& se) { se.interfaces[1].directions.pop_back(); }),
              HasSubstr("11 directions together, but n_b is 12"));
  EXPECT_THAT(refusal([](auto& se) { se.surface.triangles(0, 0) = 8; }),
              HasSubstr("a vertex beyond the 8 there are"));
  EXPECT_THAT(refusal([](auto& se) { se.shapes.resize(3, 15); }),
              HasSubstr("shapes is 3 x 15, 24 x 15 is wanted"));
  EXPECT_THAT(refusal([](auto& se) { se.stiffening.emplace(); }), HasSubstr("K0t is 0 x 0"));
  EXPECT_THAT(refusal([](auto& se) { se.modal_damping = -0.1; }), HasSubstr("its modal damping is -0.1"));
}

// Where response shapes hold all that the interfaces ask for, what is left out is round-off of either sign.
TEST(KnownErrors, RoundOffBelowZeroIsNothingLeftOutAndNotUnknown) {
  Superelement se;
  se.report_json = R"({"estimate": [{"frequency_hz": 10195.4, "frequency_error": -1.2e-15}]})";
  EXPECT_EQ(first_frequency_error(se).left_out, 0.0);
  EXPECT_EQ(frequency_error(se, 10195.4).left_out, 0.0);
  EXPECT_LT(frequency_error(se, 15105.8).left_out, 0.0);
  EXPECT_EQ(percent_words(0.0), "0");
  EXPECT_EQ(percent_words(2.2e-15), "0");
  EXPECT_EQ(percent_words(0.0031), "0.31");
  EXPECT_EQ(percent_words(-1.0), "unknown");
}

}  // namespace
}  // namespace flexura::superelement
