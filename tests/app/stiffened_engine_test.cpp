// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The steam engine of cases/steam_engine with its rod once and four times as stiff: it tends to the engine
// with the rigid rod, and at the rate that linear elasticity gives.  cases/stiff_rod plots the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

const std::string kEngine = std::string(FLEXURA_SOURCE_DIR) + "/cases/steam_engine/";

/// The values of a quantity over time.
Eigen::VectorXd history(const results::Results& results, const std::string& run,
                        const std::string& quantity) {
  for (const results::Run& r : results.runs) {
    if (r.name != run) continue;
    for (std::size_t j = 0; j < r.quantities.size(); ++j)
      if (r.quantities[j].name == quantity) return r.values.col(static_cast<Eigen::Index>(j));
  }
  throw std::logic_error("no " + quantity + " in run " + run);
}

TEST(StiffenedEngine, TendsToTheRigidOne) {
  const Folder folder;
  const std::vector<std::string> stiffness = {"1", "4"};
  std::string text = read_text(kEngine + "engine.toml");
  text.erase(text.find("[run.rigid]"));
  text = replaced(text, "\"conrod.se.h5\"", "\"rod_1.se.h5\"");
  text += "[run.rigid]\nset = [\"body.rod.fidelity=rigid\"]\n";
  for (const std::string& k : stiffness) {
    const std::string se = folder / ("rod_" + k + ".se.h5");
    const Outcome reduced =
        run("flexura", {"reduce", kEngine + "conrod.toml", "-q", "-o", se, "--mesh-size", "25 mm", "--set",
                        "material.steel.young=\"" + std::to_string(210 * std::stoi(k)) + " GPa\""});
    ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
    text += "[run.x" + k + "]\nset = [\"body.rod.superelement=rod_" + k + ".se.h5\"]\n";
  }
  const std::string file = folder.write("engine.toml", text), output = folder / "engine.h5";
  const Outcome outcome = run("flexura", {"simulate", file, "-q", "-o", output, "--end-time", "0.1 s",
                                          "--set", "solver.tolerance=1e-8"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const results::Results results = results::read(output);

  const Eigen::VectorXd rigid_angle = history(results, "rigid", "main.angle");
  std::vector<double> stretch, angle;
  for (const std::string& k : stiffness) {
    stretch.push_back(history(results, "x" + k, "rod_stretch").cwiseAbs().maxCoeff());
    angle.push_back((history(results, "x" + k, "main.angle") - rigid_angle).cwiseAbs().maxCoeff());
  }
  // Deformation is load over stiffness. What is left is dynamic: the steam's harmonics below 150 Hz against
  // the rod's axial mode with the crosshead at 900 Hz, (150 / 900)^2 = 3 % at most.
  EXPECT_NEAR(stretch[0] / stretch[1], 4.0, 0.12);
  // And with it goes its effect on the motion; the integrators' own difference, 1e-7 rad, is 5 % of the
  // least.
  EXPECT_NEAR(angle[0] / angle[1], 4.0, 0.2);
  EXPECT_GT(stretch[0], 1e-6) << "a rod that does not give shows nothing";
}

}  // namespace
}  // namespace flexura::test
