// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "mbs/forces/surfaces/surface_contact.hpp"
#include "mbs/forces/surfaces/touched_shape.hpp"
#include "mbs/kinematics/deformation_derivatives.hpp"
#include "mbs/kinematics/smoothed_surface.hpp"
#include "tests/reference.hpp"

/// A rigid sphere pressed into an elastic half-space whose compliance lies in the body's static modes, and two elastic spheres, against Hertz
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
  const SurfaceContact contact("touch", {0, 1}, patch, {-1, 0}, std::make_shared<TouchedShape>(sphere),
                               PressureLaw(k, 1.0, 0.0), {});

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

/// What the contact's forces do to the coordinates of two bodies, and their derivatives.
class Blocks final : public Derivatives, public DeformationDerivatives, public Loads {
 public:
  explicit Blocks(Eigen::Index m) : m(m), f(Eigen::VectorXd::Zero(2 * m)), K(MatrixXd::Zero(2 * m, 2 * m)) {}
  Eigen::Index m;
  Eigen::VectorXd f;
  MatrixXd K;

  void apply(int, const Spatial&) override {}
  void apply(CoordinateRef, double) override {}
  void apply_modal(int body, const Eigen::VectorXd& on, double factor) override {
    f.segment(body * m, m) = factor * on;
  }
  void modal_forces_by(int body, int by, const Rows& by_s, const Rows&) override {
    K.block(body * m, by * m, m, m) = by_s;
  }
  DeformationDerivatives& deformations() override { return *this; }
  void between(int, int, const Vector6d&) override {}
  void wrench(int, int, int, const Vector6d&) override {}
  void force(CoordinateRef, double) override {}
  void modal(int, const Eigen::VectorXd&) override {}
  void rate(int) override {}
  void rows() override {}
  void by_relative(int, int, const Matrix&) override {}
  void by_coordinate(CoordinateRef, const Matrix&) override {}
  void by_speed(CoordinateRef, const Matrix&) override {}
  void by_signal(int, const Matrix&) override {}
  void by_deformation(int, int, const Vector6d&) override {}
  void by_state(int, const Matrix&) override {}
  void by_algebraic(double) override {}
  void by_deformation_rate(int, int, const Vector6d&) override {}
  void modal_forces(int, int, int, const Rows&) override {}
};

/// The surface of a quarter on all four sides of the axis, as its coordinates move it: squares of two facets on z = - rho^2 / (2 R),
/// each the image of another, and of four facets where they cross an axis.
std::shared_ptr<SurfaceMesh> facets_of(const Quarter& quarter, int n, double R) {
  const int k = 2 * n;
  std::vector<Vector3d> x;
  std::vector<Eigen::RowVectorXd> lifts;
  for (int i = 0; i < k; ++i)
    for (int j = 0; j < k; ++j) {
      Vector3d p((i - n + 0.5) * quarter.side, (j - n + 0.5) * quarter.side, 0.0);
      p.z() = -p.squaredNorm() / (2.0 * R);
      x.push_back(p);
      const int image = (i < n ? n - 1 - i : i - n) * n + (j < n ? n - 1 - j : j - n);
      lifts.push_back(Eigen::RowVectorXd::Unit(n * n, image));
    }
  std::vector<Eigen::Vector3i> facets;
  for (int i = 0; i + 1 < k; ++i)
    for (int j = 0; j + 1 < k; ++j) {
      const int around[] = {i * k + j, i * k + k + j, i * k + k + j + 1, i * k + j + 1};
      if (i == n - 1 || j == n - 1) {
        const auto middle = static_cast<int>(x.size());
        x.emplace_back(Vector3d::Zero());
        lifts.push_back(Eigen::RowVectorXd::Zero(n * n));
        for (int side = 0; side < 4; ++side) {
          x.back() += 0.25 * x[static_cast<std::size_t>(around[side])];
          lifts.back() += 0.25 * lifts[static_cast<std::size_t>(around[side])];
          facets.emplace_back(around[side], around[(side + 1) % 4], middle);
        }
        continue;
      }
      const int turn = (i < n) == (j < n) ? 0 : 1;
      facets.emplace_back(around[turn], around[turn + 1], around[turn + 2]);
      facets.emplace_back(around[turn], around[turn + 2], around[(turn + 3) % 4]);
    }
  const auto n_v = static_cast<Eigen::Index>(x.size());
  Eigen::Matrix3Xd places(3, n_v);
  Eigen::Matrix3Xi corners(3, facets.size());
  MatrixXd Phi = MatrixXd::Zero(3 * n_v, n * n);
  for (Eigen::Index v = 0; v < n_v; ++v) {
    places.col(v) = x[static_cast<std::size_t>(v)];
    Phi.row(3 * v + 2) = lifts[static_cast<std::size_t>(v)];
  }
  for (std::size_t t = 0; t < facets.size(); ++t) corners.col(static_cast<Eigen::Index>(t)) = facets[t];
  auto mesh = std::make_shared<SurfaceMesh>(places, corners);
  mesh->set_shapes(Phi);
  return mesh;
}

