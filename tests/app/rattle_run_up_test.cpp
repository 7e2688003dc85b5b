// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The run-up of cases/rattle: wheels with flexible webs on a flexible shaft against three equations by hand.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

constexpr double kRho = 7850.0, kStart = 0.2, kRunUp = 0.3, kDrag = 6.5;

/// Tooth forces [N], positive on the flank that drives, at times [s].
struct Teeth {
  std::vector<double> time, force;
  double parts() const {  // when they part first in the run-up; 1e300: never
    for (std::size_t k = 0; k < time.size(); ++k)
      if (time[k] > kStart && force[k] <= 1e-9) return time[k];
    return 1e300;
  }
};

double ring(double width, double outer, double inner) {
  return M_PI / 2.0 * kRho * width * (std::pow(outer, 4) - std::pow(inner, 4));
}

// The web's polar moment: five rings, the three in the middle half cut away, each of 36 straight pieces.
double web(double inner, double outer) {
  const double step = 2.0 * M_PI / 36.0, polygon = std::sin(step) / step * (2.0 + std::cos(step)) / 3.0;
  double sum = 0.0;
  for (int j = 0; j < 5; ++j) {
    const double a = inner + (outer - inner) * j / 5.0, b = inner + (outer - inner) * (j + 1) / 5.0;
    sum += polygon * ring(0.004, b, a) * (j == 0 || j == 4 ? 1.0 : 0.5);
  }
  return sum;
}

// The drive of the case file, by itself: engine's angle with its second order.
double drive(double t) {
  const double w_0 = 50.0 * M_PI, w_1 = 200.0 / 3.0 * M_PI, u = std::max(0.0, t - kStart) / kRunUp;
  const double s = std::clamp((t - 0.04) / 0.16, 0.0, 1.0),
               mean = w_0 * t + (w_1 - w_0) * kRunUp * u * u * u * (1.0 - u / 2.0);
  return mean + 0.0125 * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s) * std::sin(2.0 * mean);
}

// Teeth that hold together, by hand: the torsion of the shaft, its bending at the wheel and the teeth,
//   J_1 theta_1'' = k_s (theta_0 - theta_1) - r_b1 F,   m u'' = -k_b u - F,   J_2 theta_2'' = r_b2 F - drag,
//   F = k (r_b1 theta_1 + u - r_b2 theta_2) + its damping,
// k_s = G I_t / L, with a third of the shaft's inertia and all of its end's at the wheel; k_b that of a beam clamped where the
// drive holds it and pinned at the other end.  The teeth's 3e8 N/m (ISO's 14 N/(mm um) for the pairs in mesh) are a hundred times
// stiffer than the shaft, so that their stiffness hardly counts.  Explicit midpoint steps of 5 us: (omega h)^2 / 6 is 1e-6 in 2 omega.
Teeth by_hand(double width) {
  const double I_t = M_PI * 1e-8 / 2.0, k_s = 210e9 / 2.6 * I_t / 0.3;
  const double a = 0.3, b = 0.1, L = a + b, EI = 210e9 * I_t / 2.0;
  const double k_b = 12.0 * EI * L * L * L / (a * a * a * b * b * (4.0 * L - a)), k = 3e8, damping = 3000.0;
  const double J_1 = ring(0.02, 0.05, 0.038) + web(0.015, 0.038) + kRho * I_t * (a / 3.0 + b);
  const double J_2 = ring(width, 0.08, 0.066) + web(0.015, 0.066);
  const double m = M_PI * kRho * 0.02 * (0.05 * 0.05 - 0.038 * 0.038);
  const double cosine = std::cos(std::atan(std::tan(M_PI / 9.0) / 0.9)), r_1 = 0.05 * cosine,
               r_2 = 0.08 * cosine;
  struct State {
    double q[3], v[3];  // theta_1, u, theta_2
  };
  double force = 0.0;
  const auto rate = [&](double t, const State& s) {
    const double settled = std::clamp(t / 0.04, 0.0, 1.0);
    const double drag =
        kDrag * settled * settled * settled * (10.0 - 15.0 * settled + 6.0 * settled * settled);
    force = k * (r_1 * s.q[0] + s.q[1] - r_2 * s.q[2]) + damping * (r_1 * s.v[0] + s.v[1] - r_2 * s.v[2]);
    return State{{s.v[0], s.v[1], s.v[2]},
                 {(k_s * (drive(t) - s.q[0]) - r_1 * force) / J_1, (-k_b * s.q[1] - force) / m,
                  (r_2 * force - drag) / J_2}};
  };
  const auto moved = [](State s, const State& by, double h) {
    for (int i = 0; i < 3; ++i) s.q[i] += h * by.q[i], s.v[i] += h * by.v[i];
    return s;
  };
  Teeth out;
  const double h = 5e-6;
  State s{{0.0, 0.0, 0.0}, {50.0 * M_PI, 0.0, 50.0 * M_PI * r_1 / r_2}};
  for (int n = 0; n * h < kStart + kRunUp; ++n) {
    const double t = n * h;
    const State first = rate(t, s);
    if (n % 20 == 0) {
      out.time.push_back(t);
      out.force.push_back(force);
    }
    s = moved(s, rate(t + 0.5 * h, moved(s, first, 0.5 * h)), h);
  }
  return out;
}

