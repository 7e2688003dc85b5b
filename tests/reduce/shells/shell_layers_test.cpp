// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Shells of unlike layers: against beams of two metals, Navier's plates of crossed plies and of sandwiches, and equilibrium.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "reduce/elements/shell_section.hpp"
#include "tests/reduce/shells/shell_statics.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
constexpr double kPi = std::numbers::pi;

Ply ply(const Material& material, double thickness) {
  return {material.D, material.density, thickness};
}

// A ply of carbon fibres at an angle [rad] from x.
Ply fibres(double angle, double thickness) {
  const Material straight = orthotropic("carbon",
                                        {.E_x = 140e9,
                                         .E_y = 10e9,
                                         .E_z = 10e9,
                                         .nu_xy = 0.3,
                                         .nu_yz = 0.3,
                                         .nu_zx = 0.3 * 10 / 140,
                                         .G_xy = 5e9,
                                         .G_yz = 3.5e9,
                                         .G_zx = 5e9},
                                        1600);
  return ply(turned(straight, Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix()), thickness);
}

Material metals(double t1, double t2) {
  return laminate(
      "metals",
      {ply(isotropic("aluminium", 70e9, 0.0, 2700), t1), ply(isotropic("steel", 210e9, 0.0, 7800), t2)},
      Vector3d::UnitX());
}

class ShellLayers : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Cells, ShellLayers, ::testing::Values(false, true),
                         [](const auto& info) { return info.param ? "Triangles" : "Quadrilaterals"; });

