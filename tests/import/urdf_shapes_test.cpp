// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Mass properties of shapes against integrals over slices, and robots that take them as the inertia of their links.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <functional>
#include <numbers>
#include <random>

#include "import/model/inertia.hpp"
#include "import/urdf/convert.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/import/kdl_tree.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Mass, m c and the integral of x x^T dm, density 1.
struct Moments {
  double mass = 0.0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();

  void add(const Moments& m, const Matrix3d& R, const Vector3d& p) {
    mass += m.mass;
    first += R * m.first + m.mass * p;
    const Vector3d f = R * m.first;
    second +=
        R * m.second * R.transpose() + f * p.transpose() + p * f.transpose() + m.mass * p * p.transpose();
  }
  Vector3d center() const { return first / mass; }
  Matrix3d inertia() const {
    const Matrix3d S = second - mass * center() * center().transpose();
    return S.trace() * Matrix3d::Identity() - S;
  }
};

// A body of revolution about z by Simpson's rule, each piece a profile whose r^4 is a polynomial of degree 4.
Moments turned(const std::function<double(double)>& radius, const std::vector<double>& ends) {
  Moments out;
  for (std::size_t piece = 0; piece + 1 < ends.size(); ++piece) {
    constexpr int n = 200;
    const double a = ends[piece], h = (ends[piece + 1] - a) / n;
    for (int k = 0; k <= n; ++k) {
      const double z = a + k * h, r = radius(z),
                   w = h / 3.0 *
                       (k == 0 || k == n ? 1.0
                        : k % 2 == 1     ? 4.0
                                         : 2.0),
                   area = std::numbers::pi * r * r;
      out.mass += w * area;
      out.first.z() += w * area * z;
      out.second.diagonal() += w * Vector3d(area * r * r / 4.0, area * r * r / 4.0, area * z * z);
    }
  }
  return out;
}

struct Drawn {
  std::string xml;
  Moments moments;
};

// A shape of the URDF, its size drawn.
Drawn draw_shape(const std::function<double(double, double)>& real, int kind) {
  const double r = real(0.02, 0.3), l = real(0.02, 0.6);
  const auto ball = [r](double z) { return std::sqrt(std::max(0.0, r * r - z * z)); };
  switch (kind) {
    case 0: {
      const Vector3d s(l, real(0.02, 0.6), r);
      Moments box{.mass = s.prod()};
      box.second.diagonal() = box.mass / 12.0 * s.array().square();
      return {fmt::format(R"(<box size="{:.17g} {:.17g} {:.17g}"/>)", s.x(), s.y(), s.z()), box};
    }
    case 1:
      return {fmt::format(R"(<cylinder radius="{:.17g}" length="{:.17g}"/>)", r, l),
              turned([r](double) { return r; }, {-0.5 * l, 0.5 * l})};
    case 2:
      return {fmt::format(R"(<sphere radius="{:.17g}"/>)", r), turned(ball, {-r, r})};
    default:
      return {fmt::format(R"(<capsule radius="{:.17g}" length="{:.17g}"/>)", r, l),
              turned([=](double z) { return std::abs(z) < 0.5 * l ? r : ball(std::abs(z) - 0.5 * l); },
                     {-0.5 * l - r, -0.5 * l, 0.5 * l, 0.5 * l + r})};
  }
}

// A parallelepiped of edges a, b, c has the second moments V / 12 (a a^T + b b^T + c c^T) about its middle, whichever way its faces turn.
TEST(UrdfShapes, ClosedSurfacesHaveTheMomentsOfWhatTheyEnclose) {
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const auto real = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(random); };
    Matrix3d E = Matrix3d::NullaryExpr([&] { return real(-1, 1); });
    const Vector3d p(real(-5, 5), real(-5, 5), real(-5, 5));
    import::Surface surface;
    for (int i = 0; i < 8; ++i)
      surface.vertices.push_back(p + E * Vector3d((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5));
    const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (const auto& f : faces) {
      surface.triangles.emplace_back(f[0], f[1], f[2]);
      surface.triangles.emplace_back(f[0], f[2], f[3]);
    }
    const import::MassProperties got = import::surface_properties(surface);
    const double V = std::abs(E.determinant());
    const Matrix3d S = V / 12.0 * E * E.transpose();
    EXPECT_NEAR(got.mass, V, 1e-13) << "seed " << seed;
    EXPECT_LT((got.center - p).norm(), 1e-12 / V) << "seed " << seed;
    EXPECT_LT((got.inertia - S.trace() * Matrix3d::Identity() + S).norm(), 1e-12) << "seed " << seed;
  }
}

