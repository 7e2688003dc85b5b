// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "tests/app/command.hpp"

/// Runs of mechanisms of one freedom beside its equation of motion.
namespace flexura::properties {

inline constexpr const char* kMethods[] = {"ida", "radau", "generalised_alpha", "runge_kutta"};

/// One freedom: the acceleration of the crank's angle by (angle, speed).
using Law = std::function<double(double, double)>;

// Angle and speed at the end by the classical Runge-Kutta method; 20,000 steps are right to 1e-11 of a turn here.
inline std::array<double, 2> reference(const Law& law, double angle, double speed, double end) {
  constexpr int kSteps = 20000;
  const double h = end / kSteps;
  for (int i = 0; i < kSteps; ++i) {
    const double a1 = law(angle, speed), v2 = speed + 0.5 * h * a1;
    const double a2 = law(angle + 0.5 * h * speed, v2), v3 = speed + 0.5 * h * a2;
    const double a3 = law(angle + 0.5 * h * v2, v3), v4 = speed + h * a3;
    const double a4 = law(angle + h * v3, v4);
    angle += h / 6.0 * (speed + 2.0 * v2 + 2.0 * v3 + v4);
    speed += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
  }
  return {angle, speed};
}

// What the run says of a joint's angle and speed at its end.
inline std::array<double, 2> run_to_end(const test::Folder& folder, const std::string& text,
                                        const std::string& crank, std::string& trouble) {
  mbs::PreparedMechanism p = mbs::prepare(folder.write("linkage.toml", text));
  const mbs::RunResult result = mbs::run(*p.mechanism, p.state, p.v_dot, p.options);
  trouble = result.stopped_because;
  const auto all = p.mechanism->quantities();
  std::vector<int> which;
  for (const char* what : {".angle", ".speed"})
    for (std::size_t i = 0; i < all.size(); ++i)
      if (all[i].name == crank + what) which.push_back(static_cast<int>(i));
  Eigen::VectorXd values(2);
  p.mechanism->evaluate(which, result.state, result.v_dot, *p.mechanism->make_scratch(), values);
  return {values(0), values(1)};
}

// Errors of a motion that turns on grow with the square of time: some hundred tolerances in these ten turns, and what a passage
// leaves (steps of fixed size and loops closed to 1e-10) comes to it.
inline void expect_same(const std::array<double, 2>& is, const std::array<double, 2>& right, double tolerance,
                        double end, const std::string& which) {
  const double allowed = 3e3 * tolerance + 1e-5, rate = std::max(1.0, std::abs(right[1]));
  EXPECT_NEAR(is[0], right[0], allowed * std::max(1.0, rate * end)) << which;
  EXPECT_NEAR(is[1], right[1], allowed * rate * std::max(1.0, rate * end)) << which;
}

}  // namespace flexura::properties
