// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <random>

#include "beam/ancf/element/ancf_element.hpp"
#include "beam/ancf/element/hermite.hpp"
#include "tests/beam/ancf/samples.hpp"

namespace flexura::beam::ancf {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd random_vector(int n, double size, std::mt19937& source) {
  std::uniform_real_distribution<double> uniform(-size, size);
  VectorXd v(n);
  for (double& x : v) x = uniform(source);
  return v;
}

struct Evaluation {
  VectorXd f;
  MatrixXd K, D;
};

Evaluation evaluate(const Element& element, const VectorXd& e, const VectorXd& e_dot) {
  const int n = element.n();
  Evaluation out{VectorXd::Zero(n), MatrixXd::Zero(n, n), MatrixXd::Zero(n, n)};
  element.add_force(e.data(), e_dot.data(), nullptr, out.f.data(), out.K.data(), out.D.data());
  return out;
}

// Central differences of step h on functions of third derivative F3: error h^2 F3 / 6 + eps |f| / h.  With
// h = 1e-5, coordinates, stiffness and rates of order 1 to 100 here: 1e-10 * 1e3 / 6 and 1e-16 * 1e2 / 1e-5,
// so 1e-7 (relative to the largest entry) holds a margin of ten.
constexpr double kStep = 1e-5, kDifferenceTolerance = 1e-7;

TEST(AncfElement, ElasticForceIsEnergyGradient) {
  std::mt19937 source(1);
  for (const auto& [name, element, rest] : all_elements()) {
    const VectorXd e = rest + random_vector(element->n(), 0.15, source);
    const VectorXd still = VectorXd::Zero(element->n());
    const auto at = evaluate(*element, e, still);
    VectorXd gradient(element->n());
    for (int i = 0; i < element->n(); ++i) {
      VectorXd plus = e, minus = e;
      plus[i] += kStep;
      minus[i] -= kStep;
      gradient[i] =
          (element->strain_energy(plus.data()) - element->strain_energy(minus.data())) / (2 * kStep);
    }
    EXPECT_LT((gradient - at.f).cwiseAbs().maxCoeff(), kDifferenceTolerance * at.f.cwiseAbs().maxCoeff())
        << name;
  }
}

TEST(AncfElement, TangentsAreForceGradients) {
  std::mt19937 source(2);
  for (const auto& [name, element, rest] : all_elements()) {
    const int n = element->n();
    const VectorXd e = rest + random_vector(n, 0.15, source), e_dot = random_vector(n, 1.0, source);
    const auto at = evaluate(*element, e, e_dot);
    MatrixXd K(n, n), D(n, n);
    for (int i = 0; i < n; ++i) {
      const VectorXd step = kStep * VectorXd::Unit(n, i);
      K.col(i) =
          (evaluate(*element, e + step, e_dot).f - evaluate(*element, e - step, e_dot).f) / (2 * kStep);
      D.col(i) =
          (evaluate(*element, e, e_dot + step).f - evaluate(*element, e, e_dot - step).f) / (2 * kStep);
    }
    EXPECT_LT((K - at.K).cwiseAbs().maxCoeff(), kDifferenceTolerance * at.K.cwiseAbs().maxCoeff()) << name;
    EXPECT_LT((D - at.D).cwiseAbs().maxCoeff(), kDifferenceTolerance * at.D.cwiseAbs().maxCoeff()) << name;
    EXPECT_GT(D.cwiseAbs().maxCoeff(), 0.1) << name << ": the sample must be damped";
  }
}

TEST(AncfElement, DissipationIsPowerOfTheViscousForceAndNotNegative) {
  std::mt19937 source(3);
  for (const auto& [name, element, rest] : all_elements()) {
    const int n = element->n();
    const VectorXd e = rest + random_vector(n, 0.1, source), e_dot = random_vector(n, 1.0, source);
    const VectorXd viscous = evaluate(*element, e, e_dot).f - evaluate(*element, e, VectorXd::Zero(n)).f;
    const double power = element->dissipation(e.data(), e_dot.data());
    EXPECT_GT(power, 0.0) << name;
    // Two sums of some 100 products each: 1e-13 is a few hundred round-offs.
    EXPECT_NEAR(viscous.dot(e_dot), power, 1e-13 * viscous.cwiseAbs().dot(e_dot.cwiseAbs())) << name;
  }
}

// r -> c + R r on positions, slopes -> R slopes.
VectorXd moved(const Element& element, const VectorXd& e, const MatrixXd& R, const VectorXd& c) {
  VectorXd out(e.size());
  const int d = element.dim();
  for (int i = 0; i < e.size() / d; ++i) {
    out.segment(d * i, d) = R * e.segment(d * i, d);
    if (i % element.vectors() == 0) out.segment(d * i, d) += c;
  }
  return out;
}

MatrixXd some_rotation(int dim) {
  if (dim == 2) return Eigen::Rotation2Dd(2.3).toRotationMatrix();
  return Eigen::AngleAxisd(2.3, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
}

TEST(AncfElement, RigidMotionGivesNoForce) {
  for (const auto& [name, element, rest] : all_elements()) {
    const int d = element->dim(), n = element->n();
    const VectorXd c = VectorXd::Constant(d, 3.0);
    const VectorXd e = moved(*element, rest, some_rotation(d), c);
    MatrixXd spin = MatrixXd::Zero(d, d);
    spin.topLeftCorner(2, 2) << 0, -4, 4, 0;
    if (d == 3) {
      spin(0, 2) = 1.5;
      spin(2, 0) = -1.5;
    }
    const VectorXd e_dot = moved(*element, e, spin, VectorXd::Constant(d, -1.0));
    const auto at = evaluate(*element, e, e_dot);
    // Round-off: coordinates of size 5 enter with eps, times stiffness (viscous: times spin and relaxation
    // time, < 1).
    EXPECT_LT(at.f.cwiseAbs().maxCoeff(), 40 * 2.2e-16 * 5 * at.K.cwiseAbs().maxCoeff()) << name;
    EXPECT_LT(element->strain_energy(e.data()), 1e-25 * at.K.cwiseAbs().maxCoeff()) << name;
    EXPECT_EQ(n, e.size());
  }
}

TEST(AncfElement, ForceTurnsWithTheElement) {
  std::mt19937 source(4);
  for (const auto& [name, element, rest] : all_elements()) {
    const int d = element->dim(), n = element->n();
    const VectorXd e = rest + random_vector(n, 0.1, source), e_dot = random_vector(n, 1.0, source);
    const MatrixXd R = some_rotation(d);
    const VectorXd zero = VectorXd::Zero(d);
    const VectorXd f = evaluate(*element, e, e_dot).f;
    const VectorXd turned =
        evaluate(*element, moved(*element, e, R, zero), moved(*element, e_dot, R, zero)).f;
    // Round-off of sums whose terms are up to ten times the result.
    EXPECT_LT((turned - moved(*element, f, R, zero)).norm(), 1e-13 * f.norm()) << name;
  }
}

TEST(AncfElement, InternalForcesHaveNeitherResultantNorMoment) {
  // With damping too; the moment of generalised forces is the sum of e_i x f_i over positions and slopes.
  std::mt19937 source(5);
  for (const auto& [name, element, rest] : all_elements()) {
    const int d = element->dim(), n = element->n();
    VectorXd e = rest + random_vector(n, 0.1, source), e_dot = random_vector(n, 1.0, source);
    // The damping of a spatial line is objective but for spin about its tangent (CableStrain): plane motion.
    if (name == "spatial line")
      for (int i = 2; i < n; i += 3) e[i] = e_dot[i] = 0.0;
    const VectorXd f = evaluate(*element, e, e_dot).f;
    Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
    for (int i = 0; i < n / d; ++i) {
      Eigen::Vector3d at = Eigen::Vector3d::Zero(), f_i = Eigen::Vector3d::Zero();
      at.head(d) = e.segment(d * i, d);
      f_i.head(d) = f.segment(d * i, d);
      if (i % element->vectors() == 0) force += f_i;
      moment += at.cross(f_i);
    }
    EXPECT_LT(force.norm(), 1e-14 * f.norm() * n) << name;
    EXPECT_LT(moment.norm(), 1e-14 * f.norm() * n) << name;
  }
}

TEST(AncfElement, UndampedSpatialLineHasNoMoment) {
  std::mt19937 source(6);
  const auto samples = all_elements();
  const auto& [name, element, rest] = samples[1];
  const VectorXd e = rest + random_vector(12, 0.1, source), still = VectorXd::Zero(12);
  const VectorXd f = evaluate(*element, e, still).f;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int i = 0; i < 4; ++i)
    moment += Eigen::Vector3d(e.segment(3 * i, 3)).cross(Eigen::Vector3d(f.segment(3 * i, 3)));
  EXPECT_LT(moment.norm(), 1e-14 * f.norm() * 12);
}

TEST(AncfElement, HasOnlyRigidMotionsWithoutStiffness) {
  for (const auto& [name, element, rest] : all_elements()) {
    const VectorXd still = VectorXd::Zero(element->n());
    const auto at = evaluate(*element, rest, still);
    const VectorXd values = Eigen::SelfAdjointEigenSolver<MatrixXd>(at.K).eigenvalues();
    // A straight spatial line does not feel a spin about itself: e does not even change.
    const int rigid = element->dim() == 2 ? 3 : name == "spatial line" ? 5 : 6;
    const double largest = values[values.size() - 1];
    for (int i = 0; i < rigid; ++i) EXPECT_LT(std::abs(values[i]), 1e-13 * largest) << name << " " << i;
    // The softest deformation is a bending of order EI/l against the stiffest, slopes in r_x: within 1e-4.
    EXPECT_GT(values[rigid], 1e-4 * largest) << name;
  }
}

TEST(AncfElement, MassMatrixSumsToMassAndInertia) {
  // A straight beam along x of mass m l: rigid translation and rotation about y through the start,
  // e_dot = (0, 0, -x) etc.; J_y = m l^3/3 + int z^2 dm l.
  const double l = 0.8;
  BeamSection section = uncoupled_section(1, 1, 1, 1, 1, 1, 2.0, 0.05, 0.07);
  const auto e_0 = beam_coordinates(l, 0.0);
  const auto element = make_spatial_beam(section, l, e_0.data());
  const MatrixXd& m = element->compact_mass();
  VectorXd ones = VectorXd::Zero(8), x = VectorXd::Zero(8), z = VectorXd::Zero(8);
  ones[0] = ones[4] = 1;
  x << 0, 1, 0, 0, l, 1, 0, 0;
  z[3] = z[7] = 1;
  // Polynomials are integrated exactly: round-off of 64 terms.
  EXPECT_NEAR(ones.dot(m * ones), 2.0 * l, 1e-14);
  EXPECT_NEAR(x.dot(m * x) + z.dot(m * z), 2.0 * l * l * l / 3 + 0.05 * l, 1e-14);
  EXPECT_NEAR(element->compact_weight().dot(ones), 2.0 * l, 1e-14);
  EXPECT_NEAR(element->compact_weight().dot(x), 2.0 * l * l / 2, 1e-14);
}

TEST(AncfElement, RefusesImpossibleConstants) {
  using testing::HasSubstr;
  using testing::ThrowsMessage;
  const LineSection weightless{.EA = 1.0, .EI = 1.0, .mass_per_length = 0.0};
  EXPECT_THAT([&] { make_spatial_line(weightless, 1.0); },
              ThrowsMessage<std::invalid_argument>(
                  HasSubstr("mass per length [kg/m] is 0, but it must be positive")));
  const auto e_0 = beam_coordinates(1.0, 0.0);
  BeamSection rigid = uncoupled_section(1, std::numeric_limits<double>::infinity(), 1, 1, 1, 1, 1, 1, 1);
  EXPECT_THAT([&] { make_spatial_beam(rigid, 1.0, e_0.data()); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("finite shear")));
  SolidSection rubber{.E = 1, .nu = 0.5, .rho = 1, .width = 1, .height = 1};
  EXPECT_THAT([&] { make_solid_beam(rubber, 1.0, e_0.data()); },
              ThrowsMessage<std::invalid_argument>(HasSubstr("0.5")));
  EXPECT_THAT([] { gauss_rule(9); }, ThrowsMessage<std::invalid_argument>(HasSubstr("1 to 5")));
}

TEST(AncfElement, GaussRulesIntegrateTheirDegreeExactly) {
  for (int n = 1; n <= 5; ++n)
    for (int degree = 0; degree <= 2 * n - 1; ++degree) {
      double sum = 0.0;
      for (const auto& q : gauss_rule(n)) sum += q.weight * std::pow(q.xi, degree);
      EXPECT_NEAR(sum, 1.0 / (degree + 1), 1e-15) << n << " points, degree " << degree;
    }
}

}  // namespace
}  // namespace flexura::beam::ancf
