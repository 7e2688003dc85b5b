// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/exact/element.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>
#include <random>

#include "beam/exact/rotation.hpp"

namespace flexura::beam::exact {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::numbers::pi;

Matrix6d coupled_section() {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  Matrix6d A;
  for (double& x : A.reshaped()) x = normal(random);
  return Vector6d(9.0, 4.0, 5.0, 2.0, 3.0, 1.5).asDiagonal().toDenseMatrix() + 0.2 * A * A.transpose();
}

SectionInertia lopsided_mass() {
  return {.m = 1.3, .m_y = 0.1, .m_z = -0.07, .m_yy = 0.06, .m_zz = 0.09, .m_yz = 0.02};
}

struct State {
  VectorXd s, s_dot, s_ddot;
};
State random_state(int n, unsigned seed, double size = 0.4) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  State out{VectorXd(n), VectorXd(n), VectorXd(n)};
  for (VectorXd* x : {&out.s, &out.s_dot, &out.s_ddot})
    for (double& value : *x) value = size * normal(random);
  return out;
}

Vector3d axial(const Matrix3d& W) {
  return 0.5 * Vector3d(W(2, 1) - W(1, 2), W(0, 2) - W(2, 0), W(1, 0) - W(0, 1));
}

class OfEveryKind : public testing::TestWithParam<Kind> {
 protected:
  Element element() const {
    Vector6d rest;
    rest << 0.0, 0.0, 0.0, 0.3, -0.4, 0.5;
    return {strain_field(GetParam(), coupled_section(), 1.7), 1.7, lopsided_mass(), rest};
  }
};
INSTANTIATE_TEST_SUITE_P(Element, OfEveryKind, testing::Values(Kind::beam, Kind::rod, Kind::cable));

// Central differences with h = 1e-5 are right to 1e-10 of values of order 1, and round-off over h: 1e-11.
constexpr double kStep = 1e-5, kDifference = 2e-9;

TEST_P(OfEveryKind, VelocitiesAndAccelerationsAreRatesOfThePose) {
  const Element e = element();
  const State x = random_state(e.n(), 1);
  for (const double at : {0.5, 1.7}) {
    const Element::Place place = e.place(at);
    const auto moved = [&](double t) {
      const VectorXd s = x.s + t * x.s_dot + 0.5 * t * t * x.s_ddot, s_dot = x.s_dot + t * x.s_ddot;
      return e.motion(place, s.data(), s_dot.data(), x.s_ddot.data());
    };
    const auto now = moved(0.0), before = moved(-kStep), after = moved(kStep);
    Vector6d V;
    V << axial((after.R - before.R) / (2 * kStep) * now.R.transpose()), (after.p - before.p) / (2 * kStep);
    EXPECT_LT((now.V - V).norm(), kDifference);
    EXPECT_LT((now.A - (after.V - before.V) / (2 * kStep)).norm(), kDifference);
    Element::Columns map;
    e.map(place, x.s.data(), map);
    EXPECT_LT((map * x.s_dot - now.V).norm(), 1e-14);
  }
}

TEST_P(OfEveryKind, TangentsOfASectionsMotionAreItsDerivatives) {
  const Element e = element();
  const State x = random_state(e.n(), 2);
  const Element::Place place = e.place(1.2);
  Vector6d wrench;
  wrench << 0.3, -1.0, 0.7, 2.0, 0.4, -0.9;
  Element::MotionTangents d;
  e.motion_tangents(place, x.s.data(), x.s_dot.data(), x.s_ddot.data(), wrench, d);
  for (int j = 0; j < e.n(); ++j) {
    VectorXd s[2] = {x.s, x.s}, v[2] = {x.s_dot, x.s_dot};
    Element::Motion by_s[2], by_v[2];
    VectorXd force[2];
    for (const int side : {0, 1}) {
      const double h = side == 0 ? -kStep : kStep;
      s[side](j) += h;
      v[side](j) += h;
      by_s[side] = e.motion(place, s[side].data(), x.s_dot.data(), x.s_ddot.data());
      by_v[side] = e.motion(place, x.s.data(), v[side].data(), x.s_ddot.data());
      Element::Columns map;
      e.map(place, s[side].data(), map);
      force[side] = map.transpose() * wrench;
    }
    EXPECT_LT((d.V_s.col(j) - (by_s[1].V - by_s[0].V) / (2 * kStep)).norm(), kDifference);
    EXPECT_LT((d.A_s.col(j) - (by_s[1].A - by_s[0].A) / (2 * kStep)).norm(), kDifference);
    EXPECT_LT((d.A_v.col(j) - (by_v[1].A - by_v[0].A) / (2 * kStep)).norm(), kDifference);
    EXPECT_LT((d.map_s.col(j) - (force[1] - force[0]) / (2 * kStep)).norm(), kDifference);
  }
}

