// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Templates: xacro expands them where it is there, and none of the Python that it would evaluate comes from a file that nobody trusts.
#include <gmock/gmock.h>

#include <random>

#include "import/urdf/templates.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// A program of this name that is told once it runs, before all others.
class WithXacro : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::getenv("PATH");
    fs::create_directories(folder_ / "bin");
    folder_.write("expanded.urdf", robot(link("made")));
    write_program("cat " + (folder_ / "expanded.urdf").string());
    ::setenv("PATH", ((folder_ / "bin").string() + ":" + path_).c_str(), 1);
  }
  void TearDown() override { ::setenv("PATH", path_.c_str(), 1); }

  void write_program(const std::string& line) {
    const auto program =
        folder_.write("bin/xacro", "#!/bin/sh\ntouch " + (folder_ / "ran").string() + "\n" + line + "\n");
    fs::permissions(program, fs::perms::owner_all);
  }
  Outcome import(const std::string& text, const std::vector<std::string>& more = {}) {
    fs::remove(folder_ / "ran");
    fs::remove_all(folder_ / "out");
    std::vector<std::string> words = {"import", folder_.write("r.urdf.xacro", text), "-o", folder_ / "out"};
    words.insert(words.end(), more.begin(), more.end());
    return run("flexura", words);
  }
  bool ran() const { return fs::exists(folder_ / "ran"); }

  Folder folder_;
  std::string path_;
};

const std::string kTemplate = robot(R"(<xacro:property name="m" value="${2 * pi**2 / 3.5e-1}"/>
  <xacro:macro name="l" params="name *origin"><link name="${name}_link"><inertial><mass value="${m*sin(0.1)}"/></inertial></link></xacro:macro>
  <xacro:l name="a"/>)");

TEST_F(WithXacro, ArithmeticIsExpanded) {
  const Outcome outcome = import(kTemplate);
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(read_text(folder_ / "out/mechanism.toml"), HasSubstr("[body.made]"));
  EXPECT_THAT(outcome.err, HasSubstr("expanded by xacro"));
}

TEST_F(WithXacro, CodeIsNotRunUntilSomebodySaysSo) {
  const std::string code = robot("<link name=\"${__import__('os').system('true')}\"/>");
  const Outcome refused = import(code);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("r.urdf.xacro:2: \"${__import__"));
  EXPECT_THAT(refused.err, HasSubstr("--xacro run"));
  EXPECT_FALSE(ran());
  EXPECT_EQ(import(code, {"--xacro", "run"}).exit_code, 0);
  EXPECT_TRUE(ran());
}

TEST_F(WithXacro, IncludedFilesAreLookedThrough) {
  const std::string including = robot("<xacro:include filename=\"$(find arm)/b.xacro\"/>");
  EXPECT_THAT(import(including).err, HasSubstr("is included and not found here"));
  EXPECT_FALSE(ran());
  fs::create_directories(folder_ / "arm");
  folder_.write("arm/b.xacro", robot("<xacro:include filename=\"../r.urdf.xacro\"/>"));  // and round
  EXPECT_EQ(import(including).exit_code, 0);
  folder_.write("arm/b.xacro", robot("<link name=\"$(eval 1)\"/>"));
  EXPECT_THAT(import(including).err, HasSubstr("b.xacro:2: \"$(eval 1)\" is more than arithmetic"));
}

TEST_F(WithXacro, WhatItCannotExpandIsSaid) {
  write_program("echo undefined macro >&2; exit 2");
  const Outcome outcome = import(kTemplate);
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("xacro cannot expand it (undefined macro"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

// Formulas as macros have them pass; with one piece that calls, subscripts or names an attribute none does.
TEST(XacroTemplates, OnlyArithmeticPasses) {
  const std::vector<std::string> harmless = {"1",       "2.5e-3",    "pi",     "mass_1", "sin(radians(30))",
                                             "(a+b)",   "max(a, 2)", "x ** 2", "'left'", "-.5",
                                             "a == 'b'"};
  const std::vector<std::string> operators = {" + ", "*", "/", " - ", " % ", " if a > b else ", " and ", "<"};
  const std::vector<std::string> code = {"__import__('os')",
                                         "f(1)",
                                         "a.b",
                                         "a.b()",
                                         "x[0]",
                                         "{1: 2}",
                                         "lambda: 0",
                                         "exec('1')",
                                         "open('x')",
                                         "xacro.load_yaml('x')",
                                         "'a'.join(b)",
                                         "(1).real",
                                         "9**99",
                                         "9**9**9",
                                         "9**x",
                                         "a; b",
                                         "\\x41",
                                         "load_yaml('x')",
                                         "[i for i in x]",
                                         "`id`",
                                         "@a",
                                         "a := 1",
                                         "eval('1')",
                                         "getattr (a, 'b')"};
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    const auto one_of = [&](const auto& list) { return list[random() % list.size()]; };
    std::vector<std::string> terms;
    for (int k = 1 + static_cast<int>(random() % 6); k > 0; --k) terms.push_back(one_of(harmless));
    const auto joined = [&] {
      std::string all = terms.front();
      for (std::size_t k = 1; k < terms.size(); ++k) all += one_of(operators) + terms[k];
      return all;
    };
    const std::string good = joined();
    EXPECT_TRUE(import::urdf::is_arithmetic(good)) << good;
    terms[random() % terms.size()] = one_of(code);
    const std::string bad = joined();
    EXPECT_FALSE(import::urdf::is_arithmetic(bad)) << bad;
    const auto pieces = [](std::string formula) {
      for (const auto& [sign, word] :
           {std::pair("&", "&amp;"), std::pair("<", "&lt;"), std::pair("\"", "&quot;")})
        for (auto at = formula.find(sign); at != std::string::npos; at = formula.find(sign, at + 1))
          formula.replace(at, 1, word);
      return import::urdf::look_through("<robot name=\"r\">\n<xacro:property name=\"p\" value=\"1 ${" +
                                            formula + "} \"/><b>${" + formula + "}</b></robot>",
                                        "r.xacro")
          .code.size();
    };
    EXPECT_EQ(pieces(good), 0U) << good;
    EXPECT_EQ(pieces(bad), 2U) << bad;
  }
}

}  // namespace
}  // namespace flexura::test
