// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Titles and names that move the terminal (terminal/) or leave the comment that they stand in (octave/).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/app/command.hpp"

namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using test::Outcome;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kShown = "\\x1b[2J\\x1b]0;pwned\\x07\\u009b31mred\\u202eevil";

std::string sample(const std::string& name) {
  return std::string(FLEXURA_SOURCE_DIR) + "/tests/found/hostile/" + name;
}

TEST(HostileTitles, AreShownAndNotObeyed) {
  const Folder folder;
  const std::string title = sample("terminal/title.toml"), results = folder / "r.h5",
                    part = folder / "p.se.h5";
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"statics", title}, {"eigen", title}, {"check", title}, {"assemble", title}})
    EXPECT_THAT(test::run("flexura", words).out, StartsWith(kShown)) << words.front();
  ASSERT_EQ(test::run("flexura", {"simulate", title, "-q", "-o", results}).exit_code, 0);
  EXPECT_THAT(test::run("flexura", {"view", results, "--summary"}).out, HasSubstr(kShown));
  ASSERT_EQ(test::run("flexura", {"reduce", sample("terminal/part_title.toml"), "-q", "-o", part}).exit_code,
            0);
  for (const char* command : {"modes", "check"})
    EXPECT_THAT(test::run("flexura", {command, part}).out, StartsWith(kShown)) << command;
  // JSON says the same.
  const auto json = nlohmann::json::parse(test::run("flexura", {"statics", title, "--json"}).out);
  EXPECT_EQ(json["name"], kShown);
}

TEST(HostileTitles, OfPathsAndOptionsAreShown) {
  const Outcome missing = test::run("flexura", {"simulate", "a\nb.toml"});
  EXPECT_EQ(std::count(missing.err.begin(), missing.err.end(), '\n'), 1);
  EXPECT_THAT(missing.err, StartsWith("error: a\\nb.toml: there is no such file"));
  EXPECT_THAT(
      test::run("flexura", {"simulate", sample("terminal/title.toml"), "--run", "\u202E\u009b31m"}).err,
      HasSubstr("no run \"\\u202e\\u009b31m\""));
}

TEST(HostileTitles, StayInTheirComment) {
  const Folder folder;
  const auto linearize = [&](const std::string& output) {
    return test::run("flexura", {"linearize", sample("octave/title.toml"), "--input", "hinge.angle",
                                 "--frozen", "-o", folder / output})
        .exit_code;
  };
  ASSERT_EQ(linearize("x.m"), 0);
  EXPECT_THAT(test::read_text(folder / "x.m"), StartsWith("% x system('touch PWNED'); % : x' = A x + B u"));
  EXPECT_THAT(test::read_text(folder / "x.m"), HasSubstr("SI units\nstates = {"));
  ASSERT_EQ(linearize("x.mtx"), 0);
  EXPECT_THAT(
      test::read_text(folder / "x_A.mtx"),
      StartsWith("%%MatrixMarket matrix coordinate real general\n% A of x system('touch PWNED'); % : x'"));
}

}  // namespace
}  // namespace flexura
