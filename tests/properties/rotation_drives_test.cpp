// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Joints that turn in any direction are driven by a rotation vector or by three angles: they turn and accelerate as the rotation's
// differences say, and take the torque that the body's angular momentum changes by.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <functional>

#include "tests/app/command.hpp"
#include "tests/mbs/cases/case_run.hpp"
#include "tests/mbs/random/chance.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::properties {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using mbs::chance::Chance;

// a + b sin(c t + d): as a formula and as a number.
struct Swing {
  double a, b, c, d;
  std::string text() const { return fmt::format("{:.17g} + {:.17g}*sin({:.17g}*t + {:.17g})", a, b, c, d); }
  double at(double t) const { return a + b * std::sin(c * t + d); }
};
Swing random_swing(Chance& chance) {
  return {chance.between(-1, 1), chance.between(-0.6, 0.6), chance.between(0.5, 3), chance.between(0, 6)};
}

struct Rotation {
  std::string sequence;  ///< empty: a rotation vector
  std::array<Swing, 3> q;
  Matrix3d R(double t) const {
    const Vector3d values(q[0].at(t), q[1].at(t), q[2].at(t));
    if (sequence.empty()) return Eigen::AngleAxisd(values.norm(), values.normalized()).toRotationMatrix();
    Matrix3d out = Matrix3d::Identity();
    for (int i = 0; i < 3; ++i)
      out *= Eigen::AngleAxisd(values(i), Vector3d::Unit(sequence[static_cast<std::size_t>(i)] - 'x'))
                 .toRotationMatrix();
    return out;
  }
  Vector3d w(double t) const;
};

// f' to the sixth order: with h = 2e-3 and the rates drawn here some 1e-13 / h of round-off and 1e-15 of the order are left.
template <class F>
auto rate_of(const F& f, double t) -> decltype(f(t)) {
  constexpr double h = 2e-3;
  const decltype(f(t)) three = f(t + 3 * h) - f(t - 3 * h), two = f(t + 2 * h) - f(t - 2 * h),
                       one = f(t + h) - f(t - h);
  return decltype(f(t))((three - 9.0 * two + 45.0 * one) / (60.0 * h));
}

// R' R^T of a rotation is its angular velocity's cross product.
Vector3d Rotation::w(double t) const {
  const Matrix3d W = rate_of([&](double at) -> Matrix3d { return R(at); }, t) * R(t).transpose();
  return 0.5 * Vector3d(W(2, 1) - W(1, 2), W(0, 2) - W(2, 0), W(1, 0) - W(0, 1));
}

