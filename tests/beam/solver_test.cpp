// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/solver.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "beam/section/shapes.hpp"
#include "tests/beam/common.hpp"
#include "tests/beam/section_meshes.hpp"

namespace flexura::beam {
namespace {

using std::numbers::pi;
using testing::divide;
using testing::ellipse_section;
using testing::grid_section;
using ::testing::HasSubstr;
using testing::kSteel;
using testing::rectangle_section;
using testing::refusal;

const Material kCork = isotropic("cork", 2.1e11, 0.0, 7850.0);  // no lateral contraction

SectionProperties solve(const SectionMesh& mesh, const Material& material = kSteel) {
  return solve_section("s", mesh, {Ply{ply_of(material)}});
}

TEST(SectionSolver, RectangleHasItsClosedForms) {
  const SectionProperties s = solve(rectangle_section(0.1, 0.2, 10, 20));
  const Constants exact = constants_of(Rectangle{0.1, 0.2}, 0.3);
  EXPECT_NEAR(s.area, 0.02, 1e-15);
  EXPECT_NEAR(s.I_y / exact.I_y, 1.0, 1e-12);  // degree-5 quadrature is exact on straight sides
  EXPECT_NEAR(s.I_z / exact.I_z, 1.0, 1e-12);
  EXPECT_NEAR(s.I_t / exact.I_t, 1.0, 1e-4);
  EXPECT_NEAR(s.shear_centre.norm(), 0.0, 1e-10);
  EXPECT_FALSE(s.section.open_thin_walled);
  EXPECT_FALSE(s.couples);
  // E A and E I need no correction for nu: sigma_yy = 0 comes out.
  EXPECT_NEAR(1.0 / s.section.f(N, N) / (kSteel.E * 0.02), 1.0, 1e-12);
  EXPECT_NEAR(1.0 / s.section.f(M_y, M_y) / (kSteel.E * exact.I_y), 1.0, 1e-10);
  EXPECT_NEAR(s.section.inertia.m, 7850 * 0.02, 1e-9);
  // Without Poisson's effect the shear areas are 5/6.
  const SectionProperties cork = solve(rectangle_section(0.1, 0.2, 10, 20), kCork);
  EXPECT_NEAR(cork.A_sy / 0.02, 5.0 / 6.0, 1e-4);
  EXPECT_NEAR(cork.A_sz / 0.02, 5.0 / 6.0, 1e-4);
}

TEST(SectionSolver, ConvergesWithFourthOrder) {
  const double exact = constants_of(Rectangle{0.1, 0.2}, 0.3).I_t;
  std::vector<double> errors;
  for (const int n : {2, 4, 8})
    errors.push_back(solve(rectangle_section(0.1, 0.2, n, 2 * n)).I_t / exact - 1.0);
  // Quadratic elements: energy, and with it the flexibility, with h^4 where the warping is smooth.  At a
  // right-angled corner it goes like r^2 ln r, which costs a power of ln h: slopes of 3.4 and 3.6 instead
  // of 4.  Stiffness from above.
  for (const double error : errors) EXPECT_GT(error, 0.0);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 3.7, 0.4);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 3.7, 0.4);
}

TEST(SectionSolver, CircleShearAreaIncludesPoissonsEffect) {
  // Saint-Venant's flexure of the circle by energy: kappa = 6 (1+nu)^2 / (7 + 14 nu + 8 nu^2) (J. D. Renton,
  // Int. J. Solids Struct. 27 (1991) 1901-1913), 6/7 at nu = 0.
  for (const double nu : {0.0, 0.3}) {
    const SectionProperties s =
        solve(ellipse_section(0.1, 0.1, 0.0, 5, 24), isotropic("m", 2.1e11, nu, 7850.0));
    const double kappa = 6 * (1 + nu) * (1 + nu) / (7 + 14 * nu + 8 * nu * nu);
    EXPECT_NEAR(s.A_sz / s.area / kappa, 1.0, 1e-4) << nu;
    EXPECT_NEAR(s.A_sy / s.area / kappa, 1.0, 1e-4) << nu;
    EXPECT_NEAR(s.I_t / (pi * 0.5e-4), 1.0, 1e-4);
    EXPECT_LT(s.I_w, 1e-6 * 1e-6);  // a circle does not warp: relative to r^6
  }
}

