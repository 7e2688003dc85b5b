// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/element/element.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "beam/section/shapes.hpp"

namespace flexura::beam {
namespace {

const Material kSteel = isotropic("steel", 2.1e11, 0.3, 7850.0);
constexpr double kEps = std::numeric_limits<double>::epsilon();

template <class Function>
std::string refusal(Function&& function) {
  try {
    function();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no refusal";
}

// Largest difference relative to the diagonals, so that every unit has its own scale.
double scaled_difference(const Matrix12d& a, const Matrix12d& b) {
  double worst = 0.0;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j < 12; ++j)
      worst = std::max(worst, std::abs(a(i, j) - b(i, j)) / std::sqrt(b(i, i) * b(j, j)));
  return worst;
}

// A section that couples everything: an unsymmetrical composite.
Section coupled_section() {
  Matrix6d C = Matrix6d::Zero();
  C.diagonal() << 4e8, 6e7, 9e7, 3e5, 8e5, 5e5;
  const auto couple = [&](int i, int j, double r) { C(i, j) = C(j, i) = r * std::sqrt(C(i, i) * C(j, j)); };
  couple(N, T, 0.3);
  couple(N, M_y, 0.2);
  couple(N, M_z, -0.25);
  couple(V_y, V_z, 0.1);
  couple(V_y, T, -0.3);
  couple(V_z, T, 0.4);
  couple(V_z, M_y, 0.15);
  couple(V_y, M_z, 0.2);
  couple(T, M_y, -0.2);
  couple(M_y, M_z, 0.3);
  const SectionInertia inertia{20.0, 0.1, -0.2, 0.05, 0.08, 0.01};
  return matrix_section("composite", C, inertia.matrix());
}

Eigen::Matrix<double, 12, 6> rigid_motions(double length) {
  Eigen::Matrix<double, 12, 6> R = Eigen::Matrix<double, 12, 6>::Zero();
  R.topRows<6>().setIdentity();
  R.bottomRows<6>().setIdentity();
  R(8, 4) = -length;  // w = -x theta_y
  R(7, 5) = length;   // v = x theta_z
  return R;
}

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
  EXPECT_THAT(text({0, 6}), testing::HasSubstr("slide along its axis"));
  EXPECT_THAT(text({3, 9}), testing::HasSubstr("spin about its axis"));
  EXPECT_THAT(text({2, 4, 10}), testing::HasSubstr("move across along its z axis"));
  EXPECT_THAT(text({1, 7}), testing::HasSubstr("slide along its y axis"));
  EXPECT_THAT(text({4, 10, 5, 11, 3}), testing::HasSubstr("no refusal"));
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
  EXPECT_THAT(refusal([] {
                place("member 7", {1, 2, 3}, {1, 2, 3}, {0, 1, 0});
              }),
              testing::AllOf(testing::HasSubstr("member 7 has no length"), testing::HasSubstr("(1, 2, 3)")));
  EXPECT_THAT(refusal([] {
                place("member 7", {0, 0, 0}, {1, 0, 0}, {-2, 1e-9, 0});
              }),
              testing::HasSubstr(
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