TEST(RotationDrives, TurnAsWantedAndTakeTheTorqueOfTheAngularMomentum) {
  static constexpr std::array kSequences = {"",    "xyz", "xzy", "yxz", "yzx", "zxy", "zyx",
                                            "xyx", "xzx", "yxy", "yzy", "zxz", "zyz"};
  static constexpr std::array kTypes = {"spherical", "six_dof", "point_on_line", "point_on_plane"};
  static constexpr std::array kMethods = {"ida", "radau", "runge_kutta", "generalised_alpha"};
  const test::Folder folder;
  for (int seed = 0; seed < 208; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const Rotation rotation{kSequences[static_cast<std::size_t>(seed) % kSequences.size()],
                            {random_swing(chance), random_swing(chance), random_swing(chance)}};
    const int type = chance.below(4);
    const bool follows = chance.flip(0.4), closes = chance.flip(0.3);
    const double m = chance.between(0.5, 2);
    const Vector3d I(chance.between(0.2, 0.3), chance.between(0.2, 0.3), chance.between(0.2, 0.3));
    std::string text = "gravity = [0, 0, 0]\n", drives;
    for (int i = 0; i < 3; ++i) {
      const std::string formula = rotation.q[static_cast<std::size_t>(i)].text();
      if (follows) text += fmt::format("[input.u{}]\nvalue = \"{}\"\n", i, formula);
      const std::string key = rotation.sequence.empty() ? fmt::format("drive_rotation_{}", "xyz"[i])
                                                        : fmt::format("drive_angle_{}", i + 1);
      drives += fmt::format("{} = \"{}\"\n", key, follows ? fmt::format("u{}", i) : formula);
    }
    if (!rotation.sequence.empty()) drives += fmt::format("drive_sequence = \"{}\"\n", rotation.sequence);
    // Translations, as the type has them.
    const std::string slides = type == 1 ? "xyz" : type == 2 ? "z" : type == 3 ? "xy" : "";
    std::array<Swing, 3> places{};
    for (const char axis : slides) {
      const Swing& place = places[static_cast<std::size_t>(axis - 'x')] = random_swing(chance);
      drives += fmt::format("drive_{} = \"{}\"\n", axis, place.text());
    }
    text += fmt::format(
        "[body.b]\nmass = {}\ninertia = [{}, {}, {}]\n[joint.j]\ntype = \"{}\"\nfrom = \"ground\"\nto = "
        "\"b\"\n{}",
        m, I.x(), I.y(), I.z(), kTypes[static_cast<std::size_t>(type)], drives);
    // It closes a loop beside a joint that leaves all free, which begins where the drive does.
    if (closes && type != 1) {
      const Eigen::Quaterniond start(rotation.R(0));
      text += fmt::format(
          "cut = true\n[joint.all]\ntype = \"six_dof\"\nfrom = \"ground\"\nto = \"b\"\nqw = {}\nqx = {}\nqy "
          "= {}\nqz = {}\n",
          start.w(), start.x(), start.y(), start.z());
    }
    text += fmt::format("[solver]\nend_time = 1\noutput_step = 0.25\ntolerance = 1e-9\nmethod = \"{}\"\n",
                        kMethods[static_cast<std::size_t>(chance.below(4))]);
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
    const mbs::PreparedMechanism p = mbs::prepare(folder.write("b.toml", text));
    std::vector<std::string> names;
    for (const char* what : {"omega", "alpha", "drive_force_omega"})
      for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("j.{}_{}", what, axis));
    for (const char* q : {"qw", "qx", "qy", "qz"}) names.push_back(fmt::format("j.{}", q));
    for (const char axis : slides) {
      names.push_back(fmt::format("j.{}", axis));
      names.push_back(fmt::format("j.drive_force_{}", axis));
    }
    names.push_back("power.input");
    const mbs::cases::Series run = mbs::cases::simulate(p, names);
    ASSERT_EQ(run.t.size(), 5u);
    for (std::size_t k = 0; k < run.t.size(); ++k) {
      const double t = run.t[k];
      const Eigen::VectorXd& row = run.values[k];
      const Matrix3d R = rotation.R(t), is = Eigen::Quaterniond(row(9), row(10), row(11), row(12))
                                                 .normalized()
                                                 .toRotationMatrix();
      // Rows are closed to 1e-9; differences of differences are good to some 1e-9 in these units, torques likewise.
      EXPECT_LT((is - R).cwiseAbs().maxCoeff(), 1e-8) << t;
      const Vector3d w = rotation.w(t),
                     alpha = rate_of([&](double at) -> Vector3d { return rotation.w(at); }, t);
      const auto momentum = [&](double at) -> Vector3d {
        const Matrix3d R_at = rotation.R(at);
        return R_at * I.asDiagonal() * R_at.transpose() * rotation.w(at);
      };
      const Vector3d torque = rate_of(momentum, t);
      EXPECT_LT((row.segment<3>(0) - w).cwiseAbs().maxCoeff(), 1e-7) << t << "\n"
                                                                     << row.transpose() << "\n"
                                                                     << w.transpose();
      EXPECT_LT((row.segment<3>(3) - alpha).cwiseAbs().maxCoeff(), 1e-6) << t;
      EXPECT_LT((row.segment<3>(6) - torque).cwiseAbs().maxCoeff(), 1e-6) << t;
      Eigen::Index at = 13;
      double power = torque.dot(w);
      for (const char axis : slides) {
        const Swing& s = places[static_cast<std::size_t>(axis - 'x')];
        EXPECT_NEAR(row(at++), s.at(t), 1e-8) << t << axis;
        EXPECT_NEAR(row(at++), -m * s.b * s.c * s.c * std::sin(s.c * t + s.d), 1e-6) << t << axis;
        power -= m * s.b * s.b * s.c * s.c * s.c * std::sin(s.c * t + s.d) * std::cos(s.c * t + s.d);
      }
      EXPECT_NEAR(row(at), power, 1e-5) << t;
    }
    if (HasFailure()) return;
  }
}