class RattleRunUp : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* const part : {"run_up_shaft", "web_1", "web_2"}) {
      const Outcome reduced = run("flexura", {"reduce", case_file(std::string(part) + ".toml"), "-q", "-o",
                                              folder_ / (std::string(part) + ".se.h5")});
      ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
    }
  }
  static std::filesystem::path case_file(const std::string& name) {
    return std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases/rattle" / name;
  }
  Teeth teeth(double width, double end) const {
    std::vector<std::string> arguments = {"simulate",   case_file("run_up.toml"),
                                          "-q",         "--no-estimate",
                                          "-o",         folder_ / "run.h5",
                                          "--end-time", fmt::format("{} s", end),
                                          "--set",      fmt::format("parameters.run_up={}", kRunUp),
                                          "--set",      "force.teeth.harmonics=0",
                                          "--set",      fmt::format("parameters.width_2={}", width)};
    for (const auto& [body, part] :
         {std::pair{"shaft", "run_up_shaft"}, {"web_1", "web_1"}, {"web_2", "web_2"}})
      arguments.insert(arguments.end(),
                       {"--set", fmt::format("body.{}.superelement={}", body,
                                             (folder_ / (std::string(part) + ".se.h5")).string())});
    const Outcome simulated = run("flexura", arguments);
    EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
    const results::Results results = results::read((folder_ / "run.h5").string());
    const results::Run& history = results.runs.at(0);
    Teeth out;
    for (std::size_t j = 0; j < history.quantities.size(); ++j)
      if (history.quantities[j].name == "teeth.force")
        for (Eigen::Index k = 0; k < history.values.rows(); ++k) {
          out.time.push_back(history.time(k));
          out.force.push_back(history.values(k, static_cast<Eigen::Index>(j)));
        }
    return out;
  }
  Folder folder_;
};

TEST_F(RattleRunUp, SetsInAtTheSpeedAtWhichTheInertiaExceedsTheDrag) {
  const Teeth expected = by_hand(0.02);
  const double parts = expected.parts();
  ASSERT_GT(parts, kStart + 0.25 * kRunUp);  // within the run-up, not at its ends
  ASSERT_LT(parts, kStart + 0.75 * kRunUp);
  const Teeth found = teeth(0.02, parts + 0.01);
  // By hand the webs are rigid and without mass across the shaft, and the shaft's mass does not bend it: some per cent each of
  // the 4 % that the bending makes.  The onset follows within a fifth of a millisecond, a ripple's period being 17.
  EXPECT_NEAR(found.parts(), parts, 1e-3);
  double most = 0.0;
  for (std::size_t k = 0; k < found.time.size() && found.time[k] < parts - 0.005; ++k)
    if (found.time[k] > 0.1) most = std::max(most, std::abs(found.force[k] - expected.force[k]));
  EXPECT_LT(most, 0.03 * kDrag / 0.074);

  // A wheel of half the width, so much lighter, runs up in contact.
  ASSERT_GT(by_hand(0.01).parts(), 1.0);
  EXPECT_GT(teeth(0.01, kStart + kRunUp).parts(), 1.0);
}

}  // namespace
}  // namespace flexura::test
