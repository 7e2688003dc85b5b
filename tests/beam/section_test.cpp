// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/section.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beam/section/shapes.hpp"
#include "tests/beam/common.hpp"

namespace flexura::beam {
namespace {

using std::numbers::pi;
using ::testing::HasSubstr;
using testing::kSteel;
using testing::refusal;
constexpr double kRoundOff = 1e-14;  // a dozen roundings of 1.1e-16 each

TEST(StandardSection, CircleAndTubeHaveTextbookMoments) {
  const Constants c = constants_of(Circle{0.2}, 0.3);
  EXPECT_NEAR(c.A / (pi * 0.01), 1.0, kRoundOff);
  EXPECT_NEAR(c.I_y / (pi * 1.6e-3 / 64.0), 1.0, kRoundOff);
  EXPECT_NEAR(c.I_t, 2.0 * c.I_y, kRoundOff * c.I_t);
  const Constants t = constants_of(HollowCircle{0.2, 0.1}, 0.3);
  EXPECT_NEAR(t.I_t / (pi * (1.6e-3 - 1e-4) / 32.0), 1.0, kRoundOff);
  EXPECT_NEAR(t.I_z / (pi * (1.6e-3 - 1e-4) / 64.0), 1.0, kRoundOff);
}

TEST(StandardSection, SquareTorsionConstantIsThatOfNafemsFV5) {
  // Timoshenko and Goodier print 0.1406 b^4; FV5's reference gives six digits, 0.140577.
  EXPECT_NEAR(constants_of(Rectangle{2.0, 2.0}, 0.3).I_t / 16.0, 0.140577, 5e-7);
}

TEST(StandardSection, RectangleTorsionConstantMatchesTheTableOfTimoshenkoAndGoodier) {
  // k_1 of the table in art. 109, three digits (half a unit of the last).
  EXPECT_NEAR(constants_of(Rectangle{2.0, 1.0}, 0.3).I_t / 2.0, 0.229, 5e-4);
  EXPECT_NEAR(constants_of(Rectangle{1.0, 10.0}, 0.3).I_t / 10.0, 0.312, 6e-4);
  // The deck of FEDEM's CBAR model carries 4.577562868e-5 for 0.2 x 0.1, single precision.
  EXPECT_NEAR(constants_of(Rectangle{0.2, 0.1}, 0.3).I_t / 4.577562868e-5, 1.0, 1e-3);
}

TEST(StandardSection, EllipseOfEqualAxesIsTheCircle) {
  for (const auto formula : {ShearFormula::cowper, ShearFormula::hutchinson}) {
    const Constants e = constants_of(Ellipse{0.3, 0.3}, 0.3, formula),
                    c = constants_of(Circle{0.3}, 0.3, formula);
    EXPECT_NEAR(e.A_sz, c.A_sz, kRoundOff * c.A_sz);
    EXPECT_NEAR(e.I_t, c.I_t, kRoundOff * c.I_t);
  }
}

TEST(StandardSection, HollowEllipseWithThinWallApproachesBredt) {
  // Similar contours: exact pi a^3 b^3/(a^2+b^2)(1-q^4).  A slightly dissimilar one takes Bredt's branch; for
  // a wall of t/a = 1 % Bredt's relative error is (t/a)^2 ~ 1e-4, and the dissimilarity 1e-6 adds 1e-6/1e-2.
  const Constants exact = constants_of(HollowEllipse{0.2, 0.1, 0.198, 0.099}, 0.3);
  const Constants bredt = constants_of(HollowEllipse{0.2, 0.1, 0.198, 0.099 * (1 + 1e-6)}, 0.3);
  EXPECT_NEAR(bredt.I_t / exact.I_t, 1.0, 4e-4);
}

TEST(StandardSection, ThinBoxTorsionIsBredtsAndOpenPartIsSmall) {
  const Constants c = constants_of(HollowRectangle{0.1, 0.2, 0.001, 0.001}, 0.3);
  const double a = 0.099, b = 0.199;
  const double bredt = 4 * a * a * b * b / (2 * (a + b) / 0.001);
  EXPECT_GT(c.I_t, bredt);
  EXPECT_NEAR(c.I_t / bredt, 1.0, 1e-3);  // open part over Bredt: t^2 p^2 / (12 A_m^2) = 8e-5
}

TEST(ShearFactor, CowperAndHutchinsonPrintedValues) {
  const auto kappa = [](const Shape& shape, double nu, ShearFormula formula) {
    const Constants c = constants_of(shape, nu, formula);
    return c.A_sz / c.A;
  };
  // Cowper (1966): circle 6(1+nu)/(7+6nu) = 0.886364 and rectangle 10(1+nu)/(12+11nu) = 0.849673 at nu = 0.3,
  // thin tube 2(1+nu)/(4+3nu).
  EXPECT_NEAR(kappa(Circle{1.0}, 0.3, ShearFormula::cowper), 0.8863636, 5e-8);
  EXPECT_NEAR(kappa(Rectangle{1.0, 2.0}, 0.3, ShearFormula::cowper), 0.8496732, 5e-8);
  EXPECT_NEAR(kappa(HollowCircle{1.0, 0.9999}, 0.3, ShearFormula::cowper), 2.6 / 4.9, 1e-6);
  // Hutchinson (2001): circle 6(1+nu)^2/(7+12nu+4nu^2) = 0.925 at 0.3; a thin rectangle is plane stress,
  // 5(1+nu)/(6+5nu); a thin tube (1+nu)/(2+nu).
  EXPECT_NEAR(kappa(Circle{1.0}, 0.3, ShearFormula::hutchinson), 6 * 1.69 / 10.96, 1e-12);
  EXPECT_NEAR(kappa(Rectangle{0.001, 1.0}, 0.3, ShearFormula::hutchinson), 6.5 / 7.5, 1e-5);
  EXPECT_NEAR(kappa(HollowCircle{1.0, 0.9999}, 0.3, ShearFormula::hutchinson), 1.3 / 2.3, 1e-6);
  // All formulas meet at nu = 0: 6/7 for the circle, 5/6 for the rectangle.
  EXPECT_NEAR(kappa(Circle{1.0}, 0.0, ShearFormula::cowper), 6.0 / 7.0, 1e-12);
  EXPECT_NEAR(kappa(Rectangle{1.0, 3.0}, 0.0, ShearFormula::hutchinson), 5.0 / 6.0, 1e-12);
  EXPECT_TRUE(std::isinf(kappa(Circle{1.0}, 0.3, ShearFormula::rigid)));
}

TEST(ShearFactor, WithoutPoissonEffect) {
  const auto kappa = [](const Shape& shape) {
    const Constants c = constants_of(shape, 0.3, ShearFormula::zero_poisson);
    return c.A_sz / c.A;
  };
  EXPECT_NEAR(kappa(Rectangle{1.0, 2.0}), 5.0 / 6.0, 1e-12);
  EXPECT_NEAR(kappa(Circle{1.0}), 6.0 / 7.0, 1e-12);
  EXPECT_NEAR(kappa(HollowCircle{1.0, 0.9999}), 0.5, 1e-4);
  // Thin wall between similar ellipses, t ds = constant dphi: kappa = 2 b^2 / (a^2 + 3 b^2), b along the
  // force. Midpoint sums of 360 steps and the wall's 0.1 % of thickness leave 2e-5.
  for (const auto& [width, height] : {std::pair{1.0, 1.0}, std::pair{0.1, 1.0}, std::pair{1.0, 0.1}}) {
    const double a2 = width * width, b2 = height * height;
    EXPECT_NEAR(kappa(HollowEllipse{width, height, 0.999 * width, 0.999 * height}) / (2 * b2 / (a2 + 3 * b2)),
                1.0, 2e-5);
  }
}

TEST(ShearFactor, CowperBoxAgreesWithThinWallEnergyWithoutPoissonEffect) {
  // Cowper at nu = 0 is the energy of thin-wall shear flow, V_z bending the whole box: webs parabolic,
  // flanges linear.
  const double h = 0.2, b = 0.1, web = 0.0002, flange = 0.0003;
  const Constants c = constants_of(HollowRectangle{b + web, h + flange, web, flange}, 0.0);
  const double I = 2 * web * h * h * h / 12 + 2 * b * flange * h * h / 4;
  // Shear flow per unit V/I: flange q(s) = flange h/2 s, s from the mid-line to b/2; web q(z) = flange h b/4
  // + web/2 (h^2/4 - z^2).  int q^2/t ds over four half flanges and two webs.
  double flow = 4 * flange * (h * h / 4) * std::pow(b / 2, 3) / 3;
  const double q_0 = flange * h * b / 4, k = web / 2;
  flow += 2 / web * (q_0 * q_0 * h + 2 * q_0 * k * h * h * h / 6 + k * k * std::pow(h, 5) / 30);
  const double A_s = I * I / flow;
  EXPECT_NEAR(c.A_sz / A_s, 1.0, 5e-3);  // wall thickness over height, 3e-3 in h and A
}

TEST(SectionMatrices, UncoupledStiffnessIsDiagonal) {
  const Section s = make_section("shaft", Rectangle{0.1, 0.2}, kSteel);
  const Constants& c = *s.constants;
  Vector6d expected;
  expected << kSteel.E * c.A, kSteel.G * c.A_sy, kSteel.G * c.A_sz, kSteel.G * c.I_t, kSteel.E * c.I_y,
      kSteel.E * c.I_z;
  const Matrix6d C = s.stiffness();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(C(i, j), i == j ? expected(i) : 0.0, kRoundOff * std::sqrt(expected(i) * expected(j)));
}

TEST(SectionMatrices, ForceAtTheShearCentreDoesNotTwist) {
  Constants c = constants_of(Rectangle{0.1, 0.2}, 0.3);
  c.y_cs = 0.03;
  c.z_cs = -0.05;
  const Section s = make_section("offset", c, kSteel);
  // V_y, V_z at the shear centre: at O they make the torque T = y_cs V_z - z_cs V_y.
  Vector6d load = Vector6d::Zero();
  load(V_y) = 2.0;
  load(V_z) = 3.0;
  load(T) = c.y_cs * load(V_z) - c.z_cs * load(V_y);
  EXPECT_NEAR((s.f * load)(T)*kSteel.G * c.I_t, 0.0, kRoundOff);
}

TEST(SectionMatrices, SectionGivenAboutAnotherPointBendsAboutItsCentroid) {
  // The rectangle described about a point (a, b) off its centroid by Steiner's rule, a pure moment about y at
  // the centroid: same curvature, and no stretch there (eps at O is -z_c kappa_y).
  const double a = -0.07, b = 0.04;
  const Constants own = constants_of(Rectangle{0.1, 0.2}, 0.3);
  Constants c = own;
  c.y_cg = a;
  c.z_cg = b;
  c.S_y = c.A * b;
  c.S_z = c.A * a;
  c.I_y += c.A * b * b;
  c.I_z += c.A * a * a;
  c.I_yz = -c.A * a * b;
  const Section s = make_section("shifted", c, kSteel);
  Vector6d moment = Vector6d::Zero();
  moment(M_y) = 1.0;
  const Vector6d e = s.f * moment;
  const double kappa = 1.0 / (kSteel.E * own.I_y);
  EXPECT_NEAR(e(M_y), kappa, 1e-13 * kappa);
  EXPECT_NEAR(e(M_z), 0.0, 1e-13 * kappa);
  EXPECT_NEAR(e(N), -b * kappa, 1e-13 * kappa);
  // Mass: kinetic energy of a spin about the centroid's axis is rho I_own.
  Vector6d spin = Vector6d::Zero();
  spin(4) = 1.0;
  spin(0) = -b;
  EXPECT_NEAR(spin.dot(s.inertia.matrix() * spin), kSteel.rho * own.I_y, 1e-12 * kSteel.rho * own.I_y);
}

TEST(SectionMatrices, MatrixInputReturnsItsMatrix) {
  Constants c = constants_of(HollowCircle{0.2, 0.1}, 0.3);
  c.y_cs = 0.02;
  c.z_cs = 0.01;
  c.S_y = 0.1 * c.A * 0.01;
  const Section s = make_section("general", c, kSteel);
  const Matrix6d C = s.stiffness();
  const Section m = matrix_section("matrix", C, s.inertia.matrix());
  EXPECT_LT(((m.f - s.f).array() / s.f.array().abs().max(1e-30)).abs().maxCoeff(), 1e-9);
  // Rigid in shear: the same as infinite shear areas.
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(m.f_shear_rigid(i, j), s.f_shear_rigid(i, j), 1e-12 * std::sqrt(s.f(i, i) * s.f(j, j)));
}

TEST(SectionMatrices, StiffnessRatiosOf1e12SurviveInversion) {
  Matrix6d C = Matrix6d::Zero();
  C.diagonal() << 1e18, 1e6, 1e12, 1e3, 1e15, 1.0;
  C(N, M_z) = C(M_z, N) = 0.5e9;
  const Section s = matrix_section("stiff", C, Section{}.inertia.matrix());
  const Matrix6d unit = C * s.f;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(unit(i, j), i == j, 1e-14 * std::sqrt(C(i, i) / C(j, j)) + 1e-15) << i << j;
}

TEST(StressPoints, IntegrateToNothingButAgreeWithTextbooks) {
  const Rectangle shape{0.1, 0.2};
  const Section s = make_section("rectangle", shape, kSteel);
  const auto at = [&](const std::string& name) {
    for (const StressPoint& p : s.points)
      if (p.name == name) return p;
    throw std::logic_error(name);
  };
  Vector6d load = Vector6d::Zero();
  load(M_y) = 6.0;  // sigma = 6 M / (b h^2)
  EXPECT_NEAR((at("+z").S * load)(0), 6.0 * 6.0 / (0.1 * 0.04), 1e-8);
  load.setZero();
  load(V_z) = 1.0;  // 3/2 V/A at the axis
  EXPECT_NEAR((at("centre").S * load)(2), 1.5 / 0.02, 1e-10);
  load.setZero();
  load(T) = 1.0;  // Timoshenko and Goodier: T / (k_2 a b^2), k_2 = 0.246 for a/b = 2, three digits
  EXPECT_NEAR(1.0 / ((at("+y").S * load)(2) * 0.2 * 0.01), 0.246, 5e-4);
  // Short side: 0.795 of the long side's (same table as in Roark: tau at the short side for a/b = 2).
  EXPECT_NEAR(-(at("+z").S * load)(1) / (at("+y").S * load)(2), 0.795, 2e-3);
  // Circle: T r / I_p.
  const Section round = make_section("circle", Circle{0.2}, kSteel);
  EXPECT_NEAR((round.points[0].S * load)(2), 0.1 / round.constants->I_t, 1e-9);
}

TEST(Taper, InterpolatesDimensionsAndRefusesMixedKinds) {
  const Shape middle = interpolate(Rectangle{0.1, 0.4}, Rectangle{0.2, 0.2}, 0.25);
  EXPECT_DOUBLE_EQ(std::get<Rectangle>(middle).width, 0.125);
  EXPECT_DOUBLE_EQ(std::get<Rectangle>(middle).height, 0.35);
  EXPECT_THAT(refusal([] { interpolate(Circle{1.0}, Rectangle{1.0, 1.0}, 0.5); }), HasSubstr("same kind"));
}

TEST(SectionRefusal, SaysWhatIsWrong) {
  const Constants good = constants_of(Circle{0.1}, 0.3);
  Constants bad = good;
  bad.A = -1.0;
  EXPECT_THAT(refusal([&] { make_section("boom", bad, kSteel); }),
              HasSubstr("section \"boom\": A = -1 must"));
  bad = good;
  bad.S_y = 2.0 * std::sqrt(good.A * good.I_y);
  EXPECT_THAT(refusal([&] { make_section("boom", bad, kSteel); }), HasSubstr("not positive definite"));
  bad = good;
  bad.z_cg = 0.2;
  EXPECT_THAT(refusal([&] { make_section("boom", bad, kSteel); }), HasSubstr("about the centre of gravity"));
  bad = good;
  bad.A_sz = 0.0;
  EXPECT_THAT(refusal([&] { make_section("boom", bad, kSteel); }), HasSubstr("A_sz = 0 must be positive"));
  Matrix6d C = make_section("ok", good, kSteel).stiffness();
  const Matrix6d mass = Matrix6d::Zero();
  C(N, T) = C(T, N) = 1.1 * std::sqrt(C(N, N) * C(T, T));
  EXPECT_THAT(refusal([&] { matrix_section("ply", C, mass); }), HasSubstr("smallest eigenvalue is -0.1"));
  C(T, N) = 0.0;
  EXPECT_THAT(refusal([&] { matrix_section("ply", C, mass); }), HasSubstr("not symmetric: C(T, N)"));
  C(N, T) = 0.0;
  Matrix6d lumped = Matrix6d::Identity();
  EXPECT_THAT(refusal([&] { matrix_section("ply", C, lumped); }), HasSubstr("M_44 = M_55 + M_66"));
  EXPECT_THAT(refusal([] {
                constants_of(HollowCircle{0.1, 0.1}, 0.3);
              }),
              HasSubstr("inner_diameter = 0.1 must be smaller than outer_diameter = 0.1"));
  EXPECT_THAT(refusal([] {
                constants_of(HollowRectangle{0.1, 0.1, 0.05, 0.01}, 0.3);
              }),
              HasSubstr("twice the web = 0.1 must be smaller than width"));
  EXPECT_THAT(refusal([] {
                constants_of(HollowEllipse{2, 1, 1, 0.5}, 0.3, ShearFormula::cowper);
              }),
              HasSubstr("no shear factor by cowper"));
  EXPECT_THAT(refusal([] { constants_of(Circle{-0.1}, 0.3); }), HasSubstr("1 Circle: diameter = -0.1"));
  EXPECT_THAT(refusal([] { isotropic("jelly", 1e5, 0.5, 1000.0); }), HasSubstr("nu = 0.5 must lie between"));
}

}  // namespace
}  // namespace flexura::beam