// d/dt (dT/ds') - dT/ds with T = s' M s'/2, M of integrate(), at a start that rests.
TEST_P(OfEveryKind, InertiaForcesAreThoseOfLagrange) {
  const Element e = element();
  const State x = random_state(e.n(), 4);
  const auto momentum = [&](double t) -> VectorXd {
    const VectorXd s = x.s + t * x.s_dot + 0.5 * t * t * x.s_ddot, s_dot = x.s_dot + t * x.s_ddot;
    Element::Integrals at;
    e.integrate(s.data(), at);
    return at.M * s_dot;
  };
  const auto energy = [&](const VectorXd& s) {
    Element::Integrals at;
    e.integrate(s.data(), at);
    return 0.5 * x.s_dot.dot(at.M * x.s_dot);
  };
  VectorXd expected = (momentum(kStep) - momentum(-kStep)) / (2 * kStep);
  for (int j = 0; j < e.n(); ++j) {
    VectorXd a = x.s, b = x.s;
    a(j) += kStep;
    b(j) -= kStep;
    expected(j) -= (energy(a) - energy(b)) / (2 * kStep);
  }
  VectorXd need(e.n());
  e.inertia_force(x.s.data(), x.s_dot.data(), x.s_ddot.data(), {}, need.data());
  EXPECT_LT((need - expected).norm(), kDifference);
}

TEST_P(OfEveryKind, TangentsOfTheInertiaAreItsDerivatives) {
  const Element e = element();
  const State x = random_state(e.n(), 5);
  const Element::Carried start{{0.7, -0.3, 1.1}, {0.2, 0.9, -0.4}, {1.0, -2.0, 0.5}};
  Element::InertiaTangents d;
  e.inertia_tangents(x.s.data(), x.s_dot.data(), x.s_ddot.data(), start, d);
  const auto difference = [&](bool by_rate, int j, VectorXd& need) -> Vector6d {
    Vector6d wrench = Vector6d::Zero();
    need.setZero(e.n());
    for (const double sign : {-1.0, 1.0}) {
      VectorXd s = x.s, v = x.s_dot, f(e.n());
      (by_rate ? v : s)(j) += sign * kStep;
      wrench += sign / (2 * kStep) * e.inertia_force(s.data(), v.data(), x.s_ddot.data(), start, f.data());
      need += sign / (2 * kStep) * f;
    }
    return wrench;
  };
  for (int j = 0; j < e.n(); ++j) {
    VectorXd need;
    Vector6d wrench = difference(false, j, need);
    EXPECT_LT((d.wrench_s.col(j) - wrench).norm(), 5 * kDifference);
    EXPECT_LT((d.need_s.col(j) - need).norm(), 5 * kDifference);
    wrench = difference(true, j, need);
    EXPECT_LT((d.wrench_v.col(j) - wrench).norm(), 5 * kDifference);
    EXPECT_LT((d.need_v.col(j) - need).norm(), 5 * kDifference);
  }
}

Matrix6d diagonal(double EA, double GA, double GI, double EI) {
  return Vector6d(EA, GA, GA, GI, EI, EI).asDiagonal();
}

