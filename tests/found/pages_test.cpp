// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"
#include "tests/view/page_reader.hpp"

/// What pages show, from the numbers that they hold.
namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using view::testing::json;

const fs::path kUser = fs::path(FLEXURA_SOURCE_DIR) / "tests/found/user";

// A clamped beam was coloured by its displacement from the floating frame: its clamp moved most, and "deflection
// 0.447 mm" stood where the tip moves 2.99 mm.
TEST(MotionPage, DisplacementCountsFromTheInterfaceThatHoldsTheBody) {
  Folder folder;
  fs::copy_file(kUser / "cant.toml", folder / "cant.toml");
  ASSERT_EQ(run("flexura", {"reduce", kUser / "bar.toml", "-q", "-o", folder / "bar.se.h5"}).exit_code, 0);
  ASSERT_EQ(run("flexura",
                {"simulate", folder / "cant.toml", "-q", "-o", folder / "cant.h5", "--end-time", "0.1 s"})
                .exit_code,
            0);
  ASSERT_EQ(run("flexura", {"view", folder / "cant.h5", "-q", "-o", folder / "cant.html"}).exit_code, 0);
  const view::testing::PageReader page(read_text(folder / "cant.html"));
  const json& bodies = page.header.at("runs").at(0).at("bodies");
  std::size_t number = 0;
  while (bodies.at(number).at("name") != "bar") ++number;
  const json& bar = bodies.at(number);
  const json& held = bar.at("frames").at(bar.at("held_by").get<std::size_t>());
  EXPECT_EQ(held.at("name"), "a");
  json tip;
  for (const json& frame : bar.at("frames"))
    if (frame.at("name") == "b") tip = frame;
  const auto vector = [](const json& list, std::size_t first) {
    return Eigen::Vector3d(list.at(first).get<double>(), list.at(first + 1).get<double>(),
                           list.at(first + 2).get<double>());
  };
  const auto modal = page.block<float>("run0/body/" + std::to_string(number) + "/modal");
  const results::Run run = results::read(folder / "cant.h5").runs.at(0);
  const auto column =
      std::ranges::find(run.quantities, "tip", &results::Quantity::name) - run.quantities.begin();
  const std::size_t m = bar.at("n_shapes"), frames = modal.size() / m;
  ASSERT_EQ(frames, static_cast<std::size_t>(run.time.size()));
  const double largest = run.values.col(column).cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < frames; ++i) {
    Eigen::Vector3d u_a = Eigen::Vector3d::Zero(), theta_a = u_a, u_b = u_a;
    for (std::size_t j = 0; j < m; ++j) {
      const double s = modal[j * frames + i];
      u_a += s * vector(held.at("motion").at(j), 0);
      theta_a += s * vector(held.at("motion").at(j), 3);
      u_b += s * vector(tip.at("motion").at(j), 0);
    }
    const Eigen::Vector3d from_clamp =
        u_b - u_a - theta_a.cross(vector(tip.at("point"), 0) - vector(held.at("point"), 0));
    // The body's frame turns by a few thousandths: second order, beside numbers of seven digits.
    EXPECT_NEAR(from_clamp.z(), run.values(static_cast<Eigen::Index>(i), column), 1e-4 * largest);
  }
  EXPECT_GT(largest, 2e-3);
}

}  // namespace
}  // namespace flexura::test
