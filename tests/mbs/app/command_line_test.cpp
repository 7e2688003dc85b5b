// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/terminal/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "mbs/base/documents/document.hpp"

namespace flexura::terminal {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;
using ::testing::internal::CaptureStderr;
using ::testing::internal::CaptureStdout;
using ::testing::internal::GetCapturedStderr;
using ::testing::internal::GetCapturedStdout;

struct Given {
  std::string file, kind = "tet10";
  std::vector<std::string> names;
  int count = 3;
  double size = 0.5;
  bool loud = false, quiet = false;
};

Given given;

Program program(std::function<int()> work) {
  Command mesh{"mesh", "mesh a part",
               [work](Options& options, const Verbosity& verbosity) -> std::function<int()> {
                 options.argument("FILE", given.file, "part")
                     .choice("--kind", given.kind, {"tet4", "tet10"}, "elements")
                     .option("--name", given.names, "NAME", "names")
                     .option("-n,--count", given.count, "N", "count")
                     .option("--size", given.size, "M", "size")
                     .flag("--loud", given.loud, "loud")
                     .example("prog mesh part.toml", "mesh it");
                 return [work, &verbosity] {
                   given.quiet = verbosity.quiet;
                   return work();
                 };
               }};
  return {.name = "prog", .version = "1.2.3", .summary = "Test.", .commands = {mesh}, .examples = {}};
}

struct Outcome {
  int code;
  std::string out, err;
};

Outcome run_words(
    std::vector<const char*> words, std::function<int()> work = [] { return 0; }) {
  words.insert(words.begin(), "prog");
  given = {};
  CaptureStdout();
  CaptureStderr();
  const int code = run(program(std::move(work)), static_cast<int>(words.size()), words.data());
  return {code, GetCapturedStdout(), GetCapturedStderr()};
}

TEST(CommandLine, OptionsFillTheirVariables) {
  EXPECT_EQ(run_words({"mesh", "part.toml", "--kind", "tet4", "--name", "a", "b", "-n", "7", "--size=0.25",
                       "--loud", "-q"})
                .code,
            0);
  EXPECT_EQ(given.file, "part.toml");
  EXPECT_EQ(given.kind, "tet4");
  EXPECT_THAT(given.names, ElementsAre("a", "b"));
  EXPECT_EQ(given.count, 7);
  EXPECT_EQ(given.size, 0.25);
  EXPECT_TRUE(given.loud);
  EXPECT_TRUE(given.quiet);
}

TEST(CommandLine, HelpAndVersion) {
  EXPECT_EQ(run_words({"--version"}).out, "prog 1.2.3\n");
  EXPECT_THAT(run_words({"--help"}).out, HasSubstr("  mesh  mesh a part\n"));
  const Outcome help = run_words({"mesh", "--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_THAT(help.out, HasSubstr("Examples:\n  prog mesh part.toml\n      mesh it\n"));
  EXPECT_THAT(help.out, HasSubstr("tet4|tet10=tet10"));
  EXPECT_EQ(run_words({"help", "mesh"}).out, help.out);
  EXPECT_EQ(run_words({}).code, 2);
}

TEST(CommandLine, RefusalsSayWhatWasMeant) {
  EXPECT_EQ(run_words({"mehs"}).err, "error: unknown command \"mehs\", did you mean \"mesh\"?\n");
  EXPECT_EQ(run_words({"solve"}).err, "error: unknown command \"solve\"; known are mesh\n");
  EXPECT_EQ(run_words({"--loud", "mesh"}).err,
            "error: the command comes first: prog COMMAND [OPTIONS]; commands are mesh\n");
  EXPECT_EQ(run_words({"mesh", "f", "--cuont", "3"}).err,
            "error: unknown option --cuont, did you mean --count?\n");
  EXPECT_EQ(run_words({"mesh", "f", "--xyz=3"}).err, "error: unknown option --xyz; see prog mesh --help\n");
  EXPECT_EQ(run_words({"mesh", "f", "g"}).err,
            "error: \"g\" is one argument too many; see prog mesh --help\n");
  EXPECT_EQ(run_words({"man", "mesh", "f"}).err,
            "error: \"f\" is one argument too many; write prog man mesh\n");
  EXPECT_EQ(run_words({"man", "mehs"}).err, "error: unknown command \"mehs\", did you mean \"mesh\"?\n");
  EXPECT_EQ(run_words({"completion", "tcsh"}).err,
            "error: there is no completion for \"tcsh\"; write bash, zsh or fish\n");
  EXPECT_EQ(run_words({"help", "mesh", "f"}).err,
            "error: \"f\" is one argument too many; write prog help mesh\n");
  EXPECT_EQ(run_words({"completion", "tcsh"}).code, 2);
  EXPECT_EQ(run_words({"mesh"}).err, "error: FILE is required; see prog mesh --help\n");
  EXPECT_THAT(run_words({"mesh", "f", "--kind", "tet5"}).err,
              HasSubstr("\"tet5\" is not a known choice, did you mean \"tet4\"?"));
  EXPECT_THAT(run_words({"mesh", "f", "-n", "many"}).err, HasSubstr("Could not convert: --count = many"));
  EXPECT_THAT(run_words({"mesh", "f", "-q", "-v"}).err,
              HasSubstr("--quiet and --verbose exclude each other"));
  for (const auto& words :
       std::vector<std::vector<const char*>>{{"mehs"}, {"mesh"}, {"mesh", "f", "--kind", "tet5"}}) {
    EXPECT_EQ(run_words(words).code, 2);
  }
}

TEST(CommandLine, ManualPageNamesEveryOption) {
  const std::string page = run_words({"man"}).out;
  for (const char* words : {".TH PROG 1", ".SH PROG MESH", "\\fBFILE\\fR\npart", "\\-\\-kind \\fIWORD\\fR",
                            "elements (tet4, tet10); default tet10", "prog mesh part.toml", "\\-\\-quiet"}) {
    EXPECT_THAT(page, HasSubstr(words));
  }
}

TEST(CommandLine, ACommandHasAManualPageOfItsOwn) {
  const std::string page = run_words({"man", "mesh"}).out;
  for (const char* words :
       {".TH PROG\\-MESH 1", ".SH NAME\nprog\\-mesh \\- mesh a part", ".B prog mesh\n[OPTIONS] FILE",
        ".SH DESCRIPTION\nmesh a part", "\\-\\-kind \\fIWORD\\fR", ".SH EXIT STATUS", ".BR prog (1)"}) {
    EXPECT_THAT(page, HasSubstr(words));
  }
}

// What the front door asks of a program beside it.
TEST(CommandLine, AProgramWithASinglePurposeDescribesItself) {
  const auto told = [](const char* word) {
    const char* const words[] = {"prog-mesh", word};
    CaptureStdout();
    EXPECT_EQ(run(program([] { return 0; }).commands[0], "1.2.3", 2, words), 0);
    return GetCapturedStdout();
  };
  EXPECT_EQ(told("--list-options"),
            "--kind --name -n --count --size --loud -q --quiet -v --verbose --help --version\n");
  EXPECT_THAT(told("--manual-section"), HasSubstr(".SH MESH\nmesh a part\n.TP\n\\fBFILE\\fR\n"));
  EXPECT_THAT(told("--version"), StartsWith("mesh 1.2.3\nlibraries: "));
}

TEST(CommandLine, WhatIsThrownBecomesAMessageAndAnExitCode) {
  const auto outcome = [](auto&& failure) {
    return run_words({"mesh", "f"}, [failure]() -> int { throw failure; });
  };
  EXPECT_EQ(outcome(input::InputError("a.toml:3: x: wrong")).err, "error: a.toml:3: x: wrong\n");
  EXPECT_EQ(outcome(input::InputError("x")).code, 2);
  EXPECT_EQ(outcome(std::invalid_argument("x")).code, 2);
  EXPECT_EQ(outcome(std::runtime_error("no convergence")).code, 1);
  EXPECT_EQ(outcome(std::runtime_error("no convergence")).err, "error: no convergence\n");
  EXPECT_EQ(outcome(std::bad_alloc()).code, 1);
  EXPECT_EQ(outcome(std::logic_error("x")).err,
            "error: a mistake of the program, not of the input: x; please report this with the input\n");
  EXPECT_EQ(run_words({"mesh", "f"}, [] { return 7; }).code, 7);
}

}  // namespace
}  // namespace flexura::terminal