// A moment M bends a beam of length L and stiffness EI to an arc of the angle M L / EI whatever its size: the
// coordinates that balance it are linear in M, and the end stands where the arc ends.
TEST(PureBending, IsAnArc) {
  const double L = 2.0, EI = 3.0;
  const Element e(strain_field(Kind::beam, diagonal(1e4, 5e3, 2.0, EI), L), L, {.m = 1.0});
  for (const double angle : {0.1, 1.0, pi / 2, pi}) {
    SCOPED_TRACE(angle);
    Vector6d wrench = Vector6d::Zero();
    wrench(2) = EI * angle / L;
    Element::Columns map;
    VectorXd s = VectorXd::Zero(e.n());
    const Element::Place end = e.place(L);
    // The map of a moment about z does not change with s where all turns are about z.
    e.map(end, s.data(), map);
    s = e.stiffness().fullPivLu().solve(map.transpose() * wrench);
    e.map(end, s.data(), map);
    EXPECT_LT((e.stiffness() * s - map.transpose() * wrench).norm(), 1e-13 * wrench.norm());
    const Element::Motion at = e.motion(end, s.data(), nullptr, nullptr);
    EXPECT_NEAR(std::atan2(at.R(1, 0), at.R(0, 0)), angle, 1e-13);
    // Gauss' four points: angle^8 / 8!^3 4!^4 / 9 = 5e-10 angle^8 of the length.
    const double quadrature = L * 6e-10 * std::pow(angle, 8) + 1e-14;
    EXPECT_NEAR(at.p.x(), L / angle * std::sin(angle), quadrature);
    EXPECT_NEAR(at.p.y(), L / angle * (1 - std::cos(angle)), quadrature);
  }
}

// Once and twice around with 8 elements, each at the end of the one before.
TEST(PureBending, ClosesToACircleAndToTwo) {
  const int n = 8;
  const double L = 1.0, l = L / n;
  const Element e(strain_field(Kind::beam, diagonal(1e6, 4e5, 1.0, 1.0), l), l, {.m = 1.0});
  for (const int turns : {1, 2}) {
    VectorXd s = VectorXd::Zero(e.n());
    Vector6d wrench = Vector6d::Zero();
    wrench(2) = 2 * pi * turns / L;
    Element::Columns map;
    e.map(e.place(l), s.data(), map);
    s = e.stiffness().fullPivLu().solve(map.transpose() * wrench);
    const Element::Motion step = e.motion(e.place(l), s.data(), nullptr, nullptr);
    Matrix3d R = Matrix3d::Identity();
    Vector3d p = Vector3d::Zero();
    for (int k = 0; k < n; ++k) {
      p += R * step.p;
      R = R * step.R;
    }
    EXPECT_LT(p.norm(), 1e-13);  // a polygon of equal steps, whatever their length
    EXPECT_LT((R - Matrix3d::Identity()).norm(), 1e-13);
  }
}

// An arc that is twisted as well has the closed form of a helix: E = exp(x k^), r' = E e_1.
TEST(ConstantStrain, IsAHelix) {
  const double l = 1.4;
  const Vector3d k(0.9, -0.5, 0.7), u = k.normalized();
  Vector6d rest = Vector6d::Zero();
  rest.tail<3>() = k;
  const Element e(strain_field(Kind::rod, diagonal(1, 1, 1, 1), l), l, {.m = 1.0}, rest);
  const VectorXd s = VectorXd::Zero(e.n());
  for (const double x : {0.6, l}) {
    const Element::Motion at = e.motion(e.place(x), s.data(), nullptr, nullptr);
    const double w = k.norm(), c = std::cos(w * x), sn = std::sin(w * x);
    const Vector3d e_1 = Vector3d::UnitX(), along = u.x() * u;
    EXPECT_LT((at.R * e_1 - (along + c * (e_1 - along) + sn * u.cross(e_1))).norm(), 1e-14);
    const Vector3d p = x * along + sn / w * (e_1 - along) + (1 - c) / w * u.cross(e_1);
    // Inside, the polynomial through four points: (w l)^4 / 4! of its interpolation times the integral of Legendre's
    // fourth, below 5e-4; at the end Gauss' rule, as above.
    const double angle = w * l;
    EXPECT_LT((at.p - p).norm(),
              l * (x == l ? 6e-10 * std::pow(angle, 8) : 5e-4 / 24.0 * std::pow(angle, 4)));
  }
}

