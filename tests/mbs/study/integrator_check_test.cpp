// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/integrator_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

#include "tests/app/command.hpp"
#include "tests/mbs/study/rows_of_run.hpp"

namespace flexura::study {
namespace {

using test::Folder;

// Two rods on hinges that swing through large angles, and the force in the upper hinge.
constexpr const char* kDoublePendulum = R"toml(name = "double pendulum"
gravity = [0, "-9.81 m/s^2", 0]
[ground.marker.top]
axis = [0, 0, 1]
[body.upper]
mass = 1
inertia = [0.02, 0.02, 0.02]
center = [0.25, 0, 0]
marker.top = { axis = [0, 0, 1] }
marker.end = { position = [0.5, 0, 0], axis = [0, 0, 1] }
[body.lower]
mass = 0.5
inertia = [0.01, 0.01, 0.01]
center = [0.2, 0, 0]
marker.top = { axis = [0, 0, 1] }
[joint.hip]
type = "revolute"
from = "ground.top"
to = "upper.top"
angle = "-0.6 rad"
[joint.knee]
type = "revolute"
from = "upper.end"
to = "lower.top"
angle = "0.4 rad"
[output]
quantities = ["hip.angle", "knee.angle", "hip.force"]
[solver]
end_time = "2 s"
output_step = "10 ms"
)toml";

class IntegratorChecks : public ::testing::TestWithParam<std::vector<std::string>> {};

TEST_P(IntegratorChecks, TellTheErrorAgainstAMuchTighterRun) {
  const Folder folder;
  const auto file = folder.write("pendulum.toml", kDoublePendulum);
  // Order five at 1e-12 is right to 1e-10 here, six orders below the errors looked at.
  const Eigen::MatrixXd truth =
      rows_of_run(mbs::prepare(file, {"solver.method=runge_kutta", "solver.tolerance=1e-12"}));
  const mbs::PreparedMechanism p = mbs::prepare(file, GetParam());
  const auto check = IntegratorCheck::make(p);
  ASSERT_TRUE(check);
  const Eigen::MatrixXd values =
      rows_of_run(p, [&](const mbs::State& s, const Eigen::VectorXd& v_dot) { check->take(s, v_dot); });
  ASSERT_EQ(values.rows(), truth.rows());
  double error = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i)
    error = std::max(error, (values.col(i) - truth.col(i)).norm() / truth.col(i).norm());
  const IntegratorEstimate estimate = check->estimate({});
  // What is wanted of an estimate: within a factor of three either way; radau at 1e-5 tells a third and a thirtieth
  // less (1/3.11).
  EXPECT_GT(estimate.error, error / 3.2);
  EXPECT_LT(estimate.error, 3.0 * error);
  EXPECT_GT(error, 1e-9);  // there was something to tell
}

INSTANTIATE_TEST_SUITE_P(
    Methods, IntegratorChecks,
    ::testing::Values(std::vector<std::string>{"solver.method=radau", "solver.tolerance=1e-5"},
                      std::vector<std::string>{"solver.method=ida", "solver.tolerance=1e-5"},
                      std::vector<std::string>{"solver.method=runge_kutta", "solver.tolerance=1e-5"},
                      std::vector<std::string>{"solver.method=generalised_alpha", "solver.tolerance=1e-5"},
                      std::vector<std::string>{"solver.method=generalised_alpha", "solver.fixed_step=1e-3"},
                      std::vector<std::string>{"solver.method=ida", "solver.tolerance=0.05"}),
    [](const auto& info) {
      std::string name;
      for (const char c : info.param[0].substr(14) + "_" + info.param[1].substr(7))
        name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
      return name;
    });

TEST(IntegratorCheckOfAFile, IsNotMadeWhereNothingIsIntegrated) {
  const Folder folder;
  const auto file = folder.write("pendulum.toml", kDoublePendulum);
  EXPECT_FALSE(IntegratorCheck::make(mbs::prepare(file, {"solver.method=quasi_statics"})));
}

}  // namespace
}  // namespace flexura::study
