// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/integrator_check.hpp"

#include <gtest/gtest.h>

#include <cctype>
#include <cmath>
#include <string>
#include <vector>

#include "tests/app/command.hpp"

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
  // Rows of the run, each its outputs.
  const auto outputs = [&](const mbs::PreparedMechanism& p, IntegratorCheck* check) {
    const auto which = mbs::select_quantities(*p.mechanism, p.file.outputs);
    const auto scratch = p.mechanism->make_scratch();
    std::vector<Eigen::VectorXd> out;
    mbs::RunCallbacks callbacks;
    callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
      p.mechanism->evaluate(which, s, v_dot, *scratch,
                            out.emplace_back(static_cast<Eigen::Index>(which.size())));
      if (check) check->take(s, v_dot);
    };
    EXPECT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
    return out;
  };
  // Order five at 1e-12 is right to 1e-10 here, six orders below the errors looked at.
  const auto truth =
      outputs(mbs::prepare(file, {"solver.method=runge_kutta", "solver.tolerance=1e-12"}), nullptr);
  const mbs::PreparedMechanism p = mbs::prepare(file, GetParam());
  const auto check = IntegratorCheck::make(p);
  ASSERT_TRUE(check);
  const auto values = outputs(p, check.get());
  ASSERT_EQ(values.size(), truth.size());
  double error = 0.0;
  for (Eigen::Index i = 0; i < 3; ++i) {
    double square = 0.0, size = 0.0;
    for (std::size_t k = 0; k < truth.size(); ++k) {
      square += std::pow(values[k](i) - truth[k](i), 2);
      size += std::pow(truth[k](i), 2);
    }
    error = std::max(error, std::sqrt(square / size));
  }
  const IntegratorEstimate estimate = check->estimate({});
  // What is wanted of an estimate: within a factor of three either way.
  EXPECT_GT(estimate.error, error / 3.0);
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
