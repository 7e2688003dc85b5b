// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <random>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/beam_superelement.hpp"

/// Superelements of beams that a mechanism file states: 200 random ones against what a rigid body, Castigliano and Bernoulli say
/// of them.
namespace flexura::mbs {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Draw {
  std::mt19937 engine;
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double decade(double a, double b) { return std::pow(10.0, uniform(a, b)); }
  Vector3d vector() { return {uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)}; }
};

BeamPart random_part(Draw& r) {
  BeamPart part;
  part.from_B = r.vector();
  part.to_B = part.from_B + r.decade(-1, 1) * r.vector().normalized();
  part.y_axis_B = r.vector();
  part.elements = static_cast<int>(r.uniform(1, 24));
  const double L = part.length(), d = L * r.decade(-2, -0.7), E = r.decade(9, 11.5), rho = r.decade(3, 4);
  const double A = d * d, I = std::pow(d, 4) / 12.0;
  part.C =
      Vector6d(E * A, 0.3 * E * A, 0.25 * E * A, 0.6 * E * I, E * I * r.uniform(0.2, 3), E * I).asDiagonal();
  // Sections may couple: bending with torsion, stretch with bending.
  for (const auto& [i, j] : {std::pair{3, 4}, std::pair{0, 5}, std::pair{4, 5}})
    part.C(i, j) = part.C(j, i) = r.uniform(-0.5, 0.5) * std::sqrt(part.C(i, i) * part.C(j, j));
  part.mass_per_length = rho * A;
  part.rho_I_y = rho * I * r.uniform(0.5, 2);
  part.rho_I_z = rho * I;
  part.m_y = rho * A * d * r.uniform(-0.1, 0.1);
  part.m_z = rho * A * d * r.uniform(-0.1, 0.1);
  for (int k = static_cast<int>(r.uniform(0, 4)); k > 0; --k)
    part.points.emplace_back("p" + std::to_string(k), L * std::clamp(r.uniform(-0.2, 1.2), 0.0, 1.0));
  return part;
}

// Of the tip against the root, in the beam's axes: the integral of B^T f B, B the resultants of unit loads at the tip; two Gauss
// points are exact.
Matrix6d tip_compliance(const BeamPart& part) {
  const Matrix6d f = part.C.inverse();
  const double L = part.length();
  Matrix6d out = Matrix6d::Zero();
  for (const double g : {-1.0 / std::sqrt(3.0), 1.0 / std::sqrt(3.0)}) {
    const double lever = 0.5 * L * (1.0 - g);
    Matrix6d B = Matrix6d::Identity();
    B(4, 2) = -lever;
    B(5, 1) = lever;
    out += 0.5 * L * B.transpose() * f * B;
  }
  return out;
}

TEST(BeamSuperelement, IsTheBeamItIsMadeOf) {
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Draw r{std::mt19937(static_cast<unsigned>(seed))};
    const BeamPart part = random_part(r);
    const auto se = beam_superelement(part, static_cast<int>(r.uniform(6, 60)));
    ASSERT_NO_THROW(superelement::validate(*se));
    // Round-off of lengths up to ten in sums of 20 elements.
    const RigidInertia rigid = rigid_inertia(part);
    EXPECT_NEAR(se->inertia.mass, rigid.mass, 1e-12 * rigid.mass);
    EXPECT_LT((se->inertia.S_x - rigid.mass_center).norm(), 1e-11 * (rigid.mass_center.norm() + rigid.mass));
    const Matrix3d I = se->inertia.S_xx.trace() * Matrix3d::Identity() - se->inertia.S_xx;
    EXPECT_LT((I - rigid.inertia).norm(), 1e-11 * rigid.inertia.norm());
    ASSERT_EQ(se->interfaces.size(), part.stations().size());
    for (std::size_t i = 0; i < se->interfaces.size(); ++i) {
      EXPECT_EQ(se->interfaces[i].name, part.stations()[i].first);
      EXPECT_LT((se->interfaces[i].p_BoN_B - part.stations()[i].second).norm(), 1e-12 * part.length());
    }
    // Held at the root.  Stretch against bending of slender beams: 1e8 of the condition.
    const int tip = se->interfaces[1].first_dof, n = se->n();
    MatrixXd K = se->K_se.bottomRightCorner(n - 6, n - 6);
    const VectorXd scale = K.diagonal().cwiseSqrt().cwiseInverse();
    const MatrixXd scaled = scale.asDiagonal() * K * scale.asDiagonal();
    MatrixXd load = MatrixXd::Zero(n - 6, 6);
    load.middleRows<6>(tip - 6).setIdentity();
    const MatrixXd u =
        scale.asDiagonal() * Eigen::LDLT<MatrixXd>(scaled).solve(MatrixXd(scale.asDiagonal() * load));
    Matrix6d R = Matrix6d::Zero();
    R.topLeftCorner<3, 3>() = R.bottomRightCorner<3, 3>() = part.R_BE();
    const Matrix6d got = R.transpose() * u.middleRows<6>(tip - 6) * R, wanted = tip_compliance(part);
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        EXPECT_NEAR(got(i, j), wanted(i, j), 1e-7 * std::sqrt(wanted(i, i) * wanted(j, j))) << i << " " << j;
    // The modes kept are those of the shapes.
    EXPECT_LT((se->K_se.bottomRightCorner(se->n_q, se->n_q).diagonal() - se->omega2).norm(),
              1e-6 * se->omega2.norm());
  }
}

