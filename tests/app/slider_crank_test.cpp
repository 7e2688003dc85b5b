// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The elastic coupler of cases/slider_crank as three bodies that have nothing but its section in common:
// modes in a floating frame with geometric stiffening, absolute nodal coordinates, and rigid segments on
// springs.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

class ElasticCoupler : public testing::Test {
 protected:
  void SetUp() override {
    const Outcome reduced = run("flexura", {"reduce", case_ / "coupler.toml", "-q", "-o", superelement_});
    ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  }

  /// Of the middle [m], `angle` / `speed` long.
  Eigen::VectorXd deflection(const std::string& fidelity, double speed, double angle,
                             const std::vector<std::string>& keys = {}) {
    const std::string output = folder_ / "run.h5";
    std::vector<std::string> arguments = {
        "simulate", case_ / "slider_crank.toml", "-q", "--no-estimate", "-o", output};
    const auto set = [&](const std::string& pair) { arguments.insert(arguments.end(), {"--set", pair}); };
    set("body.coupler.superelement=" + superelement_);
    set("body.coupler.fidelity=" + fidelity);
    set(fmt::format("parameters.speed={}", speed));
    set(fmt::format("solver.end_time={:.6g}", angle / speed));
    set(fmt::format("solver.output_step={:.6g}", 0.01 / speed));
    set("solver.method=radau");
    for (const std::string& pair : keys) set(pair);
    const Outcome simulated = run("flexura", arguments);
    EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
    const results::Results results = results::read(output);
    for (std::size_t j = 0; j < results.runs.at(0).quantities.size(); ++j)
      if (results.runs[0].quantities[j].name == "deflection")
        return results.runs[0].values.col(static_cast<Eigen::Index>(j));
    throw std::logic_error("no deflection in the results");
  }

 private:
  const Folder folder_;
  const std::filesystem::path case_ = std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases/slider_crank";
  const std::string superelement_ = folder_ / "coupler.se.h5";
};

double largest(const Eigen::VectorXd& x) {
  return x.cwiseAbs().maxCoeff();
}

// Speed times time; the run-up, a turn, takes 4 pi.
constexpr double kShort = 15.0, kLong = 20.0;
const std::string kSixteen = "body.coupler.beam.elements=16", kLoose = "solver.tolerance=1e-5";

TEST_F(ElasticCoupler, BendsAlikeAsModesAsSegmentsAndInAbsoluteCoordinates) {
  const Eigen::VectorXd full = deflection("modal-stiffened", 100, kShort);
  // Meshes err by n^-2: 16 segments by 0.1 %, 16 ANCF elements by 0.3 % (8: 1.3 %).
  EXPECT_LT(largest(deflection("segments", 100, kShort, {kSixteen, kLoose}) - full), 0.005 * largest(full));
  EXPECT_LT(largest(deflection("ancf", 100, kShort, {kSixteen, kLoose}) - full), 0.01 * largest(full));
  // The slider and half the coupler push with a tenth of Euler's load, of which these modes know nothing.
  EXPECT_GT(largest(deflection("modal", 100, kShort) - full), 0.04 * largest(full));
}

TEST_F(ElasticCoupler, BendsAlikeUnderTwoThirdsOfEulersLoad) {
  const double full = largest(deflection("modal-stiffened", 250, kLong));
  // One end turned by 0.29 rad against the other: displacements linear in the modes err by 0.29^2 / 6 = 1.4
  // %.
  EXPECT_NEAR(largest(deflection("segments", 250, kLong, {kSixteen, kLoose})), full, 0.02 * full);
  EXPECT_GT(largest(deflection("modal", 250, kLong)), 1.5 * full);
}

TEST_F(ElasticCoupler, StartsUndeformedAndWithoutBendingRatesHoweverItIsComputed) {
  const std::string jump = "joint.shaft.drive=speed * t";
  const Eigen::VectorXd full = deflection("modal-stiffened", 100, 3.0, {jump});
  // As above, and 4 periods of free vibration, which a mesh has wrong by n^-2, too.
  EXPECT_LT(largest(deflection("segments", 100, 3.0, {jump, kSixteen, kLoose}) - full), 0.02 * largest(full));
}

}  // namespace
}  // namespace flexura::test