TEST(SectionSolver, EllipseTorsionAndWarping) {
  const double a = 0.1, b = 0.05;
  const SectionProperties s = solve(ellipse_section(a, b, 0.0, 5, 32));
  EXPECT_NEAR(s.area / (pi * a * b), 1.0, 1e-5);
  EXPECT_NEAR(s.I_t / (pi * a * a * a * b * b * b / (a * a + b * b)), 1.0, 1e-4);
  // omega = -(a^2 - b^2)/(a^2 + b^2) y z: I_w = (..)^2 pi a^3 b^3 / 24.
  const double k = (a * a - b * b) / (a * a + b * b);
  EXPECT_NEAR(s.I_w / (k * k * pi * a * a * a * b * b * b / 24), 1.0, 1e-4);
}

TEST(SectionSolver, ThinTube) {
  const double r = 0.1, q = 0.96;
  const SectionProperties s = solve(ellipse_section(r, r, q, 1, 72), kCork);
  const Constants exact = constants_of(HollowCircle{2 * r, 2 * r * q}, 0.0);
  EXPECT_NEAR(s.I_t / exact.I_t, 1.0, 1e-4);
  EXPECT_NEAR(s.I_y / exact.I_y, 1.0, 1e-5);
  EXPECT_NEAR(s.A_sz / exact.A_sz, 1.0, 1e-4);  // Cowper at nu = 0 is the energy's
}

TEST(SectionSolver, EquilateralTriangle) {
  // I_t = sqrt(3) a^4 / 80 (Timoshenko, Goodier, art. 105).
  const double a = 0.1, height = a * std::sqrt(3.0) / 2;
  const int n = 10;
  testing::SectionMeshBuilder builder(
      [&](double u, double v) { return Eigen::Vector2d(a * (u + 0.5 * v), height * v); }, 1e-8);
  using V = Eigen::Vector2d;
  for (int i = 0; i < n; ++i)
    for (int j = 0; i + j < n; ++j) {
      const double h = 1.0 / n, u = i * h, v = j * h;
      builder.add({V(u, v), V(u + h, v), V(u, v + h)});
      if (i + j + 1 < n) builder.add({V(u + h, v), V(u + h, v + h), V(u, v + h)});
    }
  const SectionProperties s = solve(builder.mesh());
  EXPECT_NEAR(s.I_t / (std::sqrt(3.0) * std::pow(a, 4) / 80), 1.0, 1e-4);
  EXPECT_LT((s.shear_centre - V(a / 2, height / 3)).norm(), 1e-4 * a);
  EXPECT_NEAR(s.I_1 / s.I_2, 1.0, 1e-10);
}

// Channel, web along z at y = 0 (mid-line), flanges towards +y; mid-line dimensions h, b.
SectionMesh channel(double h, double b, double t, int through, int along) {
  std::vector<double> y = divide(-t / 2, t / 2, through), z = divide(-h / 2 - t / 2, -h / 2 + t / 2, through);
  for (const double v : divide(t / 2, b, along)) y.push_back(v);
  for (const double v : divide(-h / 2 + t / 2, h / 2 - t / 2, along)) z.push_back(v);
  for (const double v : divide(h / 2 - t / 2, h / 2 + t / 2, through)) z.push_back(v);
  const auto unique = [](std::vector<double>& lines) {
    lines.erase(std::unique(lines.begin(), lines.end(), [](double p, double q) { return q - p < 1e-9; }),
                lines.end());
  };
  unique(y);
  unique(z);
  return grid_section(y, z,
                      [=](double p, double q) { return p < t / 2 || std::abs(q) > h / 2 - t / 2 ? 0 : -1; });
}

TEST(SectionSolver, ChannelShearCentreAndWarpingConstant) {
  // Thin wall: shear centre e = 3 b^2/(h + 6 b) behind the web's mid-line, I_w = t b^3 h^2/12 (3 b + 2 h)/(6
  // b + h), I_t = sum b t^3/3 (Vlasov).  t/h = 1/100: corrections of the order t/b = 2 %, squared for I_w's
  // and e's mid-line geometry; the corners stiffen torsion by about t/(2 b + h).
  const double h = 0.1, b = 0.05, t = 0.001;
  const SectionProperties s = solve(channel(h, b, t, 2, 40));
  EXPECT_NEAR(s.shear_centre.x() / (-3 * b * b / (h + 6 * b)), 1.0, 5e-3);
  EXPECT_NEAR(s.shear_centre.y(), 0.0, 1e-8);
  EXPECT_NEAR(s.I_w / (t * b * b * b * h * h / 12 * (3 * b + 2 * h) / (6 * b + h)), 1.0, 1e-2);
  EXPECT_NEAR(s.I_t / ((2 * b + h) * t * t * t / 3), 1.0, 1e-2);
  EXPECT_TRUE(s.section.open_thin_walled);
  // The section's matrix carries it: a force along z at the shear centre does not twist, at the centroid it
  // does.
  Vector6d load = Vector6d::Zero();
  load(V_z) = 1.0;
  load(T) = s.shear_centre.x();
  EXPECT_NEAR((s.section.f * load)(T) / (s.section.f(T, T) * h), 0.0, 1e-10);
}

