// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Parts of users, from their CAD files (user/, reduce/): what is said of a mesh against what is known of the part. The
// true frequencies are those of refined meshes (docs/accuracy.md, docs/mesh_error.md): of the rod extrapolated from three, of the
// bracket (4172 and 5144 Hz on the finest, less 0.15 %, half of what is estimated of it) and of the crank arm those of graded ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/found/parts.hpp"

namespace flexura::test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class UserParts : public Parts {
 protected:
  /// The user's files, in the test's folder.
  std::filesystem::path bring(const std::string& folder, const std::vector<std::string>& names) {
    for (const std::string& name : names)
      std::filesystem::copy(std::filesystem::path(FLEXURA_SOURCE_DIR) / "tests/found" / folder / name,
                            folder_ / name, std::filesystem::copy_options::overwrite_existing);
    return folder_ / names.front();
  }

  /// The first frequencies: too high, by what is estimated within its factor of two, or by less than 0.1 %.
  static void expect_judged(const nlohmann::json& report, const std::vector<double>& truth) {
    for (std::size_t k = 0; k < truth.size(); ++k) {
      const nlohmann::json& mode = report["mesh_error"]["modes"].at(k);
      const double error = mode["hz"].get<double>() / truth[k] - 1.0, said = mode["frequency_error"];
      EXPECT_GT(error, -1e-4) << k;  // the digits of the truth
      EXPECT_LT(error, std::max(2.0 * said, 1e-3)) << k;
      EXPECT_GT(error, 0.5 * said - 1e-3) << k;
    }
  }
};

// A mesh size of 4 m (mistyped) and linear tetrahedra, trusted at 91 % and 77 % of error; the good file that they replaced.
TEST_F(UserParts, ARodIsNotTrustedOnAMeshThatDoesNotResolveIt) {
  const auto rod = bring("user", {"rod.toml", "rod.step"});
  const std::vector<std::string> few = {"--modes", "2", "--set", "recovery.stress=false"};
  const auto with = [&](std::vector<std::string> options) {
    options.insert(options.end(), few.begin(), few.end());
    return reduce(rod, options);
  };
  const Reduced good = with({"--mesh-size", "14 mm"});
  ASSERT_EQ(good.outcome.exit_code, 0) << good.outcome.err;
  expect_judged(good.report, {392.21, 1159.4});
  const std::string kept = read_text(output());
  for (const std::vector<std::string>& options :
       {std::vector<std::string>{"--mesh-size", "4", "--set", "mesh.order=1"}, {"--set", "mesh.order=1"}}) {
    const Outcome refused = with(options).outcome;
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_THAT(refused.err, AllOf(HasSubstr("does not resolve the part"), HasSubstr("is kept")));
    EXPECT_THAT(refused.out, Not(HasSubstr("to be trusted")));
    EXPECT_TRUE(read_text(output()) == kept);
  }
}

// The run with the rod of linear tetrahedra: its error by source knows that the mesh is no good.
TEST_F(UserParts, AnUnresolvedMeshIsNoSmallPartOfARunsError) {
  const auto run_file = bring("user", {"mesh_o1.toml", "rod.toml", "rod.step"});
  const Outcome reduced =
      run("flexura-reduce", {folder_ / "rod.toml", "--set", "mesh.order=1", "--set", "recovery.stress=false",
                             "--modes", "4", "-o", folder_ / "rod_o1.se.h5"});
  ASSERT_EQ(reduced.exit_code, 0) << reduced.err;
  EXPECT_THAT(reduced.err, HasSubstr("of order 1"));
  const Outcome outcome = run("flexura", {"simulate", run_file, "-o", folder_ / "run.h5"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out + outcome.err, HasSubstr("mesh and reduction of bar"));
  EXPECT_THAT(outcome.out + outcome.err,
              testing::ContainsRegex("bar[^\n]*unknown|unknown[^\n]*bar|[5-9][0-9][.0-9]* %"));
}

TEST_F(UserParts, ACrankArmIsJudgedByItsMesh) {
  const Reduced r = reduce(bring("user", {"crank_arm.toml", "crank_arm.step"}),
                           {"--mesh-size", "8 mm", "--modes", "20", "--set", "recovery.stress=false"});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  expect_judged(r.report, {2758.0, 5006.0});
}

TEST_F(UserParts, ABracketIsJudgedByItsMesh) {
  const Reduced r = reduce(bring("user", {"bracket.toml", "bracket.step"}),
                           {"--mesh-size", "8 mm", "--modes", "16", "--set", "recovery.stress=false"});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  expect_judged(r.report, {4166.0, 5136.0});
}

// "Within 1 %" of a stepped shaft held at its ends, whose mesh is 2.8 % off.
TEST_F(UserParts, AShaftHeldAtItsEndsIsNotWithinOnePercent) {
  const Reduced r = reduce(bring("reduce", {"av.toml", "stepped_shaft.step"}), {"--compare", "6"});
  ASSERT_EQ(r.outcome.exit_code, 0) << r.outcome.err;
  EXPECT_GT(r.report["mesh_error"]["modes"].at(0)["frequency_error"].get<double>(), 0.014);
  EXPECT_THAT(r.outcome.out,
              AllOf(Not(HasSubstr("to be trusted: frequencies within 1 %")), HasSubstr("not within 1 %")));
}

}  // namespace
}  // namespace flexura::test
