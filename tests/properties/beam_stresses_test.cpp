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

// Thickness of a tube between ellipses whose half axes are t/2 more and less than a, b: at the parameter `angle` the contours stand
// (t cos, t sin) apart, taken along the normal.
double thickness_of(double a, double b, double t, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return t * (b * c * c + a * s * s) / std::hypot(a * s, b * c);
}

// Its shear flow, V_z Q_y / I_y - V_y Q_z / I_z with Q from the axis of the force to `angle`; by sums.
double flow_of(double a, double b, double t, double V_y, double V_z, double angle) {
  constexpr int n = 200;  // of smooth functions: 1e-5
  double I_y = 0.0, I_z = 0.0, Q_y = 0.0, Q_z = 0.0;
  const auto over = [&](double from, double to, const auto& add) {
    for (int k = 0; k < n; ++k) {
      const double phi = from + (to - from) * (k + 0.5) / n, y = a * std::cos(phi), z = b * std::sin(phi);
      add(y, z,
          thickness_of(a, b, t, phi) * std::hypot(a * std::sin(phi), b * std::cos(phi)) * (to - from) / n);
    }
  };
  over(0.0, 2 * kPi, [&](double y, double z, double dA) { I_y += z * z * dA, I_z += y * y * dA; });
  over(angle, kPi / 2, [&](double, double z, double dA) { Q_y += z * dA; });
  over(0.0, angle, [&](double y, double, double dA) { Q_z += y * dA; });
  return V_z * Q_y / I_y - V_y * Q_z / I_z;
}

// Thin elliptic tubes, round ones among them: Bredt's T/(2 A_m t) and the flow of shear forces around, to the order of the thickness
// over the least radius of curvature.
TEST(BeamStresses, OfThinTubesAreThoseOfShearFlow) {
  const test::Folder folder;
  for (int seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const bool round = chance.flip(0.3);
    const double a = chance.between(0.02, 0.1), b = round ? a : a * chance.between(0.5, 2.0),
                 least = std::min(a * a / b, b * b / a), t = chance.between(0.001, 0.02) * least;
    const Cantilever c = loaded(
        chance, folder,
        round ? fmt::format("type = \"hollow_circle\"\nouter_diameter = {:.17g}\ninner_diameter = {:.17g}",
                            2 * a + t, 2 * a - t)
              : fmt::format("type = \"hollow_ellipse\"\nwidth = {:.17g}\nheight = {:.17g}\ninner_width = "
                            "{:.17g}\ninner_height = {:.17g}",
                            2 * a + t, 2 * b + t, 2 * a - t, 2 * b - t),
        random_load(chance, 1e3), random_load(chance, 1e2), "part.toml");
    double size = 0.0;
    const auto all = stresses(c);
    for (const Stressed& s : all) size = std::max(size, s.sigma.norm());
    const auto [N, V_y, V_z, T, M_y, M_z] = c.resultants(0.0);
    const double flow = T / (2 * kPi * a * b),
                 shear = std::abs(flow / t) + (std::abs(V_y) + std::abs(V_z)) / (std::min(a, b) * t);
    for (const Stressed& s : all) {
      const double angle = std::atan2(s.z / b, s.y / a);
      const Eigen::Vector2d along = Eigen::Vector2d(-a * std::sin(angle), b * std::cos(angle)).normalized();
      EXPECT_NEAR(s.sigma(0, 1) * along.x() + s.sigma(0, 2) * along.y(),
                  (flow + flow_of(a, b, t, V_y, V_z, angle)) / thickness_of(a, b, t, angle),
                  2.0 * t / least * shear);
      EXPECT_NEAR(s.sigma(0, 1) * along.y() - s.sigma(0, 2) * along.x(), 0.0,
                  1e-7 * size + (round ? 0.0 : 2.0 * t / least * shear));
    }
    if (testing::Test::HasFailure()) return;
  }
}

// Thin boxes: Bredt's T/(2 A_m t); V_z w_m h_m f/(4 I web) + (h_m^2/4 - z^2) V_z/(2 I) in the webs, -V_z y z/I in the flanges, and V_y the
// other way about; to the order of the thickness over the least side.
TEST(BeamStresses, OfThinBoxesAreThoseOfShearFlow) {
  const test::Folder folder;
  for (int seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    Chance chance(static_cast<std::uint64_t>(seed));
    const double w = chance.between(0.02, 0.1), h = w * chance.between(0.5, 2.0), least = std::min(w, h),
                 web = chance.between(0.002, 0.02) * least, flange = web * chance.between(0.5, 2.0);
    const Cantilever c = loaded(
        chance, folder,
        fmt::format("type = \"hollow_rectangle\"\nwidth = {:.17g}\nheight = {:.17g}\nweb = {:.17g}\nflange = "
                    "{:.17g}",
                    w + web, h + flange, web, flange),
        random_load(chance, 1e3), random_load(chance, 1e2), "part.toml");
    const auto [N, V_y, V_z, T, M_y, M_z] = c.resultants(0.0);
    const double I_y = flange * w * h * h / 2 + web * h * h * h / 6,
                 I_z = web * h * w * w / 2 + flange * w * w * w / 6, thin = std::min(web, flange),
                 shear = std::abs(T) / (2 * w * h * thin) + (std::abs(V_y) + std::abs(V_z)) / (least * thin);
    int n_webs = 0, n_flanges = 0;
    for (const Stressed& s : stresses(c)) {
      const bool beside = std::abs(s.y) > 0.5 * w - web, above = std::abs(s.z) > 0.5 * h - flange;
      if (beside == above) continue;  // where walls meet
      const double side = beside ? std::copysign(1.0, s.y) : -std::copysign(1.0, s.z),
                   y = beside ? std::copysign(0.5 * w, s.y) : s.y,
                   z = beside ? s.z : std::copysign(0.5 * h, s.z);
      const double tau =
          beside ? side * T / (2 * w * h * web) +
                       V_z / I_y * (w * h * flange / (4 * web) + (h * h / 4 - z * z) / 2) - V_y * y * z / I_z
                 : side * T / (2 * w * h * flange) +
                       V_y / I_z * (w * h * web / (4 * flange) + (w * w / 4 - y * y) / 2) - V_z * y * z / I_y;
      EXPECT_NEAR(s.sigma(0, beside ? 2 : 1), tau, 4.0 * std::max(web, flange) / least * shear);
      EXPECT_NEAR(s.sigma(0, beside ? 1 : 2), 0.0, 1e-6 * shear);
      ++(beside ? n_webs : n_flanges);
    }
    EXPECT_GT(n_webs, 10);
    EXPECT_GT(n_flanges, 10);
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