// Two alike spheres of twice the radius and twice the E*: the same contact, half of the dent in either, which the nodes of one and
// the facets of the other share.
TEST(HertzContact, HasForceAreaAndPressureOfTwoElasticSpheres) {
  constexpr int n = 12;
  const double a = std::sqrt(kR * kDepth), p_0 = 2.0 * kE / std::numbers::pi * std::sqrt(kDepth / kR);
  const double k = 1000.0 * p_0 / kDepth, R = 2.0 * kR;
  const Quarter quarter(n, 1.2 * a);
  const Eigen::Index m = quarter.x.cols();
  const MatrixXd compliance = 0.5 * quarter.compliance;
  const double square = quarter.side * quarter.side;
  Eigen::Matrix3Xd x = quarter.x;
  x.row(2) = x.colwise().squaredNorm() / (2.0 * R);
  auto patch = std::make_shared<SurfacePatch>(x, Eigen::VectorXd::Constant(m, square));
  MatrixXd Phi = MatrixXd::Zero(3 * m, m);
  for (Eigen::Index j = 0; j < m; ++j) Phi(3 * j + 2, j) = 1.0;
  patch->set_shapes(Phi);
  const SurfaceContact contact("touch", {0, 1}, patch, {1, 0},
                               std::make_shared<SmoothedSurface>(facets_of(quarter, n, R)),
                               PressureLaw(k, 1.0, 0.0), {});

  Eigen::VectorXd u = Eigen::VectorXd::Zero(2 * m);
  const Eigen::VectorXd at_rest = u;
  const int touching = 1;
  Kinematics kin;
  kin.markers.resize(2);
  kin.markers[1].X_WP.p = Vector3d(0.0, 0.0, -kDepth);
  kin.bodies.resize(2);
  for (int b = 0; b < 2; ++b) {
    kin.bodies[static_cast<std::size_t>(b)].s = u.data() + b * m;
    kin.bodies[static_cast<std::size_t>(b)].s_dot = at_rest.data();
  }
  kin.own.root = &touching;
  MatrixXd C = MatrixXd::Zero(2 * m, 2 * m);
  C.topLeftCorner(m, m) = C.bottomRightCorner(m, m) = compliance;
  double change = 1.0;
  int iterations = 0;
  for (; change > 1e-10 * kDepth && iterations < 50; ++iterations) {
    Blocks blocks(m);
    contact.apply(kin, nullptr, blocks);
    contact.differentiate(kin, nullptr, blocks);
    const Eigen::VectorXd step =
        (MatrixXd::Identity(2 * m, 2 * m) - C * blocks.K).partialPivLu().solve(C * blocks.f - u);
    u += step;
    change = step.cwiseAbs().maxCoeff();
  }
  EXPECT_LT(iterations, 50);

  double values[9];
  contact.evaluate_outputs(kin, nullptr, values);
  const double F = 4.0 / 3.0 * kE * std::sqrt(kR) * std::pow(kDepth, 1.5), disc = std::numbers::pi * a * a;
  constexpr flexura::test::Reference hertz{"Hertz: two elastic spheres, by surface_contact with from_body",
                                           "squares of a tenth of the patch's radius"};
  flexura::test::expect_reference("force", "N", 4.0 * values[1], F, 0.03 * F, hertz);
  flexura::test::expect_reference("area", "m^2", 4.0 * values[6], disc, 0.03 * disc, hertz);
  flexura::test::expect_reference("greatest pressure", "Pa", values[7], p_0, 0.03 * p_0, hertz);
  // Both bear it.
  EXPECT_NEAR(u.head(m).sum(), -u.tail(m).sum(), 0.01 * u.head(m).sum());
}

}  // namespace
}  // namespace flexura::mbs::surfaces