TEST(SectionSolver, AnglePrincipalAxes) {
  // L 0.1 x 0.06 x 0.01: moments of two rectangles, from the definition.
  const double a = 0.1, b = 0.06, t = 0.01;
  const auto mesh = grid_section({0, 0.005, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06},
                                 {0, 0.005, 0.01, 0.03, 0.05, 0.07, 0.085, 0.1},
                                 [&](double y, double z) { return y < t || z < t ? 0 : -1; });
  const SectionProperties s = solve(mesh);
  const double A_1 = t * a, A_2 = (b - t) * t, y_2 = t + (b - t) / 2;
  const double A = A_1 + A_2, y_c = (A_1 * t / 2 + A_2 * y_2) / A, z_c = (A_1 * a / 2 + A_2 * t / 2) / A;
  const double I_y = t * a * a * a / 3 + (b - t) * t * t * t / 3 - A * z_c * z_c;
  const double I_z = a * t * t * t / 3 + t * (b * b * b - t * t * t) / 3 - A * y_c * y_c;
  const double yz = A_1 * t / 2 * a / 2 + A_2 * y_2 * t / 2 - A * y_c * z_c;
  EXPECT_NEAR(s.centroid.x(), y_c, 1e-14);
  EXPECT_NEAR(s.centroid.y(), z_c, 1e-14);
  EXPECT_NEAR(s.I_y / I_y, 1.0, 1e-12);
  EXPECT_NEAR(s.I_yz / -yz, 1.0, 1e-12);
  const double R = std::hypot((I_y - I_z) / 2, yz);
  EXPECT_NEAR(s.I_1 / ((I_y + I_z) / 2 + R), 1.0, 1e-12);
  EXPECT_NEAR(s.I_2 / ((I_y + I_z) / 2 - R), 1.0, 1e-12);
  EXPECT_NEAR(std::tan(2 * s.principal_angle), -2 * yz / (I_y - I_z), 1e-12);
  // The 6x6 agrees with General Advanced made of the same constants.
  const Section advanced = make_section("L", *s.section.constants, kSteel);
  for (const int i : {N, M_y, M_z})
    for (const int j : {N, M_y, M_z})
      EXPECT_NEAR(s.section.f(i, j), advanced.f(i, j), 1e-9 * std::sqrt(advanced.f(i, i) * advanced.f(j, j)));
  // Shear centre near the corner of the legs' mid-lines (thin-wall theory): within t/2.
  EXPECT_LT((s.shear_centre - Eigen::Vector2d(t / 2, t / 2)).norm(), t / 2);
}

TEST(SectionSolver, TurningTheMeshTurnsTheMatrix) {
  const double phi = 0.6, c = std::cos(phi), n = std::sin(phi);
  const SectionProperties s = solve(rectangle_section(0.1, 0.2, 3, 6));
  SectionMesh mesh = rectangle_section(0.1, 0.2, 3, 6);
  for (int k = 0; k < mesh.points.rows(); ++k) {
    const double y = mesh.points(k, 0), z = mesh.points(k, 1);
    mesh.points.row(k) << c * y - n * z, n * y + c * z;
  }
  const SectionProperties turned = solve(mesh);
  Matrix6d R = Matrix6d::Identity();
  for (const int at : {1, 4}) {
    R(at, at) = R(at + 1, at + 1) = c;
    R(at, at + 1) = -n;
    R(at + 1, at) = n;
  }
  const Matrix6d expected = R * s.section.f * R.transpose();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(turned.section.f(i, j), expected(i, j), 1e-9 * std::sqrt(expected(i, i) * expected(j, j)));
  EXPECT_NEAR(turned.principal_angle, phi, 1e-9);
}

