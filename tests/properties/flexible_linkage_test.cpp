// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A plane four-bar with a flexible coupler turns, whatever modes the coupler keeps: rows out of the plane, which these may make
// independent by next to nothing, carry nothing.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "mbs/mechanism/describe.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/superelement/file.hpp"
#include "reduce/file/beam_file.hpp"
#include "reduce/library/reduce.hpp"
#include "tests/app/command.hpp"

namespace flexura::properties {
namespace {

// The drive's torque over one turn [N m].
std::vector<double> torque(const mbs::PreparedMechanism& p) {
  const auto which = mbs::select_quantities(*p.mechanism, {"motor.drive_force"});
  const auto scratch = p.mechanism->make_scratch();
  std::vector<double> out;
  mbs::RunCallbacks callbacks;
  callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
    Eigen::VectorXd value(1);
    p.mechanism->evaluate(which, s, v_dot, *scratch, value);
    out.push_back(value(0));
  };
  const mbs::RunResult result = mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks);
  EXPECT_TRUE(result.complete) << result.stopped_because;
  return out;
}

// With 4 modes the four-bar of the tutorial was stopped at a dead point that it has not.
TEST(FlexibleLinkages, TurnWithAnyModesOfTheCoupler) {
  const test::Folder folder;
  const std::filesystem::path tutorial = FLEXURA_SOURCE_DIR "/docs/tutorials/four_bar";
  superelement::write(folder / "link.se.h5",
                      reduce::reduce(reduce::read_beam_part(tutorial / "link.toml", {})).superelement);
  std::filesystem::copy(tutorial / "flexible.toml", folder / "flexible.toml");
  for (const char* const boundary : {"joint", "free"})
    for (int modes = 1; modes <= 12; ++modes) {
      SCOPED_TRACE(fmt::format("{} modes, boundary {}", modes, boundary));
      std::vector<std::string> set = {fmt::format("body.coupler.modes={}", modes), "solver.tolerance=1e-7",
                                      "solver.end_time=0.2"};
      if (boundary == std::string("free")) set.push_back("body.coupler.boundary=free");
      const std::vector<double> hinged = torque(mbs::prepare(folder / "flexible.toml", set));
      set.push_back("joint.c.type=spherical");
      const std::vector<double> free = torque(mbs::prepare(folder / "flexible.toml", set));
      ASSERT_EQ(hinged.size(), free.size());
      double worst = 0.0, size = 0.0;
      for (std::size_t i = 0; i < free.size(); ++i) {
        worst = std::max(worst, std::abs(hinged[i] - free[i]));
        size = std::max(size, std::abs(free[i]));
      }
      // Two runs to the tolerance, of which the coupler's vibration makes 1e3 to 1e4 times as much in forces.
      EXPECT_LT(worst, 1e-3 * size);
    }
}

}  // namespace
}  // namespace flexura::properties
