// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "reduce/cms/craig_bampton.hpp"
#include "reduce/linalg/dense/dense.hpp"
#include "reduce/recovery/stress.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

using namespace testing;
using std::numbers::pi;

constexpr double kLength = 1.0, kWidth = 0.05, kE = 2.1e11, kRho = 7850.0;

Reduction slender_beam(Tie right = Tie::rigid) {
  Part part = beam({kLength, kWidth, kWidth}, {10, 1, 1}, mesh::CellType::hex20, Tie::rigid, right);
  // Without lateral contraction a rigid end face does not stiffen the root (with nu = 0.3 it does, by one per
  // cent).
  part.materials = {isotropic("no contraction", kE, 0.0, kRho)};
  ReductionOptions options;
  options.n_modes = 20;
  options.stiffening = true;
  return craig_bampton(part, options);
}

Eigen::MatrixXd held_at_the_left(const Eigen::MatrixXd& X) {
  return X.bottomRightCorner(X.rows() - 6, X.cols() - 6);
}

// The smallest P > 0 with det(K - P K_0) = 0: the largest eigenvalue 1 / P of K_0 x = (1 / P) K x.
double buckling_load(const Eigen::MatrixXd& K, const Eigen::MatrixXd& K_0) {
  return 1.0 / linalg::generalized_eigen(K_0, K).values.maxCoeff();
}

// Euler's column, clamped at one end, pushed at the other: P = pi^2 E I / (4 l^2).  Shear lowers it by
// P / (G A kappa) = pi^2 / 4 (h^2 / 12 l^2) E / (G kappa) = 0.12 %; a Ritz basis and ten cells leave less
// than that.
TEST(GeometricStiffening, AxialLoadBucklesTheColumnAtEulersLoad) {
  for (const Tie right : {Tie::rigid, Tie::average}) {
    const Reduction se = slender_beam(right);
    const double euler = pi * pi * kE * std::pow(kWidth, 4) / 12.0 / (4.0 * kLength * kLength);
    const double P = buckling_load(held_at_the_left(se.K_se), held_at_the_left(se.stiffening->K0F[6]));
    EXPECT_NEAR(P / euler, 1.0, 0.003);
  }
}

// Weight: a standing column under its own weight buckles when rho A g l^3 / (E I) = 7.8373 (Greenhill 1881).
// Unit acceleration of the frame along +x presses the body against the end that is held at x = 0.
TEST(GeometricStiffening, AccelerationBucklesTheColumnAtGreenhillsLength) {
  const Reduction se = slender_beam();
  const double EI = kE * std::pow(kWidth, 4) / 12.0, mass_per_length = kRho * kWidth * kWidth;
  const double a = buckling_load(held_at_the_left(se.K_se), -held_at_the_left(se.stiffening->K0t[0]));
  EXPECT_NEAR(a / (7.8373 * EI / (mass_per_length * std::pow(kLength, 3))), 1.0, 0.003);
}

// A cantilever along x that rotates about z through its root: out of the plane of rotation
// omega^2 = omega_0^2 + 1.193 Omega^2 for small Omega (Southwell's coefficient of the first mode is 1.1934
// for omega_0's own shape, an upper bound; Wright et al. 1982 give the same to three digits).
TEST(GeometricStiffening, SpinStiffensTheFlappingBladeBySouthwellsCoefficient) {
  const Reduction se = slender_beam();
  const Eigen::MatrixXd K = held_at_the_left(se.K_se), M = held_at_the_left(se.M_se),
                        K_0 = held_at_the_left(se.stiffening->K0omega[2]);
  const double omega0_squared = linalg::generalized_eigen(K, M).values(0);
  // The two bending modes have equal frequencies: both are stiffened alike by K_0 (softening by Omega^2 M in
  // the plane belongs to the floating frame's inertia terms, not to K_0).
  const double spin2 = 1e-3 * omega0_squared;
  const Eigen::VectorXd values = linalg::generalized_eigen(K + spin2 * K_0, M).values;
  for (int k = 0; k < 2; ++k) EXPECT_NEAR((values(k) - omega0_squared) / spin2, 1.193, 0.012);
}