// A top that precesses evenly: W sin(a) (C (s + W cos a) - A W cos a) about the line of nodes.
TEST(RotationDrives, ConingTakesTheTorqueOfSteadyPrecession) {
  const test::Folder folder;
  for (int seed = 0; seed < 20; ++seed) {
    Chance chance(static_cast<std::uint64_t>(seed) + 1);
    const double A = chance.between(0.2, 0.4), C = chance.between(0.1, 0.35), tilt = chance.between(0.1, 1.4),
                 W = chance.either_sign(0.5, 4), spin = chance.either_sign(0, 20);
    const mbs::PreparedMechanism p = mbs::prepare(folder.write(
        "top.toml",
        fmt::format(
            "gravity = [0, 0, 0]\n[body.b]\nmass = 1\ninertia = [{0}, {0}, {1}]\n[joint.j]\ntype = "
            "\"spherical\"\nfrom "
            "= \"ground\"\nto = \"b\"\ndrive_angle_1 = \"{2}*t\"\ndrive_angle_2 = {3}\ndrive_angle_3 = "
            "\"{4}*t\"\ndrive_sequence = \"zxz\"\n[solver]\nend_time = 1\noutput_step = 0.1\n",
            A, C, W, tilt, spin)));
    const mbs::cases::Series run = mbs::cases::simulate(
        p, {"j.drive_force_omega_x", "j.drive_force_omega_y", "j.drive_force_omega_z", "energy.kinetic"});
    const double torque = W * std::sin(tilt) * (C * (spin + W * std::cos(tilt)) - A * W * std::cos(tilt));
    const double about_axis = spin + W * std::cos(tilt), across = W * std::sin(tilt);
    for (std::size_t k = 0; k < run.t.size(); ++k) {
      const double t = run.t[k], size = std::max(1.0, std::abs(torque));
      EXPECT_NEAR(run.values[k](0), torque * std::cos(W * t), 1e-8 * size) << seed << " " << t;
      EXPECT_NEAR(run.values[k](1), torque * std::sin(W * t), 1e-8 * size) << seed << " " << t;
      EXPECT_NEAR(run.values[k](2), 0.0, 1e-8 * size) << seed << " " << t;
      EXPECT_NEAR(run.values[k](3), 0.5 * (C * about_axis * about_axis + A * across * across),
                  1e-7 * (1 + C * spin * spin))
          << seed << " " << t;
    }
    if (HasFailure()) return;
  }
}

TEST(RotationDrives, WhatContradictsThemIsRefused) {
  const test::Folder folder;
  const auto file = folder.write(
      "m.toml",
      "[body.b]\nmass = 1\ninertia = [1, 1, 1]\n[joint.j]\ntype = \"spherical\"\nfrom = \"ground\"\nto = "
      "\"b\"\n");
  const struct {
    std::vector<std::string> set;
    const char* says;
  } wrong[] = {{{"joint.j.drive_rotation_x=t", "joint.j.drive_angle_1=t"}, "driven twice"},
               {{"joint.j.drive_rotation_x=t", "joint.j.drive_omega_y=1"}, "driven twice"},
               {{"joint.j.drive_angle_2=t", "joint.j.drive_alpha_z=1"}, "driven twice"},
               {{"joint.j.drive_angle_2=t", "joint.j.qx=0.1"}, "the rotation is driven"},
               {{"joint.j.drive_sequence=zxz"}, "goes with drive_angle_1, drive_angle_2, drive_angle_3 only"},
               {{"joint.j.drive_rotation_x=t", "joint.j.drive_sequence=zxz"}, "goes with drive_angle_1"}};
  for (const auto& w : wrong) {
    const std::string said = mbs::test::refusal_of([&] { mbs::prepare(file, w.set); });
    EXPECT_NE(said.find(w.says), std::string::npos) << w.set.front() << ": " << said;
  }
}

}  // namespace
}  // namespace flexura::properties
