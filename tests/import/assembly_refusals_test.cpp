// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Assemblies that are none, damaged or hostile.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "tests/import/assembly_run.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using namespace drawing;
using testing::HasSubstr;

struct BadStep {
  std::string name, text, says;
};

class BadAssembly : public testing::TestWithParam<BadStep> {};

TEST_P(BadAssembly, EndsInOneSentenceAndWritesNothing) {
  const Folder folder;
  const auto file = folder.write("a.step", GetParam().text);
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().says));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

std::string engine_text() {
  return read_text(FLEXURA_SOURCE_DIR "/cases/assembly/engine.step");
}

INSTANTIATE_TEST_SUITE_P(
    All, BadAssembly,
    testing::Values(
        BadStep{"empty", "", "is no STEP file"}, BadStep{"text", "hello", "is no STEP file"},
        BadStep{"header_alone", "ISO-10303-21;\nHEADER;\nENDSEC;\n", "a.step"},
        BadStep{
            "no_data",
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
            "FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n",
            "a.step"}),
    [](const auto& info) { return info.param.name; });

TEST(AssemblyImport, CutShortItEndsInASentenceOrIsWhatIsLeft) {
  const Folder folder;
  const std::string whole = engine_text();
  for (const double part : {0.3, 0.9}) {
    const auto file = folder.write(
        "cut.step", whole.substr(0, static_cast<std::size_t>(part * static_cast<double>(whole.size()))));
    const Outcome outcome = run("flexura", {"import", file, "-o", folder / "cut"});
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err << outcome.out;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "cut"));
  }
}

TEST(AssemblyImport, UnknownGroundAndForeignOptionsAreRefused) {
  const Folder folder;
  const std::string engine = FLEXURA_SOURCE_DIR "/cases/assembly/engine.step";
  EXPECT_THAT(run("flexura", {"import", engine, "-o", folder / "out", "--ground", "bolt"}).err,
              HasSubstr("0 bodies of the assembly are called so; it has"));
  EXPECT_THAT(run("flexura", {"import", engine, "-o", folder / "out", "--base", "fixed"}).err,
              HasSubstr("--base is for robots"));
  EXPECT_THAT(run("flexura", {"import", engine, "-o", folder / "out", "--density", "3 mm"}).err,
              HasSubstr("--density 3 mm"));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(AssemblyImport, HostileNamesStayInsideTheFolder) {
  const Folder folder;
  Assembly a("../../a");
  double x = 0.0;
  for (const char* name : {"../../../evil", "/etc/passwd", "a\"]\n[run.x]", "a b", "a_b", ""}) {
    a.place(a.part(name, box({x, 0, 0}, {x + 5, 5, 5})), at({0, 0, 0}), std::string(name) + "'");
    x += 10;
  }
  const Import i = import(folder, a);
  ASSERT_EQ(i.outcome.exit_code, 0) << i.outcome.err;
  std::set<std::string> beside;
  for (const auto& entry : fs::directory_iterator(folder.path()))
    beside.insert(entry.path().filename().string());
  EXPECT_EQ(beside, (std::set<std::string>{"a.step", "out", "out.h5"}));
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "out/parts"))
    files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 6 * 3);  // .brep, .toml, .se.h5
}

}  // namespace
}  // namespace flexura::test
