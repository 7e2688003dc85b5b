// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
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

// The page summed the modes' shapes alone and said 1.6705e9 Pa at 0.2144 s where the results have 1.5489e9 Pa at 0.2166 s: what
// accelerations add inside the plate was left out.
TEST(MotionPage, GreatestStressIsThatOfTheResults) {
  Folder folder;
  std::string deck = "*NODE\n", elements = "*ELEMENT, TYPE=S4, ELSET=ALL\n";
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) deck += fmt::format("{}, {}, {}, 0\n", 1 + i + 5 * j, 0.1 * i, 0.1 * j);
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      elements += fmt::format("{}, {}, {}, {}, {}\n", 1 + i + 4 * j, 1 + i + 5 * j, 2 + i + 5 * j,
                              7 + i + 5 * j, 6 + i + 5 * j);
  folder.write("d.inp",
               deck + elements +
                   "*SHELL SECTION, ELSET=ALL, MATERIAL=S\n.002\n*MATERIAL, NAME=S\n*ELASTIC\n2.1E11, .3\n"
                   "*DENSITY\n7850.\n");
  const auto part = folder.write("p.toml",
                                 "[geometry]\nfile = \"d.inp\"\nunit = \"m\"\nprogram = "
                                 "\"abaqus\"\n[interface.a]\nby = \"nodes\"\nnodes = [1, 6, 11, "
                                 "16, 21]\n[interface.b]\nby = \"nodes\"\nnodes = [15]\n[recovery]\nstress = "
                                 "true\n[modes]\ncount = 6\ndamping = 0.05\n");
  ASSERT_EQ(run("flexura", {"reduce", part.string(), "-q", "-o", folder / "p.se.h5"}).exit_code, 0);
  int apart = 0;
  for (const char* quantities : {"[\"*\"]", "[\"pl.von_mises\"]", "[\"pl.strain_energy\"]"}) {
    const auto file = folder.write(
        "m.toml",
        fmt::format(
            "[body.pl]\nsuperelement = \"p.se.h5\"\nfidelity = \"modal\"\nstress = true\n[joint.w]\ntype = "
            "\"fixed\"\nfrom = \"ground\"\nto = \"pl.a\"\n[force.f]\ntype = \"force\"\nmarker = \"pl.b\"\nz "
            "= "
            "\"3000*exp(-((t-0.003)/0.0007)^2)\"\n[output]\nquantities = {}\n[solver]\nend_time = "
            "0.02\noutput_step = 1e-4\n",
            quantities));
    ASSERT_EQ(run("flexura", {"simulate", file.string(), "-q", "-o", folder / "m.h5"}).exit_code, 0);
    ASSERT_EQ(run("flexura", {"view", folder / "m.h5", "-q", "-o", folder / "m.html"}).exit_code, 0);
    const view::testing::PageReader page(read_text(folder / "m.html"));
    const json& bodies = page.header.at("runs").at(0).at("bodies");
    std::size_t number = 0;
    while (bodies.at(number).at("name") != "pl") ++number;
    const json& shown = bodies.at(number).at("largest").at("stress");
    const results::Run run = results::read(folder / "m.h5").runs.at(0);
    const auto stored = std::ranges::find(run.quantities, "pl.von_mises", &results::Quantity::name);
    if (stored == run.quantities.end()) {  // nothing else is known than what is drawn
      EXPECT_NEAR(shown.at("value").get<double>(), shown.at("drawn").get<double>(),
                  1e-5 * shown.at("value").get<double>());
      continue;
    }
    Eigen::Index row = 0;
    const double most = run.values.col(stored - run.quantities.begin()).maxCoeff(&row);
    EXPECT_EQ(shown.at("value").get<double>(), most) << quantities;
    EXPECT_EQ(shown.at("time").get<double>(), run.time[row]) << quantities;
    apart += std::abs(shown.at("drawn").get<double>() - most) > 0.01 * most;
  }
  EXPECT_EQ(apart, 2);  // otherwise the case shows nothing
}

}  // namespace
}  // namespace flexura::test
