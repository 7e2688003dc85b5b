// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/estimate/shadows.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"
#include "tests/mbs/study/clamped_bar.hpp"
#include "tests/mbs/study/rows_of_run.hpp"
#include "tests/mbs/superelement/box_beam.hpp"

namespace flexura::study {
namespace {

using test::Folder;

class ShadowsOfABar : public ::testing::Test {
 protected:
  void SetUp() override {
    superelement::write(folder_ / "beam.se.h5", superelement::testing::make_box_beam());
    file_ = folder_.write("bar.toml", bars::kClamped);
  }

  struct Run {
    Eigen::MatrixXd values;  // rows x outputs
    TruncationEstimate estimate;
    bool has_estimate = false;
  };
  Run run(const std::vector<std::string>& overrides) const {
    const mbs::PreparedMechanism p = mbs::prepare(file_, overrides);
    const auto shadows = Shadows::make(p, file_, overrides);
    Run out;
    out.values = rows_of_run(p, [&](const mbs::State& s, const Eigen::VectorXd& v_dot) {
      if (shadows) shadows->take(s, v_dot);
    });
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

TEST_F(ShadowsOfABar, OfAOneWayBodyGiveItsTruncation) {
  // The wall does not feel the beam, so one-way and coupled deformation are the same and what is left is the
  // truncation of its clamped modes; tolerance as above.
  const Run truth = run({});
  const Run reduced = run({"body.beam.fidelity=ked", "body.beam.modes=1", "body.beam.attachments=none"});
  ASSERT_TRUE(reduced.has_estimate);
  const double error = std::sqrt((reduced.values.col(0) - truth.values.col(0)).squaredNorm() /
                                 static_cast<double>(truth.values.rows()));
  EXPECT_NEAR(reduced.estimate.outputs[0].rms / error, 1.0, 0.05);
}

// A damping ratio is of the modes that frame and boundary condition make: against the same ratio of free modes a body of
// which nothing is left out was told to be 92 % off, for its damping alone.
TEST_F(ShadowsOfABar, TakeItsOwnFrameForTheMeaningOfItsDamping) {
  const std::vector<std::string> held = {"body.beam.frame=joint_fixed", "body.beam.damping=0.2"};
  const Run truth = run(held);
  EXPECT_FALSE(truth.has_estimate);
  std::vector<std::string> few = held;
  few.emplace_back("body.beam.modes=1");
  const Run reduced = run(few);
  ASSERT_TRUE(reduced.has_estimate);
  const double error = std::sqrt((reduced.values.col(0) - truth.values.col(0)).squaredNorm() /
                                 static_cast<double>(truth.values.rows()));
  EXPECT_NEAR(reduced.estimate.outputs[0].rms / error, 1.0, 0.05);  // as above
}

// Its matrices turn with the mechanism: where they lag, the correction grows with every turn, until an error
// of a few per mille is told as 100 %.  With rows h apart generalised-alpha errs by (omega h)^2 / 12 per
// radian in what turns with the shaft (omega h = 0.04: 4e-3 of it over these 32 radians), on the safe side
// here; ten times the error bounds that, and a third of it what the rows do not resolve.
TEST_F(ShadowsOfABar, StayNearTheErrorWhileTheMechanismTurns) {
  file_ = folder_.write("engine.toml", bars::kTurning);
  const Run truth = run({}), rigid = run({"body.beam.fidelity=rigid"});
  ASSERT_TRUE(rigid.has_estimate);
  for (std::size_t i = 0; i < rigid.estimate.outputs.size(); ++i) {
    const OutputEstimate& output = rigid.estimate.outputs[i];
    const auto column = static_cast<Eigen::Index>(i);
    const double error = std::sqrt((rigid.values.col(column) - truth.values.col(column)).squaredNorm() /
                                   static_cast<double>(truth.values.rows()));
    EXPECT_GT(output.rms, error / 3.0) << output.name;
    EXPECT_LT(output.rms, error * 10.0) << output.name;
  }
}

}  // namespace
}  // namespace flexura::study
