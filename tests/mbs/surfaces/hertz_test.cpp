// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "mbs/forces/surfaces/surface_contact.hpp"
#include "tests/reference.hpp"

/// A rigid sphere pressed into an elastic half-space whose compliance lies in the body's static modes, against Hertz
/// (K. L. Johnson, Contact Mechanics, Cambridge 1985, 4.2):
///
///     F = 4/3 E* sqrt(R) d^(3/2),     a = sqrt(R d),     p_0 = 2 E* / pi sqrt(d / R)
namespace flexura::mbs::surfaces {
namespace {

using Eigen::MatrixXd;

constexpr double kR = 1.0, kDepth = 1e-4, kE = 2.2e11;  ///< [m], [m], E* = E / (1 - nu^2) [Pa]

/// Normal displacement at (x, y) by a unit pressure on the square of half side h about the origin, times pi E* (A. E. H. Love,
/// Phil. Trans. R. Soc. A 228 (1929); Johnson, eq. 3.25).
double love(double x, double y, double h) {
  const double xp = x + h, xm = x - h, yp = y + h, ym = y - h;
  const auto ln = [](double p, double q, double r) {
    return std::log((p + std::hypot(p, r)) / (q + std::hypot(q, r)));
  };
  return xp * ln(yp, ym, xp) + yp * ln(xp, xm, yp) + xm * ln(ym, yp, xm) + ym * ln(xm, xp, ym);
}

/// A quarter of the half-space z < 0, as it moves where all quarters bear the same: n x n squares from the axis on.
struct Quarter {
  Eigen::Matrix3Xd x;
  double side;
  MatrixXd compliance;  ///< displacement by a unit force on each square and its images
  Quarter(int n, double reach) : x(3, n * n), side(reach / n), compliance(n * n, n * n) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) x.col(i * n + j) << (i + 0.5) * side, (j + 0.5) * side, 0.0;
    for (int i = 0; i < n * n; ++i)
      for (int j = 0; j < n * n; ++j) {
        double u = 0.0;
        for (const double sx : {-1.0, 1.0})
          for (const double sy : {-1.0, 1.0})
            u += love(x(0, i) - sx * x(0, j), x(1, i) - sy * x(1, j), 0.5 * side);
        compliance(i, j) = u / (std::numbers::pi * kE * side * side);
      }
  }
};

/// What acts on the squares.
class Forces final : public Loads {
 public:
  void apply(int, const Spatial&) override {}
  void apply(CoordinateRef, double) override {}
  void apply_modal(int, const Eigen::VectorXd& f, double factor) override { on_squares = factor * f; }
  Eigen::VectorXd on_squares;
};

// Equilibrium u = C f(u) by Newton's method: where a square is pressed its force falls by k A with u.
TEST(HertzContact, HasForceAreaAndPressureOfASphereOnAHalfSpace) {
  constexpr int n = 18;
  const double a = std::sqrt(kR * kDepth), p_0 = 2.0 * kE / std::numbers::pi * std::sqrt(kDepth / kR);
  const double k = 1000.0 * p_0 / kDepth;  // gives way by a thousandth of the depth
  const Quarter quarter(n, 1.2 * a);
  const Eigen::Index m = quarter.x.cols();
  const double square = quarter.side * quarter.side;
  auto patch = std::make_shared<SurfacePatch>(quarter.x, Eigen::VectorXd::Constant(m, square));
  MatrixXd Phi = MatrixXd::Zero(3 * m, m);
  for (Eigen::Index j = 0; j < m; ++j) Phi(3 * j + 2, j) = 1.0;
  patch->set_shapes(Phi);
  ContactSurface sphere;
  sphere.kind = ContactSurface::Kind::sphere;
  sphere.radius = kR;
  const SurfaceContact contact("touch", 0, 1, patch, 0, sphere, PressureLaw(k, 1.0, 0.0), {});

  Eigen::VectorXd u = Eigen::VectorXd::Zero(m);
  const Eigen::VectorXd at_rest = u;
  const int touching = 1;
  Kinematics kin;
  kin.markers.resize(2);
  kin.markers[0].X_WP.p = Vector3d(0.0, 0.0, kR - kDepth);
  kin.bodies.resize(1);
  kin.bodies[0].s = u.data();
  kin.bodies[0].s_dot = at_rest.data();
  kin.own.root = &touching;
  Forces forces;
  double change = 1.0;
  int iterations = 0;
  for (; change > 1e-10 * kDepth && iterations < 50; ++iterations) {
    contact.apply(kin, nullptr, forces);
    const Eigen::VectorXd& f = forces.on_squares;
    const Eigen::VectorXd stiffness = (f.array() < 0.0).select(Eigen::VectorXd::Constant(m, k * square), 0.0);
    const Eigen::VectorXd step = (MatrixXd::Identity(m, m) + quarter.compliance * stiffness.asDiagonal())
                                     .partialPivLu()
                                     .solve(quarter.compliance * f - u);
    u += step;
    change = step.cwiseAbs().maxCoeff();
  }
  EXPECT_LT(iterations, 50);

  double values[9];
  contact.evaluate_outputs(kin, nullptr, values);
  const double F = 4.0 / 3.0 * kE * std::sqrt(kR) * std::pow(kDepth, 1.5), disc = std::numbers::pi * a * a;
  const auto off = [](double value, double exact) { return std::to_string(value / exact - 1.0); };
  RecordProperty("force", off(4.0 * values[1], F));
  RecordProperty("area", off(4.0 * values[6], disc));
  RecordProperty("pressure", off(values[7], p_0));
  constexpr flexura::test::Reference hertz{"Hertz: a sphere on a half space, by surface_contact",
                                           "squares of a fifteenth of the patch's radius"};
  flexura::test::expect_reference("force", "N", 4.0 * values[1], F, 0.03 * F, hertz);
  flexura::test::expect_reference("area", "m^2", 4.0 * values[6], disc, 0.03 * disc, hertz);
  flexura::test::expect_reference("greatest pressure", "Pa", values[7], p_0, 0.03 * p_0, hertz);
  EXPECT_GT(values[8], 100.0);
}

}  // namespace
}  // namespace flexura::mbs::surfaces