// Layers of one material are that material.
TEST(ShellSections, LikeLayersAreOne) {
  const Material steel = isotropic("steel", 210e9, 0.3, 7800);
  const Material layers =
      laminate("layers", {ply(steel, 1e-3), ply(steel, 3e-3), ply(steel, 2e-3)}, Vector3d::UnitY());
  const Matrix3d R = Eigen::AngleAxisd(0.4, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const ShellSection one = shell_section(steel, 6e-3, R), of = shell_section(layers, 6e-3, R);
  EXPECT_LT((of.A - one.A).norm(), 1e-13 * one.A.norm());
  EXPECT_LT((of.D - one.D).norm(), 1e-13 * one.D.norm());
  EXPECT_LT((of.S - one.S).norm(), 1e-12 * one.S.norm());
  EXPECT_FALSE(of.coupled);
  const ShellMass mass = shell_mass_per_area(layers, 6e-3);
  EXPECT_NEAR(mass.mass, 7800 * 6e-3, 1e-12);
  EXPECT_NEAR(mass.first, 0.0, 1e-15);
  EXPECT_NEAR(mass.second / (7800 * std::pow(6e-3, 3) / 12), 1.0, 1e-12);
}

// The energy of the shear stresses that equilibrium gives, of the transformed section as of a beam of two metals, by a sum of
// 20,000 slices; a sandwich with thin stiff faces has G d^2 / c (Allen 1969) to the ratio of the faces to the core.
TEST(ShellSections, TransverseShearIsThatOfEquilibrium) {
  const double t1 = 4e-3, t2 = 6e-3, h = t1 + t2;
  const auto E = [&](double z) { return z < t1 ? 70e9 : 210e9; };
  const int n = 20000;
  double EA = 0, ES = 0, EI = 0;
  for (int k = 0; k < n; ++k) {
    const double z = (k + 0.5) * h / n;
    EA += E(z) * h / n, ES += E(z) * z * h / n, EI += E(z) * z * z * h / n;
  }
  const double neutral = ES / EA, EI_n = EI - neutral * ES;
  double tau = 0, flexibility = 0;
  for (int k = 0; k < n; ++k) {
    const double z = (k + 0.5) * h / n, add = E(z) * (neutral - z) / EI_n * h / n;
    flexibility += std::pow(tau + 0.5 * add, 2) / (0.5 * E(z)) * h / n;
    tau += add;
  }
  const ShellSection of = shell_section(metals(t1, t2), h, Matrix3d::Identity());
  EXPECT_NEAR(of.S(0, 0) * flexibility, 1.0, 1e-6);
  EXPECT_NEAR(of.S(1, 1) * flexibility, 1.0, 1e-6);

  const Material face = isotropic("steel", 210e9, 0.3, 7800), core = isotropic("foam", 70e6, 0.3, 60);
  const double f = 0.1e-3, c = 20e-3;
  const ShellSection sandwich =
      shell_section(laminate("sandwich", {ply(face, f), ply(core, c), ply(face, f)}, Vector3d::UnitX()),
                    c + 2 * f, Matrix3d::Identity());
  const double G = 70e6 / 2.6;
  EXPECT_NEAR(sandwich.S(0, 0) / (G * (c + f) * (c + f) / c), 1.0, 2 * f / c);
}

// Constant stretch and curvature given at the outer nodes are found inside, also where one calls up the other.
TEST_P(ShellLayers, PassThePatchTest) {
  const Material material =
      laminate("cross", {fibres(0.0, 0.5e-3), fibres(0.5 * kPi, 0.7e-3)}, Vector3d::UnitX());
  ShellMesh mesh = shell_grid(3, 2, GetParam(), [](double r, double s) {
    return Vector3d(0.24 * r + 0.03 * std::sin(3 * kPi * r) * std::sin(kPi * s),
                    0.12 * s + 0.02 * r * (1 - r) * s * (1 - s), 0);
  });
  const auto field = [](const Vector3d& x) {
    Eigen::Matrix<double, 6, 1> u;
    const double w = 0.5e-2 * (x(0) * x(0) + x(0) * x(1) + x(1) * x(1)), wx = 1e-2 * (x(0) + 0.5 * x(1)),
                 wy = 1e-2 * (x(1) + 0.5 * x(0));
    u << 1e-5 * (x(0) + 0.5 * x(1)), 1e-5 * (x(1) + 0.1 * x(0)), w, wy, -wx, 1e-5 * 0.5 * (0.1 - 0.5);
    return u;
  };
  Statics model(mesh, material, 1.2e-3);
  const auto is_outer = [&](int node) {
    const int i = node % 4, j = node / 4;
    return i == 0 || i == 3 || j == 0 || j == 2;
  };
  double largest = 0.0;
  for (int node = 0; node < mesh.points.rows(); ++node) {
    const auto u = field(mesh.points.row(node).transpose());
    largest = std::max(largest, u.cwiseAbs().maxCoeff());
    for (int d = 0; d < 6 && is_outer(node); ++d) model.hold(6 * node + d, u(d));
  }
  const VectorXd u = model.solve();
  for (int node = 0; node < mesh.points.rows(); ++node)
    EXPECT_LT((u.segment<6>(6 * node) - field(mesh.points.row(node).transpose())).norm(), 1e-9 * largest)
        << node;
  // And its stresses on both sides, sigma = Q (e + z k); on the upper side fibres run along y.
  for (const auto& cell : mesh.cells) {
    const NodePositions x = corners(mesh, cell);
    VectorXd q(6 * x.rows());
    for (Index a = 0; a < x.rows(); ++a) q.segment<6>(6 * a) = field(x.row(a).transpose());
    const ShellStress stress = shell_stress(x, material, 1.2e-3, 0.0);
    const double turn = shell_frame(x).R(2, 2);  // triangles and quadrilaterals all look up
    ASSERT_GT(turn, 0.99);
    const Vector3d e(1e-5, 1e-5, 0.6e-5), k(-1e-2, -1e-2, -1e-2);
    for (const bool top : {true, false}) {
      const Ply of = fibres(top ? 0.5 * kPi : 0.0, 1.0);
      const ShellSection section =
          shell_section({.name = "one", .D = of.D, .density = 1.0}, 1.0, Matrix3d::Identity());
      const Vector3d exact = section.A * (e + (top ? 0.6e-3 : -0.6e-3) * k);
      for (const MatrixXd& at : top ? stress.top : stress.bottom) {
        const VectorXd sigma = at * q;
        EXPECT_LT((Vector3d(sigma(0), sigma(1), sigma(3)) - exact).norm(), 1e-8 * exact.norm()) << top;
      }
    }
  }
}

// A cantilever of two metals without contraction: u = a N, and by bending with N = 0; a = D/(A D - B^2), b = -B/(A D - B^2),
// d = A/(A D - B^2) for each width, tip by 1/3 d l^3 + l/S.
TEST(ShellLayersOfAStrip, BendAndStretchAsABeamOfTwoMetals) {
  const double l = 1.0, b = 0.1, t1 = 4e-3, t2 = 6e-3;
  const Material material = metals(t1, t2);
  Statics model(shell_grid(8, 1, false, [&](double r, double s) { return Vector3d(l * r, b * s, 0); }),
                material, t1 + t2);
  model.hold({0, 9}, {0, 1, 2, 3, 4, 5});
  const ShellSection section = shell_section(material, t1 + t2, Matrix3d::Identity());
  const double A = b * section.A(0, 0), B = b * section.B(0, 0), D = b * section.D(0, 0),
               S = b * section.S(0, 0), det = A * D - B * B;
  const auto tip = [&](int load, int at) {
    Statics loaded = model;
    loaded.push(8, load, 0.5), loaded.push(17, load, 0.5);
    return loaded.solve()(6 * 8 + at);
  };
  EXPECT_NEAR(tip(0, 0) / (l * D / det), 1.0, 1e-9);
  EXPECT_NEAR(tip(4, 4) / (l * A / det), 1.0, 1e-9);
  EXPECT_NEAR(tip(0, 4) / (-l * B / det), 1.0, 1e-9);
  EXPECT_NEAR(tip(4, 0) / (-l * B / det), 1.0, 1e-9);
  EXPECT_NEAR(tip(2, 2) / (l * l * l / 3 * A / det + l / S), 1.0, 1e-9);
}

// A square plate under q sin(pi x/a) sin(pi y/a), at its edges free to move across them alone.  Crossed plies, antisymmetric:
// Navier's three equations of the thin plate (R. M. Jones, Mechanics of Composite Materials, 5.3); a sandwich: 1/(4 D c^4) +
// 1/(2 S c^2), c = pi/a.
TEST_P(ShellLayers, SagAsNaviersPlates) {
  const double a = 1.0, c = kPi / a;
  const auto middle = [&](int n, const Material& material, double t) {
    Statics model(shell_grid(n, n, GetParam(), [&](double r, double s) { return Vector3d(a * r, a * s, 0); }),
                  material, t);
    const ShellMesh& mesh = model.mesh();
    for (int k = 0; k <= n; ++k) {
      for (const int i : {0, n}) model.hold({mesh.node(i, k)}, {1, 2, 3});
      for (const int j : {0, n}) model.hold({mesh.node(k, j)}, {0, 2, 4});
      for (int j = 1; k > 0 && k < n && j < n; ++j)
        model.push(mesh.node(k, j), 2, std::sin(kPi * k / n) * std::sin(kPi * j / n) * a * a / (n * n));
    }
    return model.solve()(6 * mesh.node(n / 2, n / 2) + 2);
  };
  const double t = 4e-3;
  const Material cross = laminate("cross", {fibres(0.0, t / 2), fibres(0.5 * kPi, t / 2)}, Vector3d::UnitX());
  const ShellSection of = shell_section(cross, t, Matrix3d::Identity());
  ASSERT_TRUE(of.coupled);
  Matrix3d equations;
  const double c2 = c * c, c3 = c2 * c, c4 = c2 * c2;
  equations << (of.A(0, 0) + of.A(2, 2)) * c2, (of.A(0, 1) + of.A(2, 2)) * c2, -of.B(0, 0) * c3,  //
      (of.A(0, 1) + of.A(2, 2)) * c2, (of.A(1, 1) + of.A(2, 2)) * c2, -of.B(1, 1) * c3,           //
      -of.B(0, 0) * c3, -of.B(1, 1) * c3, (of.D(0, 0) + 2 * (of.D(0, 1) + 2 * of.D(2, 2)) + of.D(1, 1)) * c4;
  const double exact = equations.inverse()(2, 2);
  // The load of a cell is at its corners, which alone is 1/2 (pi/n)^2/3 off or so: 0.6 % at 16.
  double before = 1.0;
  for (const int n : {8, 16}) {
    const double error = std::abs(middle(n, cross, t) / exact - 1.0);
    EXPECT_LT(error, n == 8 ? 0.05 : 0.0125) << n;
    EXPECT_LT(error, 0.5 * before) << n;
    before = error;
  }
  // Without the coupling it would be stiffer by a third and more.
  EXPECT_GT(exact * (of.D(0, 0) + 2 * (of.D(0, 1) + 2 * of.D(2, 2)) + of.D(1, 1)) * c4, 1.3);

  const Material face = isotropic("steel", 210e9, 0.3, 7800), core = isotropic("foam", 70e6, 0.3, 60);
  const Material sandwich =
      laminate("sandwich", {ply(face, 1e-3), ply(core, 40e-3), ply(face, 1e-3)}, Vector3d::UnitX());
  const ShellSection s = shell_section(sandwich, 42e-3, Matrix3d::Identity());
  const double bending = 1 / (4 * s.D(0, 0) * c4), shear = 1 / (2 * s.S(0, 0) * c2);
  EXPECT_GT(shear, 2 * bending);  // 5/6 of the mean modulus would have none of it
  EXPECT_NEAR(middle(16, sandwich, 42e-3) / (bending + shear), 1.0, 0.02);
}

}  // namespace
}  // namespace flexura::reduce
