// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Stress modes of beam parts beside closed forms, for random sections, lengths, directions and end loads.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "reduce/file/beam_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/random/chance.hpp"

namespace flexura::properties {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using mbs::chance::Chance;
using superelement::Superelement;
constexpr double kPi = std::numbers::pi;

// A straight member from a to b, axes the columns of R, clamped at a, with a force and a moment (its axes) at b.
struct Cantilever {
  Superelement se;
  Matrix3d R;
  Vector3d a;
  double length;
  VectorXd u;  // of the loaded part
  Vector3d force, moment;

  // Of the section at x: N, V_y, V_z, T, M_y, M_z, by balance of the piece beyond.
  std::array<double, 6> resultants(double x) const {
    const double arm = length - x;
    return {force.x(),
            force.y(),
            force.z(),
            moment.x(),
            moment.y() - arm * force.z(),
            moment.z() + arm * force.y()};
  }
};

Cantilever loaded(Chance& chance, const test::Folder& folder, const std::string& section, Vector3d force,
                  Vector3d moment, const std::string& name) {
  Cantilever c{.se = {},
               .R = chance.rotation(),
               .a = chance.vector(1.0),
               .length = chance.between(0.5, 2.0),
               .u = {},
               .force = force,
               .moment = moment};
  const Vector3d b = c.a + c.length * c.R.col(0);
  const auto list = [](const Vector3d& v) {
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
  };
  const std::string text = fmt::format(
      "[material.m]\nyoung = \"210 GPa\"\npoisson = 0.3\ndensity = 7850\n[section.s]\n{}\n[node.a]\nposition "
      "= {}\n[node.b]\n"
      "position = {}\n[member.m]\nnodes = [\"a\", \"b\"]\ndirection = "
      "{}\n[interface.a]\n[interface.b]\n[mesh]\nelements = "
      "{}\n[modes]\ncount = {}\n[recovery]\nstress = true\nprecision = \"double\"\n",
      section, list(c.a), list(b), list(c.R.col(1)), 1 + chance.below(4), chance.below(4));
  c.se = reduce::reduce(reduce::read_beam_part(folder.write(name, text))).superelement;
  // u_b of b with a at rest: statics of the superelement, in which end loads are exact.
  VectorXd p(6);
  p << c.R * force, c.R * moment;
  c.u = VectorXd::Zero(c.se.n());
  const int first = c.se.interfaces[1].first_dof;
  c.u.segment<6>(first) = c.se.K_se.block<6, 6>(first, first).ldlt().solve(p);
  return c;
}

// (sigma_xx, tau_xy, tau_xz) in the member's axes at each stressed vertex, with x, y, z of it.
struct Stressed {
  double x, y, z;
  Matrix3d sigma;
};

std::vector<Stressed> stresses(const Cantilever& c) {
  const VectorXd s = c.se.stress->S * c.u;
  std::vector<Stressed> out;
  for (std::size_t k = 0; k < c.se.stress->vertices.size(); ++k) {
    const auto row = 6 * static_cast<Eigen::Index>(k);
    Matrix3d sigma;
    sigma << s(row), s(row + 3), s(row + 5), s(row + 3), s(row + 1), s(row + 4), s(row + 5), s(row + 4),
        s(row + 2);
    const Vector3d at =
        c.R.transpose() * (c.se.surface.vertices.row(c.se.stress->vertices[k]).transpose() - c.a);
    out.push_back({at.x(), at.y(), at.z(), c.R.transpose() * sigma * c.R});
  }
  return out;
}

double von_mises(const Matrix3d& s) {
  return std::sqrt(0.5 * (std::pow(s(0, 0) - s(1, 1), 2) + std::pow(s(1, 1) - s(2, 2), 2) +
                          std::pow(s(2, 2) - s(0, 0), 2)) +
                   3.0 * (s(0, 1) * s(0, 1) + s(1, 2) * s(1, 2) + s(0, 2) * s(0, 2)));
}

Vector3d random_load(Chance& chance, double size) {
  return {size * chance.between(-1.0, 1.0), size * chance.between(-1.0, 1.0),
          size * chance.between(-1.0, 1.0)};
}

// Round: sigma = N/A + z M_y/I - y M_z/I, the torsion T r/J around, shear (D. J. Jourawski) V y^2/(3 I) along it for a solid one.
TEST(BeamStresses, OfRoundSectionsAreTheClosedForms) {
  const test::Folder folder;
  for (int seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const double d = chance.between(0.01, 0.1);
    const Cantilever c = loaded(chance, folder, fmt::format("type = \"circle\"\ndiameter = {:.17g}", d),
                                random_load(chance, 1e3), random_load(chance, 1e2), "part.toml");
    const double r = d / 2, A = kPi * r * r, I = kPi * std::pow(r, 4) / 4, J = 2 * I;
    const auto all = stresses(c);
    ASSERT_GT(all.size(), 100U);
    double size = 0.0;
    for (const Stressed& s : all) size = std::max(size, s.sigma.norm());
    for (const Stressed& s : all) {
      const auto [N, V_y, V_z, T, M_y, M_z] = c.resultants(s.x);
      const double sigma = N / A + s.z * M_y / I - s.y * M_z / I,
                   tau_xy = -T * s.z / J + V_y * s.z * s.z / (3 * I) - V_z * s.y * s.z / (3 * I),
                   tau_xz = T * s.y / J + V_z * s.y * s.y / (3 * I) - V_y * s.y * s.z / (3 * I);
      // Digits of the surface's vertices and of the statics.
      EXPECT_NEAR(s.sigma(0, 0), sigma, 1e-7 * size);
      EXPECT_NEAR(s.sigma(0, 1), tau_xy, 1e-7 * size);
      EXPECT_NEAR(s.sigma(0, 2), tau_xz, 1e-7 * size);
      EXPECT_NEAR(s.sigma(1, 1), 0.0, 1e-7 * size);
      EXPECT_NEAR(s.sigma(1, 2), 0.0, 1e-7 * size);
      EXPECT_NEAR(von_mises(s.sigma), std::sqrt(sigma * sigma + 3 * (tau_xy * tau_xy + tau_xz * tau_xz)),
                  1e-6 * size);
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Thin tubes: Bredt's T/(2 A_m t) and V sin/(pi r t) around, to the order of t/r.
TEST(BeamStresses, OfThinTubesAreThoseOfShearFlow) {
  const test::Folder folder;
  for (int seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const double r = chance.between(0.02, 0.1), t = chance.between(0.001, 0.02) * r;
    const Cantilever c =
        loaded(chance, folder,
               fmt::format("type = \"hollow_circle\"\nouter_diameter = {:.17g}\ninner_diameter = {:.17g}",
                           2 * r + t, 2 * r - t),
               random_load(chance, 1e3), random_load(chance, 1e2), "part.toml");
    double size = 0.0;
    const auto all = stresses(c);
    for (const Stressed& s : all) size = std::max(size, s.sigma.norm());
    const auto [N, V_y, V_z, T, M_y, M_z] = c.resultants(0.0);
    const double shear =
        std::abs(T) / (2 * kPi * r * r * t) + (std::abs(V_y) + std::abs(V_z)) / (kPi * r * t);
    for (const Stressed& s : all) {
      const double angle = std::atan2(s.z, s.y),
                   around = T / (2 * kPi * r * r * t) +
                            (V_z * std::cos(angle) - V_y * std::sin(angle)) / (kPi * r * t);
      EXPECT_NEAR(-s.sigma(0, 1) * std::sin(angle) + s.sigma(0, 2) * std::cos(angle), around,
                  2.0 * t / r * shear);
      EXPECT_NEAR(s.sigma(0, 1) * std::cos(angle) + s.sigma(0, 2) * std::sin(angle), 0.0, 1e-7 * size);
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Rectangles: the greatest torsion stress, in the middle of the long side, by the table k_2 of Timoshenko and Goodier (art. 109,
// three digits), V 3/(2 A) in the middle of the height, none at corners.
TEST(BeamStresses, OfRectanglesAreSaintVenants) {
  const test::Folder folder;
  static constexpr std::array<double, 2> table[] = {{1.0, 0.208}, {1.2, 0.219}, {1.5, 0.231},
                                                    {2.0, 0.246}, {3.0, 0.267}, {10.0, 0.312}};
  for (int seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const auto [ratio, k_2] = chance.one_of(table);
    const double w = chance.between(0.005, 0.05), h = ratio * w;
    const std::string section = fmt::format("type = \"rectangle\"\nwidth = {:.17g}\nheight = {:.17g}", w, h);
    const double T = chance.between(-100.0, 100.0), V = chance.between(-1e3, 1e3);
    const Cantilever twisted = loaded(chance, folder, section, Vector3d::Zero(), {T, 0, 0}, "part.toml");
    double greatest = 0.0;
    for (const Stressed& s : stresses(twisted)) {
      greatest = std::max(greatest, std::hypot(s.sigma(0, 1), s.sigma(0, 2)));
      const bool corner =
          std::abs(std::abs(s.y) - w / 2) < 1e-6 * w && std::abs(std::abs(s.z) - h / 2) < 1e-6 * h;
      if (corner) EXPECT_NEAR(s.sigma.norm(), 0.0, 1e-6 * std::abs(T) / (w * w * h));
      if (std::abs(s.y - w / 2) < 1e-6 * w && std::abs(s.z) < 1e-6 * h)
        EXPECT_GT(s.sigma(0, 2) * T, 0.0);  // turns from y to z
    }
    EXPECT_NEAR(greatest, std::abs(T) / (k_2 * w * w * h), 0.6e-3 / k_2 * greatest);
    const Cantilever bent = loaded(chance, folder, section, {0, 0, V}, Vector3d::Zero(), "part.toml");
    for (const Stressed& s : stresses(bent)) {
      const bool side =
          std::abs(std::abs(s.y) - w / 2) < 1e-6 * w && std::abs(std::abs(s.z) - h / 2) > 1e-6 * h;
      const double tau = side ? 1.5 * V / (w * h) * (1.0 - std::pow(2 * s.z / h, 2)) : 0.0;
      EXPECT_NEAR(s.sigma(0, 2), tau, 1e-6 * std::abs(V) / (w * h) * (1.0 + bent.length / h));
      EXPECT_NEAR(s.sigma(0, 0), -V * (bent.length - s.x) * s.z / (w * h * h * h / 12),
                  1e-6 * std::abs(V) * bent.length / (w * h * h));
    }
    if (testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace flexura::properties
