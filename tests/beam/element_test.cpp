// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/beam/element_cases.hpp"

namespace flexura::beam {
namespace {

using namespace beam::testing;

TEST(Element, UncoupledElementIsThePrintedMatrixToRoundOff) {
  for (const double slenderness : {0.1, 1.0, 5.0, 1e3, 1e6})
    for (const auto theory : {Theory::euler_bernoulli, Theory::timoshenko}) {
      const double l = 0.1 * slenderness;
      const Section section = make_section("r", Rectangle{0.1, 0.17}, kSteel);
      const Element element(l, matrices_of(section, theory));
      const Matrix12d K = simbeam::stiffness(*section.constants, kSteel, l, theory);
      // Some thirty roundings on the way to each entry.
      EXPECT_LT(scaled_difference(element.stiffness(), K), 32 * kEps) << slenderness;
      for (const bool rotary : {true, false})
        EXPECT_LT(scaled_difference(element.mass(rotary),
                                    simbeam::mass(*section.constants, kSteel, l, theory, rotary)),
                  64 * kEps)
            << slenderness << rotary;
    }
}

TEST(Element, UncoupledElementIsThePrintedMatrixForAnyPsi) {
  for (const double psi : {1e-12, 1e-9, 1e-6, 1e-3, 0.1, 0.5, 0.9, 1.0 - 1e-9}) {
    Constants c = constants_of(Rectangle{0.1, 0.2}, 0.3);
    const double l = 0.7;
    c.A_sz = 12 * kSteel.E * c.I_y / (kSteel.G * l * l) * psi / (1 - psi);
    c.A_sy = 12 * kSteel.E * c.I_z / (kSteel.G * l * l) * psi / (1 - psi);
    const Section section = make_section("psi", c, kSteel);
    ASSERT_NEAR(simbeam::shear_factor(kSteel.E * c.I_y, kSteel.G * c.A_sz, l) / psi, 1.0, 1e-6);
    const Element element(l, matrices_of(section, Theory::timoshenko));
    const Matrix12d K = simbeam::stiffness(c, kSteel, l, Theory::timoshenko);
    EXPECT_LT(scaled_difference(element.stiffness(), K), 32 * kEps) << psi;
    // Translation rows are tiny, so the scaled measure sees their own digits.
    EXPECT_LT(scaled_difference(element.mass(), simbeam::mass(c, kSteel, l, Theory::timoshenko, true)),
              64 * kEps)
        << psi;
  }
}

TEST(Simbeam, PrintedMatricesAreTheClassicalOnesAtPsi1) {
  const double l = 3.0;
  const Eigen::Matrix4d M = simbeam::bending_mass(420.0, l, 1.0) / l,
                        R = simbeam::rotary_mass(30.0, l, 1.0) * l;
  EXPECT_NEAR(M(0, 0), 156.0, 1e-12);
  EXPECT_NEAR(M(0, 1), 54.0, 1e-12);
  EXPECT_NEAR(M(0, 2), -22.0 * l, 1e-12);
  EXPECT_NEAR(M(0, 3), 13.0 * l, 1e-12);
  EXPECT_NEAR(M(2, 2), 4.0 * l * l, 1e-12);
  EXPECT_NEAR(M(2, 3), -3.0 * l * l, 1e-12);
  EXPECT_NEAR(R(0, 0), 36.0, 1e-12);
  EXPECT_NEAR(R(0, 2), -3.0 * l, 1e-12);
  EXPECT_NEAR(R(2, 2), 4.0 * l * l, 1e-12);
  EXPECT_NEAR(R(2, 3), -1.0 * l * l, 1e-12);
}

TEST(Element, ExactForEndLoadsOfAFullyCoupledSection) {
  // Cantilever: K_22 d = p against the integral of e = f s(x) by Simpson's rule, which is exact here (cubic).
  const Section section = coupled_section();
  const double l = 1.3;
  const Element element(l, matrices_of(section, Theory::timoshenko));
  Vector6d p;
  p << 100, -200, 300, 40, -50, 60;
  const Vector6d d = element.stiffness().bottomRightCorner<6, 6>().llt().solve(p);
  // Virtual work of unit end loads: d_k = int s_k(x)^T f s(x) dx, s(x) from end load by equilibrium.
  const auto resultants = [l](const Vector6d& load, double x) {
    Vector6d s = load;
    s(M_y) -= (l - x) * load(V_z);
    s(M_z) += (l - x) * load(V_y);
    return s;
  };
  for (int k = 0; k < 6; ++k) {
    const Vector6d unit = Vector6d::Unit(k);
    double work = 0.0;
    for (const auto& [x, w] : {std::pair{0.0, l / 6}, std::pair{l / 2, 4 * l / 6}, std::pair{l, l / 6}})
      work += w * resultants(unit, x).dot(section.f * resultants(p, x));
    EXPECT_NEAR(d(k), work, 1e-12 * d.cwiseAbs().maxCoeff()) << k;
  }
  // Section forces anywhere.
  Vector12d q = Vector12d::Zero();
  q.tail<6>() = d;
  for (const double x : {0.0, 0.31, 1.3})
    EXPECT_LT((element.section_forces(x, q) - resultants(p, x)).norm(), 1e-10 * p.norm());
}

TEST(Element, ShapeFunctionsSatisfyTheStaticEquations) {
  // e = d' + D^T d by central differences (cubic field: error h^2/6 third derivative), then s = C e must obey
  // s' = D s.
  const Section section = coupled_section();
  const double l = 1.3, h = 1e-4;
  const Element element(l, matrices_of(section, Theory::timoshenko));
  const Matrix6d C = section.stiffness();
  Vector12d q;
  q << 1, -2, 3, -1, 2, 0.5, -1, 1, 0.3, 0.7, -0.2, 1;
  q *= 1e-3;
  EXPECT_LT((element.shape(0.0) * q - q.head<6>()).norm(), 1e-14);
  EXPECT_LT((element.shape(l) * q - q.tail<6>()).norm(), 1e-14);
  for (const double x : {0.2, 0.65, 1.1}) {
    const Vector6d d = element.shape(x) * q;
    Vector6d e = (element.shape(x + h) * q - element.shape(x - h) * q) / (2 * h);
    e(V_y) -= d(5);
    e(V_z) += d(4);
    const Vector6d s = element.section_forces(x, q);
    for (int k = 0; k < 6; ++k)
      EXPECT_NEAR((C * e - s)(k), 0.0, 1e-7 * std::sqrt(C(k, k)) * s.norm() / 500) << k;
  }
}

TEST(Element, RigidMotionsAreStrainFreeAndCarryTheMass) {
  const Section section = coupled_section();
  const double l = 0.8, m = section.inertia.m;
  const Element element(l, matrices_of(section, Theory::timoshenko));
  const auto R = rigid_motions(l);
  const Matrix12d& K = element.stiffness();
  EXPECT_LT((K * R).cwiseAbs().maxCoeff(), 64 * kEps * K.cwiseAbs().maxCoeff());
  const Matrix6d rigid = R.transpose() * element.mass() * R;
  EXPECT_NEAR(rigid(0, 0), m * l, 1e-13 * m * l);
  EXPECT_NEAR(rigid(1, 5), m * l * l / 2, 1e-13 * m * l);
  EXPECT_NEAR(rigid(0, 5), -section.inertia.m_y * l, 1e-13 * m * l);
  EXPECT_NEAR(rigid(3, 3), (section.inertia.m_yy + section.inertia.m_zz) * l, 1e-13 * m * l);
  EXPECT_NEAR(rigid(4, 4), m * l * l * l / 3 + section.inertia.m_zz * l, 1e-13 * m * l);
}

TEST(Element, SubdivisionDoesNotChangeTheStiffnessBetweenEnds) {
  const Section section = coupled_section();
  const Element whole(1.2, matrices_of(section, Theory::timoshenko));
  const Element half(0.6, matrices_of(section, Theory::timoshenko));
  Eigen::Matrix<double, 18, 18> K = Eigen::Matrix<double, 18, 18>::Zero();
  K.topLeftCorner<12, 12>() += half.stiffness();
  K.bottomRightCorner<12, 12>() += half.stiffness();
  Eigen::Matrix<double, 12, 12> condensed;
  const std::array<int, 12> keep = {0, 1, 2, 3, 4, 5, 12, 13, 14, 15, 16, 17};
  const Matrix6d inner = K.block<6, 6>(6, 6).llt().solve(Matrix6d::Identity());
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      condensed(i, j) = K(keep[i], keep[j]) - K.block<1, 6>(keep[i], 6) * inner * K.block<6, 1>(6, keep[j]);
  EXPECT_LT(scaled_difference(condensed, whole.stiffness()), 1e-12);  // condensation loses a few digits
}

TEST(Element, LineLoadsGiveExactDisplacementsAndForces) {
  // Cantilever under p(x) = p_1 + (p_2 - p_1) x/l across: beam tables, shear added.
  const Section section = make_section("r", Rectangle{0.1, 0.2}, kSteel);
  const double l = 2.0, EI = kSteel.E * section.constants->I_y, GA = kSteel.G * section.constants->A_sz;
  const Element element(l, matrices_of(section, Theory::timoshenko));
  LineLoad load;
  load.at_1(2) = 1000.0;
  load.at_2(2) = 400.0;
  Vector12d q = Vector12d::Zero();
  q.tail<6>() = element.stiffness().bottomRightCorner<6, 6>().llt().solve(element.load(load).tail<6>());
  const double uniform = 400.0, triangle = 600.0;  // the triangle is largest at the root
  const double bending = uniform * std::pow(l, 4) / (8 * EI) + triangle * std::pow(l, 4) / (30 * EI);
  const double shear = (uniform * l * l / 2 + triangle * l * l / 6) / GA;
  EXPECT_NEAR(q(8), bending + shear, 1e-13 * bending);
  for (const double x : {0.0, 0.5, 1.7, 2.0}) {
    const double r = l - x;  // load beyond x: uniform part and a small triangle of height triangle r/l
    const double V = uniform * r + triangle * r * r / (2 * l);
    const double M = -(uniform * r * r / 2 + triangle * r * r * r / (6 * l));
    const Vector6d s = element.section_forces(x, q, load);
    EXPECT_NEAR(s(V_z), V, 1e-10);
    EXPECT_NEAR(s(M_y), M, 1e-10);
  }
  // Deflection at mid-span against two elements of half the length.
  const Element half(1.0, matrices_of(section, Theory::timoshenko));
  LineLoad first = load, second = load;
  first.at_2(2) = second.at_1(2) = 700.0;
  Eigen::Matrix<double, 12, 12> K = Eigen::Matrix<double, 12, 12>::Zero();
  K.topLeftCorner<6, 6>() =
      half.stiffness().bottomRightCorner<6, 6>() + half.stiffness().topLeftCorner<6, 6>();
  K.bottomRightCorner<6, 6>() = half.stiffness().bottomRightCorner<6, 6>();
  K.topRightCorner<6, 6>() = half.stiffness().topRightCorner<6, 6>();
  K.bottomLeftCorner<6, 6>() = half.stiffness().bottomLeftCorner<6, 6>();
  Vector12d p;
  p << half.load(first).tail<6>() + half.load(second).head<6>(), half.load(second).tail<6>();
  const Vector12d d = K.llt().solve(p);
  EXPECT_NEAR(element.displacement(1.0, q, load)(2), d(2), 1e-12 * d(2));
  EXPECT_NEAR(element.displacement(1.0, q, load)(4), d(4), 1e-12 * std::abs(d(4)));
}

}  // namespace
}  // namespace flexura::beam