TEST(SectionSolver, SandwichOfTwoMaterialsBendsLikeItsParts) {
  const Material foam = isotropic("foam", 2.1e9, 0.3, 100.0);
  const auto mesh =
      grid_section(divide(-0.05, 0.05, 4), {-0.05, -0.045, -0.04, -0.02, 0, 0.02, 0.04, 0.045, 0.05},
                   [](double, double z) { return std::abs(z) > 0.04 ? 0 : 1; });
  const SectionProperties s = solve_section("sandwich", mesh, {Ply{ply_of(kSteel)}, Ply{ply_of(foam)}});
  const double I_core = 0.1 * std::pow(0.08, 3) / 12, I_skin = 0.1 * std::pow(0.1, 3) / 12 - I_core;
  EXPECT_NEAR(s.I_y, I_skin + 0.01 * I_core, 1e-9 * I_skin);
  // The same nu everywhere: contraction fits, EI is the sum of the parts.
  EXPECT_NEAR(1 / s.section.f(M_y, M_y) / (kSteel.E * I_skin + foam.E * I_core), 1.0, 1e-8);
  EXPECT_NEAR(s.section.inertia.m, 7850 * 0.002 + 100 * 0.008, 1e-9);
  // Shear goes through the core: G_core b (h + t)^2/h within 5 % (sandwich theory, thin skins: t/h = 1/8
  // here).
  EXPECT_NEAR(1 / s.section.f(V_z, V_z) / (foam.G * 0.1 * 0.09 * 0.09 / 0.08), 1.0, 0.05);
}

PlyMaterial carbon() {
  return {"carbon", 1600, 140e9, 10e9, 10e9, 5e9, 5e9, 3.5e9, 0.3, 0.3, 0.4};
}

TEST(SectionSolver, OrthotropicTorsionFollowsFromStretchedCoordinates) {
  // G_xz phi-problem scaled to an isotropic one: GI_t = J(b sqrt(G_xz), h sqrt(G_xy)) / sqrt(G_xy G_xz)
  // (Lekhnitskii, Theory of elasticity of an anisotropic body).
  PlyMaterial m = carbon();
  m.G_12 = 5e9;  // G_xy
  m.G_13 = 2e9;  // G_xz
  const double b = 0.1, h = 0.04;
  const SectionProperties s = solve_section("strip", rectangle_section(b, h, 16, 8), {Ply{m}});
  const double J = constants_of(Rectangle{b * std::sqrt(m.G_13), h * std::sqrt(m.G_12)}, 0.3).I_t;
  EXPECT_NEAR(1 / s.section.f(T, T) / (J / std::sqrt(m.G_12 * m.G_13)), 1.0, 1e-4);
  EXPECT_FALSE(s.couples);
}

TEST(SectionSolver, OffAxisPlyStretchesAndShearsByItsCompliance) {
  // A pull on one off-axis ply is a uniform stress: eps = S'_xx sigma, gamma_xy = S'_xy,xx sigma (R. M.
  // Jones, Mechanics of composite materials, off-axis moduli).
  const double theta = pi / 6, c = std::cos(theta), n = std::sin(theta), A = 0.1 * 0.01;
  const PlyMaterial m = carbon();
  const SectionProperties s = solve_section("off-axis", rectangle_section(0.1, 0.01, 8, 2), {Ply{m, theta}});
  const double S_xx =
      std::pow(c, 4) / m.E_1 + (1 / m.G_12 - 2 * m.nu_12 / m.E_1) * c * c * n * n + std::pow(n, 4) / m.E_2;
  EXPECT_NEAR(s.section.f(N, N) * A / S_xx, 1.0, 1e-9);
  const double S_xs = (2 / m.E_1 + 2 * m.nu_12 / m.E_1 - 1 / m.G_12) * n * c * c * c -
                      (2 / m.E_2 + 2 * m.nu_12 / m.E_1 - 1 / m.G_12) * n * n * n * c;
  EXPECT_NEAR(s.section.f(N, V_y) * A / S_xs, 1.0, 1e-6);
  EXPECT_TRUE(s.couples);
  // Plies at +-theta through the thickness: stretch and twist couple, stretch and shear no longer.
  const auto mesh = grid_section(divide(-0.05, 0.05, 8), divide(-0.005, 0.005, 4),
                                 [](double, double z) { return z > 0 ? 0 : 1; });
  const SectionProperties pair = solve_section("pair", mesh, {Ply{m, theta}, Ply{m, -theta}});
  const Matrix6d& f = pair.section.f;
  EXPECT_GT(std::abs(f(N, T)), 0.05 * std::sqrt(f(N, N) * f(T, T)));
  EXPECT_LT(std::abs(f(N, V_y)), 1e-8 * std::sqrt(f(N, N) * f(V_y, V_y)));
  // The thickness turned by 90 degrees gives the same section, turned.
  const auto upright = grid_section(divide(-0.005, 0.005, 4), divide(-0.05, 0.05, 8),
                                    [](double y, double) { return y < 0 ? 0 : 1; });
  const Matrix6d g =
      solve_section("upright", upright, {Ply{m, theta, pi / 2}, Ply{m, -theta, pi / 2}}).section.f;
  EXPECT_NEAR(g(N, T), f(N, T), 1e-9 * std::abs(f(N, T)));
  EXPECT_NEAR(g(M_z, M_z), f(M_y, M_y), 1e-9 * f(M_y, M_y));
}

