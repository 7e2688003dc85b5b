// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The gear pair of cases/rattle, driven through an elastic shaft that oscillates.
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

/// Tooth forces [N], negative where the teeth push, in the fully grown oscillation.
struct Teeth {
  double least = 1e300, greatest = 0.0;
  int apart = 0, rows = 0;
};

Teeth teeth(const Folder& folder, const std::string& se, double depth) {
  const std::filesystem::path file = std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases/rattle/rattle.toml";
  const std::string output = folder / "rattle.h5";
  const Outcome simulated =
      run("flexura", {"simulate", file, "-q", "--no-estimate", "-o", output, "--end-time", "0.4 s", "--set",
                      "body.shaft.superelement=" + se, "--set", "parameters.depth=" + std::to_string(depth)});
  EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
  const results::Results results = results::read(output);
  const results::Run& history = results.runs.at(0);
  Teeth out;
  for (std::size_t j = 0; j < history.quantities.size(); ++j) {
    if (history.quantities[j].name != "teeth.force") continue;
    for (Eigen::Index k = 2400; k < history.values.rows(); ++k) {  // from 0.24 s on
      const double push = -history.values(k, static_cast<Eigen::Index>(j));
      out.least = std::min(out.least, push);
      out.greatest = std::max(out.greatest, push);
      out.apart += push < 1e-9;
      ++out.rows;
    }
  }
  EXPECT_GT(out.rows, 1500);
  return out;
}

TEST(GearRattle, SetsInWhereTheWheelsInertiaExceedsTheDrag) {
  const Folder folder;
  const std::string se = folder / "shaft.se.h5";
  const Outcome reduced =
      run("flexura", {"reduce", FLEXURA_SOURCE_DIR "/cases/rattle/shaft.toml", "-q", "-o", se});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;

  // Teeth in contact: the drive turns the shaft's far end by theta_0 sin(w t),
  //   [k_s + k r_1^2 - J_1 w^2     k r_1 r_2         ] [theta_1]   [k_s theta_0]
  //   [k r_1 r_2                   k r_2^2 - J_2 w^2 ] [theta_2] = [0          ]
  // and with k_s = G I_t / L, a third of the shaft's inertia counting with J_1.
  const double w = 2.0 * M_PI * 25.0, r_1 = 0.05, r_2 = 0.08, k = 2e7, J_2 = 2e-3, drag = 1.0,
               I_t = M_PI * 1e-8 / 2.0, k_s = 210e9 / 2.6 * I_t / 0.3, J_1 = 1e-3 + 7850.0 * I_t * 0.3 / 3.0;
  const double a = k_s + k * r_1 * r_1 - J_1 * w * w, b = k * r_1 * r_2, c = k * r_2 * r_2 - J_2 * w * w;
  const double enlarged = b * k_s / (a * c - b * b) * r_2 / r_1;  // alpha_2 over that of a stiff drive

  // J_2 |alpha_2| = 0.97 of the drag: the teeth push all the time, with drag / r_2 (1 +- 0.97).  Teeth and
  // shaft ring by less than the drive's ramp over 0.16 s excites, exp(-30 t) of the start and round-off.
  const Teeth together = teeth(folder, se, 0.97 / enlarged);
  EXPECT_EQ(together.apart, 0);
  EXPECT_NEAR(together.greatest, drag / r_2 * 1.97, 0.01 * drag / r_2);
  EXPECT_NEAR(together.least, drag / r_2 * 0.03, 0.01 * drag / r_2);

  // 1.03 of the drag: they part in each period.  1.5 of it: they strike, on both flanks.
  EXPECT_GT(teeth(folder, se, 1.03 / enlarged).apart, 0);
  const Teeth rattle = teeth(folder, se, 1.5 / enlarged);
  EXPECT_GT(rattle.apart, rattle.rows / 10);
  EXPECT_LT(rattle.apart, rattle.rows * 6 / 10);  // and never lose each other
  EXPECT_GT(rattle.greatest, 3.0 * drag / r_2 * 2.5);
}

}  // namespace
}  // namespace flexura::test
