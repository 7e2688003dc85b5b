// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Released ends, tapers, placement in space and inertia of the beam element.
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

TEST(Releases, HingedEndHasTheTextbookStiffness) {
  const Section section = make_section("r", Rectangle{0.1, 0.2}, kSteel);
  const double l = 1.7, EI = kSteel.E * section.constants->I_y;
  Releases hinge;
  hinge[10] = true;  // rotation about y at node 2
  const Element element(l, matrices_of(section, Theory::euler_bernoulli), hinge);
  const Matrix12d& K = element.stiffness();
  EXPECT_NEAR(K(2, 2) / (3 * EI / (l * l * l)), 1.0, 1e-13);
  EXPECT_NEAR(K(4, 4) / (3 * EI / l), 1.0, 1e-13);
  EXPECT_EQ(K.row(10).cwiseAbs().maxCoeff(), 0.0);
  // Both ends: a bar in that plane, not a mechanism.
  hinge[4] = true;
  EXPECT_NEAR(Element(l, matrices_of(section, Theory::euler_bernoulli), hinge).stiffness()(2, 2), 0.0,
              1e-12 * EI);
}

TEST(Releases, EqualStaticCondensationAndKeepTheMass) {
  const Section section = coupled_section();
  const double l = 0.9;
  Releases releases;
  for (const int dof : {3, 5, 7, 10}) releases[dof] = true;
  const Element full(l, matrices_of(section, Theory::timoshenko));
  const Element released(l, matrices_of(section, Theory::timoshenko), releases);
  std::vector<int> r, k;
  for (int dof = 0; dof < 12; ++dof) (releases[dof] ? r : k).push_back(dof);
  const Eigen::MatrixXd K = full.stiffness(), M = full.mass();
  Eigen::MatrixXd transform = Eigen::MatrixXd::Zero(12, 12);
  for (const int dof : k) transform(dof, dof) = 1.0;
  const Eigen::MatrixXd slip = -K(r, r).llt().solve(K(r, k));
  for (std::size_t i = 0; i < r.size(); ++i)
    for (std::size_t j = 0; j < k.size(); ++j) transform(r[i], k[j]) = slip(i, j);
  const Eigen::MatrixXd K_c = transform.transpose() * K * transform,
                        M_c = transform.transpose() * M * transform;
  EXPECT_LT((released.stiffness() - K_c).cwiseAbs().maxCoeff(), 1e-12 * K.cwiseAbs().maxCoeff());
  EXPECT_LT((released.mass() - M_c).cwiseAbs().maxCoeff(), 1e-12 * M.cwiseAbs().maxCoeff());
}

TEST(Releases, KeepTheirDigitsAtVanishingShearStiffness) {
  // Hinged at one end, 1/k = l^3/(3 EI) + l/(G A_s): condensing K would lose all digits at psi = 1e-12.
  Constants c = constants_of(Rectangle{0.1, 0.2}, 0.3);
  const double l = 1.0, psi = 1e-12;
  c.A_sz = 12 * kSteel.E * c.I_y / (kSteel.G * l * l) * psi / (1 - psi);
  Releases hinge;
  hinge[10] = true;
  const Element element(l, matrices_of(make_section("soft", c, kSteel), Theory::timoshenko), hinge);
  const double k = 1.0 / (l * l * l / (3 * kSteel.E * c.I_y) + l / (kSteel.G * c.A_sz));
  EXPECT_NEAR(element.stiffness()(2, 2) / k, 1.0, 32 * kEps);
}

TEST(Releases, LoadedMemberWithHingesIsASimpleBeam) {
  const Section section = make_section("r", Rectangle{0.1, 0.2}, kSteel);
  const double l = 2.0, EI = kSteel.E * section.constants->I_y;
  Releases hinges;
  hinges[4] = hinges[10] = true;
  const Element element(l, matrices_of(section, Theory::euler_bernoulli), hinges);
  LineLoad load;
  load.at_1(2) = load.at_2(2) = 1000.0;
  const Vector12d none = Vector12d::Zero();
  EXPECT_NEAR(element.section_forces(l / 2, none, load)(M_y), -1000.0 * l * l / 8 * -1.0, 1e-9);
  EXPECT_NEAR(element.section_forces(0.0, none, load)(M_y), 0.0, 1e-9);
  EXPECT_NEAR(element.displacement(l / 2, none, load)(2), 5 * 1000.0 * std::pow(l, 4) / (384 * EI), 1e-16);
  EXPECT_NEAR(element.load(load)(2), 1000.0, 1e-10);
}