TEST(SectionSolver, StressPointsGiveTextbookStresses) {
  const SectionProperties s = solve(rectangle_section(0.1, 0.2, 10, 20));
  bool seen = false;
  for (const StressPoint& p : s.section.points) {
    Vector6d load = Vector6d::Zero();
    load(N) = 1.0;
    EXPECT_NEAR((p.S * load)(0), 50.0, 1e-6);
    load << 0, 0, 0, 0, 1, 0;
    EXPECT_NEAR((p.S * load)(0), p.z / (0.1 * 0.008 / 12), 1e-6 / (0.1 * 0.008 / 12));
    if (std::abs(p.z) < 1e-9 && p.y > 0.04) {
      seen = true;
      load << 0, 0, 0, 1, 0, 0;  // T / (0.246 a b^2), three digits; stresses converge with h^2
      EXPECT_NEAR((p.S * load)(2) * 0.246 * 0.2 * 0.01, 1.0, 1e-2);
    }
  }
  EXPECT_TRUE(seen);
}

TEST(SectionSolver, OutlineRunsAroundMaterialAndHoles) {
  const SectionProperties tube = solve(ellipse_section(0.1, 0.1, 0.5, 2, 16));
  ASSERT_EQ(tube.section.outline.size(), 2u);
  double area = 0.0;
  for (const Loop& loop : tube.section.outline)
    for (int k = 0; k < loop.rows(); ++k) {
      const int j = (k + 1) % static_cast<int>(loop.rows());
      area += 0.5 * (loop(k, 0) * loop(j, 1) - loop(j, 0) * loop(k, 1));
    }
  EXPECT_NEAR(area / (pi * 0.0075), 1.0, 0.01);  // a polygon of 32 corners: 0.6 %
}

TEST(SectionSolverRefusal, SaysWhatIsWrong) {
  SectionMesh mesh = rectangle_section(0.1, 0.2, 1, 1);
  const std::vector<Ply> steel = {Ply{ply_of(kSteel)}};
  SectionMesh bad = mesh;
  bad.triangles.row(0).swap(bad.triangles.row(1));
  std::swap(bad.triangles(0, 0), bad.triangles(0, 1));
  EXPECT_THAT(refusal([&] { solve_section("s", bad, steel); }), HasSubstr("turned inside out"));
  bad = grid_section({0, 1, 2, 3}, {0, 1}, [](double y, double) { return y < 1 || y > 2 ? 0 : -1; });
  EXPECT_THAT(refusal([&] { solve_section("two", bad, steel); }),
              HasSubstr("section \"two\": its mesh falls into"));
  bad = mesh;
  bad.ply = {0, 3};
  EXPECT_THAT(refusal([&] { solve_section("s", bad, steel); }), HasSubstr("material number 3; there are 1"));
  EXPECT_THAT(refusal([&] { solve_section("s", SectionMesh{}, steel); }), HasSubstr("no triangles"));
  PlyMaterial impossible = carbon();
  impossible.nu_12 = 6.0;
  EXPECT_THAT(refusal([&] { solve_section("s", mesh, {Ply{impossible}}); }),
              HasSubstr("material \"carbon\": the compliance"));
}

}  // namespace
}  // namespace flexura::beam
