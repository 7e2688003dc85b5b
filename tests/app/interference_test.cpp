// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// A ball on a driven arm that dips into a block: when and how deep is known.
#include <gmock/gmock.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

// The ball's lowest point stands at -(cos q + 0.1), the block's top at -1.08: 0.02 deep at q = 0.
const char* const kDip = R"(
name = "dip"
gravity = [0, 0, 0]
[[ground.shape]]
type = "box"
center = [0, 0, -1.2]
size = [0.6, 0.4, 0.24]
[ground.marker.pivot]
axis = [0, 1, 0]
[body.bob]
mass = 1
inertia = [1, 1, 1]
[[body.bob.shape]]
type = "sphere"
center = [0, 0, -1]
radius = 0.1
[body.bob.marker.pivot]
axis = [0, 1, 0]
[joint.hinge]
type = "revolute"
from = "ground.pivot"
to = "bob.pivot"
drive = "t - 0.5"
[solver]
method = "kinematics"
end_time = 1
output_step = 0.01
)";

nlohmann::json told(const Folder& folder, const std::string& file, const std::vector<std::string>& more) {
  std::vector<std::string> words = {"simulate", file, "-o", folder / "r.h5", "--json"};
  words.insert(words.end(), more.begin(), more.end());
  const Outcome o = run("flexura", words);
  EXPECT_EQ(o.exit_code, 0) << o.err;
  return nlohmann::json::parse(o.out).at("runs").at(0);
}

TEST(Interferences, ABallThatDipsIntoABlockIsToldWithItsTimesAndDepth) {
  const Folder folder;
  const std::string file = folder.write("dip.toml", kDip);
  const auto r = told(folder, file, {"--interferences"});
  const auto& list = r.at("summary").at("interferences");
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0].at("bodies"), nlohmann::json({"ground", "bob"}));
  // The lowest corner of the drawn ball is the ball's.
  EXPECT_NEAR(list[0].at("depth").get<double>(), 0.02, 1e-9);
  EXPECT_NEAR(list[0].at("time").get<double>(), 0.5, 1e-9);
  EXPECT_NEAR(list[0].at("point").at(2).get<double>(), -1.09,
              0.01 + 1e-9);  // the ball's, or that of the block's top
  // It is told beyond 0.2 mm and what 32 sides of the ball may be off, a few tenths of a millimetre: cos q = 0.98 + that.
  const double latest = std::acos(0.98 + 0.0002), earliest = std::acos(0.98 + 0.003);
  EXPECT_GE(list[0].at("from").get<double>(), 0.5 - latest - 1e-9);
  EXPECT_LE(list[0].at("from").get<double>(), 0.5 - earliest + 0.01);
  EXPECT_NEAR(list[0].at("to").get<double>(), 1.0 - list[0].at("from").get<double>(), 1e-9);
  EXPECT_EQ(list[0].at("times"), 1);
  EXPECT_THAT(r.at("warnings").at(0).get<std::string>(),
              HasSubstr("bodies \"ground\" and \"bob\" overlap from t = 0."));
}

TEST(Interferences, WhatStaysAwayOrIsWithinTheToleranceIsNot) {
  const Folder folder;
  const std::string file = folder.write("dip.toml", kDip);
  EXPECT_TRUE(told(folder, file, {"--interferences", "25 mm"}).at("summary").at("interferences").empty());
  const std::string lower =
      folder.write("lower.toml", replaced(kDip, "center = [0, 0, -1.2]", "center = [0, 0, -1.3]"));
  const auto r = told(folder, lower, {"--interferences"});
  EXPECT_TRUE(r.at("summary").at("interferences").empty());
  EXPECT_TRUE(r.at("warnings").empty());
  EXPECT_FALSE(told(folder, file, {}).at("summary").contains("interferences"));
}

TEST(Interferences, ADepthThatIsNoLengthIsRefused) {
  const Folder folder;
  const std::string file = folder.write("dip.toml", kDip);
  for (const char* const depth : {"1 s", "-1 mm", "much"}) {
    const Outcome o = run("flexura", {"simulate", file, "-o", folder / "r.h5", "--interferences", depth});
    EXPECT_EQ(o.exit_code, 2) << depth;
    EXPECT_THAT(o.err, HasSubstr("it must be a length above 0")) << depth;
  }
}

}  // namespace
}  // namespace flexura::test