TEST(Releases, ThatFreeTheElementItselfAreRefused) {
  const SectionMatrices section = matrices_of(make_section("r", Circle{0.1}, kSteel), Theory::timoshenko);
  const auto text = [&](std::initializer_list<int> dofs) {
    Releases releases;
    for (const int dof : dofs) releases[dof] = true;
    return refusal([&] { Element(1.0, section, releases); });
  };
  EXPECT_THAT(text({0, 6}), ::testing::HasSubstr("slide along its axis"));
  EXPECT_THAT(text({3, 9}), ::testing::HasSubstr("spin about its axis"));
  EXPECT_THAT(text({2, 4, 10}), ::testing::HasSubstr("move across along its z axis"));
  EXPECT_THAT(text({1, 7}), ::testing::HasSubstr("slide along its y axis"));
  EXPECT_THAT(text({4, 10, 5, 11, 3}), ::testing::HasSubstr("no refusal"));
}

TEST(TaperedElement, ConeUnderTipLoadAndItsMass) {
  // d from d_0 at the root to d_1 at the tip: delta = P l^3 / (3 E I_1) (d_1/d_0)^3 without shear; EA and
  // torsion likewise in closed form.  Twelve Gauss points on 1/(1+kt)^4 with d_0 = 2 d_1: below 1e-12.
  const double l = 1.5, d_0 = 0.2, d_1 = 0.1;
  const auto along = [&](double t) {
    return matrices_of(make_section("cone", interpolate(Circle{d_0}, Circle{d_1}, t), kSteel),
                       Theory::euler_bernoulli);
  };
  const Element element(l, along);
  const Vector6d tip = element.stiffness().bottomRightCorner<6, 6>().llt().solve(Vector6d::Unit(2));
  const double I_1 = std::numbers::pi * std::pow(d_1, 4) / 64;
  EXPECT_NEAR(tip(2) / (l * l * l / (3 * kSteel.E * I_1) * std::pow(d_1 / d_0, 3)), 1.0, 1e-12);
  const Vector6d pull = element.stiffness().bottomRightCorner<6, 6>().llt().solve(Vector6d::Unit(0));
  EXPECT_NEAR(pull(0) / (4 * l / (std::numbers::pi * kSteel.E * d_0 * d_1)), 1.0, 1e-12);
  const auto R = rigid_motions(l);
  const double mass = kSteel.rho * std::numbers::pi / 12 * l * (d_0 * d_0 + d_0 * d_1 + d_1 * d_1);
  EXPECT_NEAR((R.transpose() * element.mass() * R)(2, 2) / mass, 1.0, 1e-12);
  EXPECT_LT((element.stiffness() * R).cwiseAbs().maxCoeff(),
            64 * kEps * element.stiffness().cwiseAbs().maxCoeff());
  // A taper that does not taper is the uniform element.
  const Section uniform = make_section("u", Circle{d_0}, kSteel);
  const Element constant(l, [&](double) { return matrices_of(uniform, Theory::timoshenko); });
  const Element closed(l, matrices_of(uniform, Theory::timoshenko));
  EXPECT_LT(scaled_difference(constant.stiffness(), closed.stiffness()), 1e-13);
  EXPECT_LT(scaled_difference(constant.mass(), closed.mass()), 1e-13);
}