// The rotating cantilever, slenderness L sqrt(A / I) = 70, mu = Omega sqrt(rho A L^4 / E I) (S. M.
// Hamza-Cherif, M. S. A. Houmat, ICAS 2004): first flapwise frequency in the same unit.  Chordwise the spin
// softens by Omega^2, which belongs to the frame's inertia terms: omega^2 = flapwise - mu^2 but for Coriolis
// coupling to stretch, which is below a per cent up to mu = 6.  1 % is the tolerance of the collection.
TEST(GeometricStiffening, RotatingCantileverHasThePublishedFrequencies) {
  const Reduction se = slender_beam();
  const Eigen::MatrixXd K = held_at_the_left(se.K_se), M = held_at_the_left(se.M_se),
                        K_0 = held_at_the_left(se.stiffening->K0omega[2]);
  const double unit = kE * kWidth * kWidth / 12.0 / (kRho * std::pow(kLength, 4));  // E I / (rho A L^4)
  const double mu[] = {2, 4, 6, 8, 10}, flapwise[] = {4.1373, 5.5850, 7.3603, 9.2568, 11.2023},
               chordwise[] = {3.6195, 3.888, 4.2393};
  for (int k = 0; k < 5; ++k) {
    const double lambda = linalg::generalized_eigen(K + mu[k] * mu[k] * unit * K_0, M).values(0) / unit;
    EXPECT_NEAR(std::sqrt(lambda) / flapwise[k], 1.0, 0.01) << "mu = " << mu[k];
    if (k < 3) {
      EXPECT_NEAR(std::sqrt(lambda - mu[k] * mu[k]) / chordwise[k], 1.0, 0.01) << "mu = " << mu[k];
    }
  }
}

// A pulled beam between two clamps sounds like a stiff string: near f_n = n / (2 L) sqrt(F / rho A), and with
// its bending exactly at the roots of 2 a b (1 - cos b cosh a) + (a^2 - b^2) sin b sinh a = 0, where a^2 -
// b^2 = F L^2 / (E I) and a b = omega L^2 sqrt(rho A / E I) (Euler and Bernoulli).
TEST(GeometricStiffening, PulledBeamSoundsLikeAStiffString) {
  const Reduction se = slender_beam();
  const double EI = kE * std::pow(kWidth, 4) / 12.0, rhoA = kRho * kWidth * kWidth;
  const double s = 0.05, F = EI / (s * s * kLength * kLength);    // 400 times the bending stiffness
  const Eigen::MatrixXd K = se.K_se + F * se.stiffening->K0F[6];  // pulled at the right, held at the left
  const Eigen::VectorXd values = linalg::generalized_eigen(K.bottomRightCorner(se.n_q, se.n_q),
                                                           Eigen::MatrixXd::Identity(se.n_q, se.n_q))
                                     .values;
  const auto equation = [&](double b) {  // over cosh a
    const double a = std::sqrt(b * b + 1.0 / (s * s));
    return 2.0 * a * b * (1.0 / std::cosh(a) - std::cos(b)) + (a * a - b * b) * std::sin(b) * std::tanh(a);
  };
  for (int n = 1; n <= 2; ++n) {
    double low = n * pi, high = (n + 0.5) * pi;
    ASSERT_LT(equation(low) * equation(high), 0.0);
    while (high - low > 1e-12) {
      const double middle = 0.5 * (low + high);
      (equation(low) * equation(middle) <= 0.0 ? high : low) = middle;
    }
    const double a = std::sqrt(low * low + 1.0 / (s * s));
    const double exact = a * low / (kLength * kLength) * std::sqrt(EI / rhoA) / (2.0 * pi);
    const double string = n / (2.0 * kLength) * std::sqrt(F / rhoA);
    // P. M. Morse, Vibration and Sound, section 16; what follows is of the size 2 s (n pi s)^2 + (2 s)^3.
    EXPECT_NEAR(exact / string, 1.0 + 2.0 * s + (4.0 + 0.5 * n * n * pi * pi) * s * s,
                (8.0 + 2.0 * n * n * pi * pi) * s * s * s)
        << "the stiff string's own formula";
    // The clamps' boundary layers are s L = half a cell long, shear and rotary inertia take 0.3 %.
    const double ours = std::sqrt(values(2 * n - 2)) / (2.0 * pi);  // two planes
    EXPECT_NEAR(ours / exact, 1.0, 0.01) << n;
  }
}