// Curvature that turns along the element: the error of the rotation falls with l^5 (W. Magnus, fourth order), against
// exp by many short steps.
TEST(LinearCurvature, ConvergesWithTheFifthPowerOfTheLength) {
  const auto error = [](double l) {
    StrainField field = strain_field(Kind::rod, diagonal(1, 1, 1, 1), l);
    const Vector3d k_0(0.5, 1.0, -0.7), k_1(1.0, -0.6, 1.2);
    field.k_0.col(0) = k_0;
    field.k_1.col(0) = k_1;
    VectorXd s = VectorXd::Unit(6, 0);
    const Element e(field, l, {.m = 1.0});
    Matrix3d R = Matrix3d::Identity();
    const int n = 4000;  // midpoint: an error of h^2
    for (int i = 0; i < n; ++i) {
      const Vector3d k = k_0 + (i + 0.5) * l / n * k_1;
      const Rotation<double> step(Vec<double>{l / n * k.x(), l / n * k.y(), l / n * k.z()});
      Matrix3d E;
      E << step.E.x.x, step.E.y.x, step.E.z.x, step.E.x.y, step.E.y.y, step.E.z.y, step.E.x.z, step.E.y.z,
          step.E.z.z;
      R = R * E;
    }
    return (e.motion(e.place(l), s.data(), nullptr, nullptr).R - R).norm();
  };
  const double order = std::log2(error(1.2) / error(0.6));
  EXPECT_GT(order, 4.7);
  EXPECT_LT(order, 5.5);
}

// The linear element of the same section is exact for loads at its ends: F = l f + l^3/12 D^T f D about the middle
// (R. L. Huston, Comput. Struct. 13 (1981) 349), here with stretch, shear, torsion and bending coupled.
TEST(EndLoads, AreAnsweredAsByTheLinearElementWhateverIsCoupled) {
  const double l = 0.8;
  const Matrix6d C = coupled_section(), f = C.inverse();
  const Element e(strain_field(Kind::beam, C, l), l, {.m = 1.0});
  const VectorXd s = VectorXd::Zero(e.n());
  Element::Columns map;
  e.map(e.place(l), s.data(), map);
  MatrixXd to_end(6, e.n());  // forces and moments about the end, in the order N, V, T, M
  to_end << map.bottomRows<3>(), map.topRows<3>();
  const Matrix6d found = to_end * e.stiffness().ldlt().solve(to_end.transpose());
  Matrix6d D = Matrix6d::Zero();
  D(4, 2) = 1.0;
  D(5, 1) = -1.0;
  // About the end: b(x) = 1 + (x - l) D.
  Matrix6d expected = Matrix6d::Zero();
  const Matrix6d at_middle = Matrix6d::Identity() - 0.5 * l * D;
  expected = l * at_middle.transpose() * f * at_middle + l * l * l / 12.0 * D.transpose() * f * D;
  EXPECT_LT((found - expected).norm(), 1e-12 * expected.norm());
}

TEST(Rotation, SeriesAndClosedFormsMeet) {
  // On both sides of t = 4 the values and their first two derivatives agree to their slope times 2e-9.
  const RotationSeries below(4.0 - 1e-9), above(4.0 + 1e-9);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(below.b[i], above.b[i], 1e-10);
    EXPECT_NEAR(below.c[i], above.c[i], 1e-10);
  }
  EXPECT_NEAR(above.b[0], (1 - std::cos(2.0)) / 4.0, 1e-10);
  EXPECT_NEAR(above.c[0], (2.0 - std::sin(2.0)) / 8.0, 1e-10);
}

TEST(StrainField, RefusesWhatHasNoStiffness) {
  Matrix6d C = diagonal(1, 1, 1, 1);
  C(4, 4) = 0.0;
  EXPECT_THROW(strain_field(Kind::beam, C, 1.0), std::invalid_argument);
  EXPECT_THROW(strain_field(Kind::rod, C, 1.0), std::invalid_argument);
  EXPECT_NO_THROW(strain_field(Kind::cable, C, 1.0));
  C(0, 0) = 0.0;
  EXPECT_THROW(strain_field(Kind::cable, C, 1.0), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::beam::exact