TEST(Placement, OrientsAndOffsets) {
  const Placement p = place("member", {1, 2, 3}, {1, 2, 8}, {0, 1, 0}, {0.1, 0, 0}, {0.1, 0, 0});
  EXPECT_NEAR(p.length, 5.0, 1e-15);
  EXPECT_LT((p.R_BE.col(0) - Eigen::Vector3d::UnitZ()).norm(), 1e-15);
  EXPECT_LT((p.R_BE.col(1) - Eigen::Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_NEAR(p.R_BE.determinant(), 1.0, 1e-15);
  // A rotation of the node about B's y moves the end by theta x offset = (0, 0, -0.1): along the element's
  // axis -x.
  Vector12d q = Vector12d::Zero();
  q(4) = 1.0;
  EXPECT_NEAR((p.transform() * q)(0), -0.1, 1e-15);
}

TEST(Placement, RefusesNoLengthAndParallelDirections) {
  EXPECT_THAT(
      refusal([] {
        place("member 7", {1, 2, 3}, {1, 2, 3}, {0, 1, 0});
      }),
      ::testing::AllOf(::testing::HasSubstr("member 7 has no length"), ::testing::HasSubstr("(1, 2, 3)")));
  EXPECT_THAT(refusal([] {
                place("member 7", {0, 0, 0}, {1, 0, 0}, {-2, 1e-9, 0});
              }),
              ::testing::HasSubstr(
                  "member 7: the direction (-2, 1e-09, 0) is parallel to the member's axis (1, 0, 0)"));
}

TEST(InertiaBlocks, AddUpToTheMassMatrixAndTheRigidBody) {
  const Section section = coupled_section();
  const Placement p = place("m", {0.3, -0.2, 0.5}, {1.0, 0.4, 0.9}, {0, 0, 1}, {0, 0.05, 0}, {0.02, 0, 0.01});
  const Element element(p.length, matrices_of(section, Theory::timoshenko));
  const InertiaBlocks b = element.inertia_blocks(p);
  const Matrix12d T = p.transform(), M = T.transpose() * element.mass() * T;
  EXPECT_LT((b.S_phiphi[0] + b.S_phiphi[1] + b.S_phiphi[2] - M).cwiseAbs().maxCoeff(), 1e-13 * M.maxCoeff());
  // Rigid motions of the two nodes about Bo: u = t + theta x x for every material point.
  Eigen::Matrix<double, 12, 6> R;
  const Eigen::Vector3d nodes[] = {{0.3, -0.2, 0.5}, {1.0, 0.4, 0.9}};
  for (int n = 0; n < 2; ++n) {
    Eigen::Matrix3d cross;
    cross << 0, nodes[n].z(), -nodes[n].y(), -nodes[n].z(), 0, nodes[n].x(), nodes[n].y(), -nodes[n].x(), 0;
    R.block<6, 6>(6 * n, 0) << Eigen::Matrix3d::Identity(), cross, Eigen::Matrix3d::Zero(),
        Eigen::Matrix3d::Identity();
  }
  EXPECT_NEAR(b.mass, section.inertia.m * p.length, 1e-13 * b.mass);
  EXPECT_LT((b.S_phi * R.leftCols<3>() - b.mass * Eigen::Matrix3d::Identity()).norm(), 1e-12 * b.mass);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d e = Eigen::Vector3d::Unit(axis);
    EXPECT_LT((b.S_phi * R.col(3 + axis) - e.cross(b.S_x)).norm(), 1e-12 * b.mass);
    // int x_a (e x x)_b dm = (S_xx [e]^T)_ab
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d expected = e.cross(Eigen::Vector3d(b.S_xx.row(a)));
      const Vector12d motion = R.col(3 + axis);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(b.S_xphi.row(3 * a + c) * motion, expected(c), 1e-12 * b.mass);
    }
  }
  // Cross blocks: int u_x u_y dm of two different rotations.
  const Vector12d spin_z = R.col(5), spin_x = R.col(3);  // u = (-y, x, 0) and (0, -z, y)
  EXPECT_NEAR(spin_z.dot(b.S_phiphi[3] * spin_x), b.S_xx(1, 2), 1e-12 * b.mass);  // int (-y)(-z)
  EXPECT_NEAR(spin_z.dot(b.S_phiphi[4] * spin_x), b.S_xx(0, 1), 1e-12 * b.mass);  // int x y
}

}  // namespace
}  // namespace flexura::beam