// K_G does no work on translations; neither do its reduced forms.
TEST(GeometricStiffening, TranslationsAreFree) {
  const Reduction se = slender_beam();
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(se.n(), 3);
  R.topRows(3).setIdentity();
  R.middleRows(6, 3).setIdentity();
  for (const Eigen::MatrixXd& K_0 :
       {se.stiffening->K0t[0], se.stiffening->K0r[1], se.stiffening->K0omega[3], se.stiffening->K0F[7]})
    EXPECT_LT((K_0 * R).norm(), 1e-10 * K_0.norm() * R.norm());
  EXPECT_EQ(se.stiffening->K0F[0].norm(), 0.0);  // the held interface
}

// The reactions of any statically determinate hold cancel in loads that balance: pulling both ends with F
// stresses the body like pulling one end while the other is held; so does the order of the interfaces.
TEST(GeometricStiffening, BalancedLoadsDoNotDependOnWhatIsHeld) {
  Part part = beam({kLength, kWidth, kWidth}, {6, 1, 1}, mesh::CellType::tet10, Tie::rigid, Tie::rigid);
  ReductionOptions options;
  options.n_modes = 4;
  options.stiffening = true;
  const Reduction left_held = craig_bampton(part, options);
  std::swap(part.interfaces[0], part.interfaces[1]);
  const Reduction right_held = craig_bampton(part, options);
  // Pull with +x at "right", -x at "left"; compare on the boundary, whose order is swapped.
  const Eigen::MatrixXd a = left_held.stiffening->K0F[6].topLeftCorner(12, 12);
  const Eigen::MatrixXd b = -right_held.stiffening->K0F[6].topLeftCorner(12, 12);
  Eigen::MatrixXd swap = Eigen::MatrixXd::Zero(12, 12);
  swap.topRightCorner(6, 6).setIdentity();
  swap.bottomLeftCorner(6, 6).setIdentity();
  EXPECT_LT((a - swap * b * swap).norm(), 1e-8 * a.norm());
}

// Uniform tension: stretching a bar whose ends may contract gives sigma_xx = E epsilon at every node.
TEST(StressModes, StretchedBarHasUniformStress) {
  Part part = beam({0.2, 0.05, 0.05}, {4, 2, 2}, mesh::CellType::tet10, Tie::rigid, Tie::rigid);
  Eigen::MatrixXd T(3 * part.mesh.n_nodes(), 2);
  for (mesh::Index a = 0; a < part.mesh.n_nodes(); ++a) {
    const Eigen::RowVector3d x = part.mesh.points.row(a);
    T.block<3, 1>(3 * a, 0) << x(0), -0.3 * x(1), -0.3 * x(2);
    T.block<3, 1>(3 * a, 1) << x(1), 0.0, 0.0;  // simple shear
  }
  const Eigen::MatrixXd stress = nodal_stress_modes(part, T, {0, 17, 40});
  const double G = kE / 2.6;
  for (int v = 0; v < 3; ++v) {
    Eigen::MatrixXd expected = Eigen::MatrixXd::Zero(6, 2);
    expected(0, 0) = kE;
    expected(3, 1) = G;
    EXPECT_LT((stress.middleRows(6 * v, 6) - expected).norm(),
              1e-10 * kE);  // gradients of a field of size 1 on cells of size 0.05
  }
}

}  // namespace
}  // namespace flexura::reduce
