// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "tests/mbs/cases/case_run.hpp"
#include "tests/reference.hpp"

/// Single joints against MSC ADAMS, reactions included.  Limits are those of the published tables
/// (data/README.md).
namespace flexura::mbs::cases {
namespace {

struct Limits {
  const char* name;
  double position, velocity, force;
  bool has_torque;
};

class AdamsJoint : public ::testing::TestWithParam<Limits> {};

TEST_P(AdamsJoint, MovesAndPullsAsPublished) {
  const Limits limits = GetParam();
  const PreparedMechanism p = prepare_case(fmt::format("adams_joints/{}.toml", limits.name));
  std::vector<std::string> names;
  for (const char* q : {"position", "velocity"})
    for (const char* axis : {"x", "y", "z"}) names.push_back(fmt::format("pendulum.{}_{}", q, axis));
  const bool on_joint = limits.name != std::string("transpring_case02");
  for (const char* q : {"force", "torque"})
    for (const char* axis : {"x", "y", "z"})
      if (on_joint) names.push_back(fmt::format("joint.{}_{}", q, axis));
  if (!on_joint) names.push_back("spring.force");
  const Series s = simulate(p, names);
  const Matrix3d R_WF =
      p.mechanism->description().markers[p.mechanism->description().joints[0].marker_F].X_BP.R;

  std::ifstream in(
      fmt::format("{}/tests/mbs/cases/data/adams_joints/{}.txt", FLEXURA_SOURCE_DIR, limits.name));
  ASSERT_TRUE(in.good());
  int rows = 0;
  double farthest = 0.0;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("#")) continue;
    std::istringstream numbers(line);
    double t;
    numbers >> t;
    Eigen::Matrix<double, 12, 1> wanted;
    for (double& x : wanted) numbers >> x;
    const Eigen::VectorXd& row = s.at(t);
    EXPECT_LT((row.head<3>() - wanted.head<3>()).cwiseAbs().maxCoeff(), limits.position) << t;
    farthest = std::max(farthest, (row.head<3>() - wanted.head<3>()).cwiseAbs().maxCoeff());
    EXPECT_LT((row.segment<3>(3) - wanted.segment<3>(3)).cwiseAbs().maxCoeff(), limits.velocity) << t;
    if (on_joint) {
      const Vector3d on_ground = -R_WF * row.segment<3>(6), torque = -R_WF * row.segment<3>(9);
      EXPECT_LT((on_ground - wanted.segment<3>(6)).cwiseAbs().maxCoeff(), limits.force) << t;
      // The body is 2 m long: an error of the force's size at its middle.
      if (limits.has_torque) {
        EXPECT_LT((torque - wanted.tail<3>()).cwiseAbs().maxCoeff(), 2.0 * limits.force) << t;
      }
    } else {
      EXPECT_NEAR(std::abs(row(6)), wanted.segment<3>(6).norm(), limits.force) << t;
    }
    ++rows;
  }
  EXPECT_EQ(rows, 51);
  flexura::test::expect_reference(std::string(limits.name) + ", largest error of the position in 51 rows",
                                  "m", farthest, 0.0, limits.position,
                                  {"MSC ADAMS: single joints", "that of the published tables"});
}

INSTANTIATE_TEST_SUITE_P(Cases, AdamsJoint,
                         ::testing::Values(Limits{"revolute_case01", 2e-5, 2e-5, 2e-3, true},
                                           Limits{"revolute_case02", 2e-5, 2e-5, 2e-3, true},
                                           Limits{"spherical_case01", 1e-3, 3e-3, 2e-2, true},
                                           Limits{"universal_case01", 1e-3, 3e-3, 2e-2, true},
                                           Limits{"prismatic_case01", 1e-3, 1e-3, 2e-2, true},
                                           Limits{"cylindrical_case01", 1e-3, 1e-3, 2e-2, true},
                                           // ADAMS counts the spring's torque among the reactions.
                                           Limits{"rotspring_case02", 2e-5, 2e-5, 2e-3, false},
                                           Limits{"transpring_case02", 2e-5, 2e-5, 2e-3, false}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace flexura::mbs::cases