// Links without inertia, of one to three shapes each, against KDL with the inertias written out.
TEST(UrdfShapes, LinksMoveWithTheInertiaOfTheirShapes) {
  const Folder folder;
  for (unsigned seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const auto real = [&](double a, double b) { return std::uniform_real_distribution<>(a, b)(random); };
    const double density = real(100, 8000);
    std::string bare = link("l0", ""), written = bare;
    const int n = 2 + static_cast<int>(random() % 4);
    for (int l = 1; l < n; ++l) {
      const std::string name = fmt::format("l{}", l);
      std::string shapes;
      Moments all;
      for (int k = 1 + static_cast<int>(random() % 3); k > 0; --k) {
        const Drawn shape = draw_shape(real, static_cast<int>(random() % 4));
        const Vector3d p(real(-0.5, 0.5), real(-0.5, 0.5), real(-0.5, 0.5)),
            rpy(real(-3, 3), real(-1.5, 1.5), real(-3, 3));
        const Matrix3d R =
            (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
             Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
                .toRotationMatrix();
        all.add(shape.moments, R, p);
        shapes += fmt::format(
            R"(<collision><origin xyz="{:.17g} {:.17g} {:.17g}" rpy="{:.17g} {:.17g} {:.17g}"/><geometry>{}</geometry></collision>)",
            p.x(), p.y(), p.z(), rpy.x(), rpy.y(), rpy.z(), shape.xml);
      }
      const Vector3d c = all.center();
      const Matrix3d I = density * all.inertia();
      bare += link(name, shapes);
      written += link(
          name,
          fmt::format(
              R"(<inertial><origin xyz="{:.17g} {:.17g} {:.17g}"/><mass value="{:.17g}"/><inertia ixx="{:.17g}" iyy="{:.17g}" izz="{:.17g}" ixy="{:.17g}" ixz="{:.17g}" iyz="{:.17g}"/></inertial>)",
              c.x(), c.y(), c.z(), density * all.mass, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
      const std::string hinge = joint(
          fmt::format("j{}", l), "continuous", fmt::format("l{}", l - 1), name,
          fmt::format(R"(<origin xyz="{:.17g} 0.3 0.1" rpy="0 {:.17g} 0.4"/><axis xyz="1 {:.17g} 0.2"/>)",
                      real(-1, 1), real(-1, 1), real(-1, 1)));
      bare += hinge;
      written += hinge;
    }
    const auto reference = kdl_accelerations(urdf::parseURDF(robot(written)));
    import::Findings findings("r.urdf");
    const import::Mechanism mechanism = import::urdf::to_mechanism(
        import::urdf::read_robot(robot(bare), findings), {.density = density}, findings);
    const auto prepared = mbs::prepare(folder.write("m.toml", import::mechanism_text(mechanism)));
    double largest = 1.0;
    for (const auto& [name, a] : reference) largest = std::max(largest, std::abs(a));
    ASSERT_EQ(prepared.mechanism->sizes().n_v, n - 1) << "seed " << seed;
    // Simpson's rule leaves h^4 of polynomials of degree 4, 200^-4 = 6e-10 of them.
    for (int i = 0; i < n - 1; ++i) {
      const std::string name = prepared.mechanism->name_of_velocity(i);
      EXPECT_NEAR(prepared.v_dot[i], reference.at(name.substr(0, name.find('.'))), 1e-8 * largest)
          << "seed " << seed << ", " << name << "\n"
          << robot(bare);
    }
  }
}

}  // namespace
}  // namespace flexura::test