TEST(BeamSuperelement, VibratesAsBernoulliSays) {
  // Free, of a slender beam: beta L = 4.73004, 7.85320, 10.99561 (shear and rotary inertia take 1.2e-3 of the third, across its width).
  BeamPart part;
  part.from_B = Vector3d(0.3, -0.2, 0.1);
  part.to_B = part.from_B + 2.0 * Vector3d(0.36, 0.48, 0.8);
  const double E = 70e9, b = 0.012, h = 0.003, rho = 2700.0;
  part.C = Vector6d(E * b * h, 0.3 * E * b * h, 0.3 * E * b * h, 0.2 * E * b * h * h * h,
                    E * b * h * h * h / 12.0, E * h * b * b * b / 12.0)
               .asDiagonal();
  part.mass_per_length = rho * b * h;
  part.rho_I_y = rho * b * h * h * h / 12.0;
  part.rho_I_z = rho * h * b * b * b / 12.0;
  const ModalBody body(*beam_superelement(part));
  for (const double EI : {part.C(4, 4), part.C(5, 5)})
    for (const double beta : {4.730041, 7.853205, 10.995608}) {
      const double wanted = std::pow(beta / part.length(), 4) * EI / part.mass_per_length;
      const VectorXd& omega2 = body.data().stiffness;
      EXPECT_LT((omega2.array() / wanted - 1.0).abs().minCoeff(), 2e-3) << beta;
    }
}

TEST(BeamSuperelement, StiffensAsItTurns) {
  // Flapping of a cantilever about its root, omega sqrt(m L^4 / EI): A. D. Wright et al., J. Appl. Mech. 49 (1982) 197, table 1.
  BeamPart part;
  part.to_B = Vector3d(2.0, 0, 0);
  const double L = 2.0, EI = 5.0, m = 0.3;
  part.C = Vector6d(1e7, 1e7, 1e7, 50.0, EI, 100.0 * EI).asDiagonal();
  part.mass_per_length = m;
  part.rho_I_y = part.rho_I_z = 1e-9;
  const auto se = beam_superelement(part);
  const int n = se->n();
  for (const auto& [speed, wanted] :
       {std::pair{0.0, 3.5160}, std::pair{2.0, 4.1373}, std::pair{6.0, 7.3604}, std::pair{12.0, 13.1702}}) {
    const double Omega = speed * std::sqrt(EI / m) / (L * L);
    // About z, and w alone: what the spin takes away acts in its plane.
    const MatrixXd K = se->K_se + Omega * Omega * se->stiffening->K0omega[2];
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(K.bottomRightCorner(n - 6, n - 6),
                                                                   se->M_se.bottomRightCorner(n - 6, n - 6),
                                                                   Eigen::EigenvaluesOnly | Eigen::Ax_lBx);
    EXPECT_NEAR(std::sqrt(modes.eigenvalues()(0) * m / EI) * L * L, wanted, 2e-4 * wanted) << speed;
  }
  // A pull at the tip: of a string, omega = pi/L sqrt(N/m) held at both ends, where bending is little.
  const double N = 1e4;
  const MatrixXd K = se->K_se + N * se->stiffening->K0F[6];
  const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> modes(K.bottomRightCorner(se->n_q, se->n_q),
                                                                 se->M_se.bottomRightCorner(se->n_q, se->n_q),
                                                                 Eigen::EigenvaluesOnly | Eigen::Ax_lBx);
  // Clamped ends shorten it by sqrt(EI / N) = 0.022 m each.
  const double length = L - 2.0 * std::sqrt(EI / N);
  EXPECT_NEAR(std::sqrt(modes.eigenvalues()(0)), std::numbers::pi / length * std::sqrt(N / m), 2e-2 * 287.0);
}

}  // namespace
}  // namespace flexura::mbs
