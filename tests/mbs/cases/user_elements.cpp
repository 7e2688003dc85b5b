// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/model/checks.hpp"

/// The shipped example of elements of a user's own (cases/user_elements), built as a shared library and
/// loaded.
namespace flexura::mbs::cases {
namespace {

using ::testing::HasSubstr;

class UserElements : public TextCase {
 protected:
  static std::vector<std::string> with_library() {
    std::vector<std::string> overrides;
    for (const char* element : {"joint.wire", "constraint.shell", "force.pull"})
      overrides.push_back(fmt::format("{}.library=\"{}\"", element, FLEXURA_USER_LIBRARY));
    return overrides;
  }
};

TEST_F(UserElements, SatisfyTheIdentitiesOfAllElements) {
  const PreparedMechanism p = prepare_case("user_elements/magnets.toml", with_library());
  EXPECT_EQ(p.mechanism->name_of_velocity(0), "wire.v_x");
  EXPECT_EQ(p.mechanism->name_of_constraint(0), "shell.surface");
  for (const unsigned seed : {1u, 2u}) checks::all_identities_hold(*p.mechanism, seed);
}

TEST_F(UserElements, KeepTheEnergy) {
  const PreparedMechanism p = prepare_case("user_elements/magnets.toml", with_library());
  const Series s = simulate(p, {"wire.x", "bead.position_z", "pull.force", "ball.position_x",
                                "ball.position_y", "ball.position_z"});
  EXPECT_DOUBLE_EQ(s.values.front()(0), 0.2);
  for (const Eigen::VectorXd& row : s.values) {
    EXPECT_NEAR(row(1), row(0) * row(0), 1e-12);  // the joint's coordinate is exact
    EXPECT_GT(row(2), 0.0);
    // The constraint to the interpolation's error.
    EXPECT_NEAR(std::pow(row(3) / 0.5, 2) + std::pow(row(4) / 0.4, 2) + std::pow(row(5) / 0.3, 2), 1.0, 1e-6);
  }
  // 1e-8 in each of some thousand steps of about 1 J.
  EXPECT_LT(std::abs(s.result.energy.error()), 1e-4);
  EXPECT_LT(s.result.peak_position_drift, 1e-8);
}

TEST_F(UserElements, JointsAreDrivenOnEachLevel) {
  // x = 0.2 + 0.1 sin(3 t) however it is said; the bead stands on the parabola z = x^2.
  const std::vector<std::vector<std::string>> drives = {
      {"joint.wire.drive={x = \"0.2 + 0.1*sin(3*t)\"}", "joint.wire.start={}"},
      {"joint.wire.drive_speed={v_x = \"0.3*cos(3*t)\"}"},
      {"joint.wire.drive_acceleration={a_x = \"-0.9*sin(3*t)\"}", "joint.wire.start_speed={v_x = 0.3}"}};
  for (const auto& drive : drives) {
    std::vector<std::string> overrides = with_library();
    overrides.insert(overrides.end(), drive.begin(), drive.end());
    const PreparedMechanism p = prepare_case("user_elements/magnets.toml", overrides);
    const Series s = simulate(p, {"wire.x", "bead.position_z"});
    for (const double t : {1.0, 5.0}) {
      const double x = 0.2 + 0.1 * std::sin(3.0 * t);
      // 1e-8 in each of some hundred steps where the coordinate is integrated.
      EXPECT_NEAR(s.at(t)(0), x, 1e-6) << drive[0];
      EXPECT_NEAR(s.at(t)(1), x * x, 1e-6) << drive[0];
    }
  }
}

TEST_F(UserElements, RefuseWhatTheFileGetsWrong) {
  const auto refusal_with = [](std::vector<std::string> more) -> std::string {
    std::vector<std::string> overrides = with_library();
    overrides.insert(overrides.end(), more.begin(), more.end());
    try {
      prepare_case("user_elements/magnets.toml", overrides);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(refusal_with({"force.pull.element=magnt"}),
              HasSubstr("the library has no force of this name, did you mean \"magnet\"?"));
  EXPECT_THAT(refusal_with({"force.pull.library=lib_none.so"}), HasSubstr("there is no such file"));
  EXPECT_THAT(refusal_with({"force.pull.library=magnets.toml"}), HasSubstr("is no shared library"));
  EXPECT_THAT(refusal_with({"force.pull.values={core = 1}"}), HasSubstr("values.strength is missing"));
  EXPECT_THAT(refusal_with({"force.pull.markers=[\"ball\"]"}),
              HasSubstr("markers has 1 entries, 2 are wanted"));
  EXPECT_THAT(refusal_with({"joint.wire.drive={x = 1}"}), HasSubstr("the coordinate is driven"));
  EXPECT_THAT(refusal_with({"joint.wire.drive_speed={u = 1}"}),
              HasSubstr("the joint has no \"u\"; known are v_x"));
  EXPECT_THAT(refusal_with({"joint.wire.start={y = 1}"}), HasSubstr("the joint has no \"y\"; known are x"));
}

}  // namespace
}  // namespace flexura::mbs::cases
