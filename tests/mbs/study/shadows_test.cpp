// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/shadows.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "mbs/study/choose.hpp"
#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::study {
namespace {

using test::Folder;
using ::testing::Contains;
using ::testing::HasSubstr;

// A steel bar clamped at one end, shaken at the other.  Clamped, its first bending along y has 38 Hz.
const char* const kClamped = R"toml(
gravity = [0, 0, 0]
[parameters]
omega = 150
[ground.marker.wall]
position = [0.3, -0.2, 0.1]
[body.beam]
superelement = "beam.se.h5"
[joint.wall]
type = "fixed"
from = "ground.wall"
to = "beam.left"
[force.tip]
type = "force"
marker = "beam.right"
y = "100 * (1 - cos(omega * t))"
[measure.sway]
type = "position"
from = "ground.wall"
to = "beam.right"
direction = [0, 1, 0]
[output]
quantities = ["sway", "wall.force"]
[solver]
end_time = "0.1 s"
output_step = "0.2 ms"
tolerance = 1e-8
)toml";

class ShadowsOfABar : public ::testing::Test {
 protected:
  void SetUp() override {
    superelement::write(folder_ / "beam.se.h5", superelement::testing::make_box_beam());
    file_ = folder_.write("bar.toml", kClamped);
  }

  struct Run {
    Eigen::MatrixXd values;  // rows x outputs
    TruncationEstimate estimate;
    bool has_estimate = false;
  };
  Run run(const std::vector<std::string>& overrides) const {
    const mbs::PreparedMechanism p = mbs::prepare(file_, overrides);
    const auto shadows = Shadows::make(p, file_, overrides);
    const auto which = mbs::select_quantities(*p.mechanism, p.file.outputs);
    const auto scratch = p.mechanism->make_scratch();
    std::vector<Eigen::VectorXd> rows;
    mbs::RunCallbacks callbacks;
    callbacks.row = [&](const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::EnergyAccount&) {
      rows.emplace_back(static_cast<Eigen::Index>(which.size()));
      p.mechanism->evaluate(which, s, v_dot, *scratch, rows.back());
      if (shadows) shadows->take(s, v_dot);
    };
    EXPECT_TRUE(mbs::run(*p.mechanism, p.state, p.v_dot, p.options, callbacks).complete);
    Run out;
    out.values.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(which.size()));
    for (std::size_t i = 0; i < rows.size(); ++i) out.values.row(static_cast<Eigen::Index>(i)) = rows[i];
    out.has_estimate = shadows != nullptr;
    if (shadows) out.estimate = shadows->estimate();
    return out;
  }

  Folder folder_;
  std::filesystem::path file_;
};

TEST_F(ShadowsOfABar, GiveTheErrorOfALinearModelItself) {
  // Small deflections: the model is linear, so the corrected run is the one with all modes and the estimate
  // is the error (effectivity 1).  What differs is the shadows' fixed step: with h = 0.2 ms and the fastest
  // motion that carries energy (second clamped bending, 240 Hz: omega h = 0.3) generalised-alpha errs by
  // (omega h)^2 / 12 = 1 % of that part in phase per radian; the first mode and the load (omega h < 0.05)
  // carry nearly all of the deflection.  5 % bounds it.
  const Run truth = run({});
  EXPECT_FALSE(truth.has_estimate);
  for (const std::vector<std::string>& choice : {std::vector<std::string>{"body.beam.fidelity=rigid"},
                                                 {"body.beam.modes=1"},
                                                 {"body.beam.modes=3"},
                                                 {"body.beam.modes=5"}}) {
    const Run reduced = run(choice);
    ASSERT_TRUE(reduced.has_estimate);
    const double error = std::sqrt((reduced.values.col(0) - truth.values.col(0)).squaredNorm() /
                                   static_cast<double>(truth.values.rows()));
    ASSERT_EQ(reduced.estimate.outputs[0].name, "sway");
    EXPECT_NEAR(reduced.estimate.outputs[0].rms / error, 1.0, 0.05) << choice.front();
    EXPECT_EQ(reduced.estimate.by_body.at(0).body, "beam");
  }
}

TEST_F(ShadowsOfABar, SlowLoadLeavesTheBodyRigidWhereOnlyForcesCount) {
  // At 5 rad/s the reaction differs by (5 / 240)^2 = 0.04 %, and the deflection is not asked for.
  const ChosenRun slow = run_within(
      0.01, file_, {"parameters.omega=5", "solver.end_time=1", "output.quantities=[\"wall.force\"]"}, {});
  ASSERT_TRUE(slow.result.complete);
  EXPECT_THAT(slow.reasons, Contains(HasSubstr("beam: rigid: its deformation changes outputs by")));
  EXPECT_EQ(slow.screening_wall, 0.0);  // the screening is the run
  EXPECT_FALSE(slow.rows.empty());
}

TEST_F(ShadowsOfABar, AskedForItsDeflectionItGetsModesAndMeetsTheAccuracy) {
  const Run truth = run({});
  const double size = std::sqrt(truth.values.col(0).squaredNorm() / static_cast<double>(truth.values.rows()));
  for (const double accuracy : {0.1, 0.01}) {
    const ChosenRun chosen = run_within(accuracy, file_, {}, {});
    EXPECT_THAT(chosen.reasons, Contains(HasSubstr("beam: modal, "))) << accuracy;
    const auto which = mbs::select_quantities(*chosen.prepared.mechanism, {"sway"});
    const auto scratch = chosen.prepared.mechanism->make_scratch();
    ASSERT_EQ(static_cast<Eigen::Index>(chosen.rows.size()), truth.values.rows());
    double sum = 0.0;
    Eigen::VectorXd y(1);
    for (std::size_t i = 0; i < chosen.rows.size(); ++i) {
      chosen.prepared.mechanism->evaluate(which, chosen.rows[i].state, chosen.rows[i].v_dot, *scratch, y);
      sum += std::pow(y(0) - truth.values(static_cast<Eigen::Index>(i), 0), 2);
    }
    EXPECT_LT(std::sqrt(sum / static_cast<double>(chosen.rows.size())) / size, accuracy);
  }
  EXPECT_THROW(run_within(2.0, file_, {}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::study
