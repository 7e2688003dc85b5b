// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Files that ended the program, kept it busy for ever or were read as something else: tests/found/safe and
// their families.  Each is refused in one sentence that names the place, and nothing is left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <algorithm>
#include <fstream>

#include "tests/app/command.hpp"

namespace flexura {
namespace {

using test::Folder;
using test::Outcome;
using test::run;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::string safe(const std::string& name) {
  return std::string(FLEXURA_SOURCE_DIR) + "/tests/found/safe/" + name;
}

/// What every refusal has: exit code 2, one line of at most 400 letters, no words of libraries or of ours.
void expect_refused(const Outcome& outcome, const std::string& words) {
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(words));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_LE(outcome.err.size(), 420u) << outcome.err;
  for (const char* raw : {"internal", "json.exception", "vector::", "basic_string", "bad_alloc", "stoul"})
    EXPECT_THAT(outcome.err, Not(HasSubstr(raw)));
}

constexpr const char* kForce = R"([body.b]
mass = 1
inertia = [1, 1, 1]
[joint.j]
type = "revolute"
from = "ground"
to = "b"
[force.f]
type = "joint_force"
joint = "j"
value = "VALUE"
)";

Outcome check_formula(const std::string& formula) {
  const Folder folder;
  const auto file = folder.write("m.toml", test::replaced(kForce, "VALUE", formula));
  return run("flexura", {"check", file.string()});
}

TEST(HostileInput, DecimalCommaIsNoZero) {
  expect_refused(run("flexura", {"simulate", safe("decimal_comma.toml"), "-o", "/dev/null/x.h5"}), "");
  for (const char* text : {"0,5", "2*(0,5)", "1 + 0,5*t", "(t, 3)"})
    expect_refused(check_formula(text), "the decimal sign is a point");
  expect_refused(check_formula("sin(0,5)"), "force.f.value");
  EXPECT_EQ(check_formula("max(0, 5) + min(t, (2 + 3))").exit_code, 0);
  const Folder folder;
  const auto file = folder.write("m.toml", "[body.b]\nmass = \"0,5 kg\"\ninertia = [1, 1, 1]\n");
  expect_refused(run("flexura", {"check", file.string()}), "m.toml:2: body.b.mass = \"0,5 kg\": has a comma");
  // A table of Germany's spreadsheets, and a heading that is none.
  folder.write("t.csv", "x;y\n0,5;1,5\n1,5;2,5\n");
  folder.write("u.csv", "1 2 3\n2 3 4\n");
  for (const auto& [csv, words] : {std::pair{"t.csv", "line 2 has a comma within its numbers"},
                                   std::pair{"u.csv", "line 1 holds more than two numbers"}}) {
    const auto with_table = folder.write("w.toml", std::string("[table.c]\nfile = \"") + csv +
                                                       "\"\n[body.b]\nmass = 1\ninertia = [1, 1, 1]\n");
    expect_refused(run("flexura", {"check", with_table.string()}), words);
  }
}

TEST(HostileInput, LettersThatNoFormulaHasAreNamed) {
  expect_refused(check_formula("1\\u0000 + x"), "\"\\x00\" has no meaning in a formula");
  expect_refused(check_formula("\\\"text\\\""), "has no meaning in a formula");
  expect_refused(check_formula("t²"), "\"²\" has no meaning in a formula");
  expect_refused(check_formula("1;2"), "has no meaning in a formula");
}

TEST(HostileInput, ALongFormulaIsNotEchoed) {
  std::string text = "t";
  for (int i = 0; i < 200000; ++i) text += "+t";
  expect_refused(check_formula(text), "400001 characters, 10000 are allowed");
  expect_refused(check_formula(std::string(5000, 'x')), "is not known here");
  expect_refused(check_formula(std::string(3000, '(') + "t"), "force.f.value");
}

TEST(HostileInput, NamesWithAHyphenAreNamesButNotInFormulas) {
  EXPECT_EQ(run("flexura", {"check", safe("misc/hyphen.toml")}).exit_code, 0);
  const Folder folder;
  const std::string pin =
      test::replaced(test::replaced(kForce, "joint.j", "joint.main-pin"), "\"j\"", "\"main-pin\"");
  const auto file = folder.write("m.toml", test::replaced(pin, "VALUE", "2*main-pin.angle"));
  expect_refused(
      run("flexura", {"check", file.string()}),
      "m.toml:11: force.f.value = \"2*main-pin.angle\": the name \"main-pin.angle\" cannot stand in");
  for (const char* name : {"\"\"", "\"a/b\"", "\"a\\u001bb\""}) {
    const auto odd =
        folder.write("o.toml", std::string("[body.") + name + "]\nmass = 1\ninertia = [1, 1, 1]\n");
    expect_refused(run("flexura", {"check", odd.string()}), "o.toml:1: body");
  }
}

TEST(HostileInput, TablesNestedDeepAreRefusedBeforeTheyAreBuilt) {
  expect_refused(run("flexura", {"check", safe("misc/deep_key.toml")}), "deep_key.toml:1: nests deeper than");
  const Folder folder;
  std::string dots = "a", brackets = "x = ", inline_tables = "x = ";
  for (int i = 0; i < 50000; ++i) {
    dots += ".a";
    brackets += '[';
    inline_tables += "{a.b.c = ";
  }
  for (const std::string& text : {"[" + dots + "]\n", "[[" + dots + "]]\n", dots + " = 1\n", brackets,
                                  inline_tables, "[a.b]\nc." + dots + " = 1\n"}) {
    const auto file = folder.write("deep.toml", "# \"quoted\n" + text);
    expect_refused(run("flexura", {"check", file.string()}), "deep.toml:");
  }
  expect_refused(run("flexura", {"reduce", safe("misc/deep_key.toml")}),
                 "deep_key.toml:1: nests deeper than");
  for (const std::string& text : {dots + "=1", "body.b.mass=" + brackets.substr(4)})
    expect_refused(
        run("flexura", {"simulate", safe("misc/hyphen.toml"), "--set", text, "-o", "/dev/null/x.h5"}), "");
}

TEST(HostileInput, ParametersAreReadInLinearTime) {
  // Each reads the next one: the order of the file is the worst for whoever asks again and again.  With all
  // names told to the parser of each formula 1000 took 2 s; this would take 3 minutes.
  std::string text = "[parameters]\n";
  const int n = 9000;
  for (int i = 0; i < n; ++i) text += "p" + std::to_string(i) + " = \"p" + std::to_string(i + 1) + " + 1\"\n";
  text += "p" + std::to_string(n) + " = 1\n[body.b]\nmass = \"p0\"\ninertia = [1, 1, 1]\n";
  const Folder folder;
  const Outcome outcome = run("flexura", {"check", folder.write("m.toml", text).string()});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto circle = folder.write("c.toml", "[parameters]\na = \"b\"\nb = \"a\"\n[body.b]\nmass = 1\n");
  expect_refused(run("flexura", {"check", circle.string()}), "a, b depend on each other in a circle");
  const auto time = folder.write("t.toml", "[parameters]\na = \"2*t\"\n[body.b]\nmass = 1\n");
  expect_refused(run("flexura", {"check", time.string()}), "varies with t");
}

TEST(HostileInput, NumbersBeyondAllMeasureAreRefusedByKey) {
  const Folder folder;
  const std::string out = (folder / "x.se.h5").string();
  const std::string part = safe("poisson/crash_young1e300.toml"), beam = safe("beam/h.toml");
  expect_refused(run("flexura", {"reduce", part, "-o", out}),
                 "material.steel.young = 1e+300: is beyond all measure");
  for (const char* key :
       {"material.steel.young=1e200", "material.steel.density=1e-200", "material.steel.density=1e-30",
        "material.steel.density=1e30", "load.g.acceleration=[0,0,1e99]", "modes.count=2000000000",
        "material.steel.poisson=0.7"})
    expect_refused(
        run("flexura", {"reduce", part, "-o", out, "--set", "material.steel.young=210e9", "--set", key}),
        "command line: ");
  expect_refused(run("flexura", {"reduce", beam, "-o", out}), "member.blade.elements = 1000000000: must be");
  for (const char* key :
       {"mesh.size=1e-9", "mesh.frequency=1e30", "material.steel.density=1e-300", "section.square.width=1e39",
        "section.square.width=1e-39", "node.tip.position=[1e40,0,0]", "node.tip.position=[1e-30,0,0]",
        "mesh.elements=2000000000"})
    expect_refused(
        run("flexura", {"reduce", beam, "-o", out, "--set", "member.blade.elements=", "--set", key}), "");
  EXPECT_FALSE(std::filesystem::exists(out));
  expect_refused(run("flexura", {"simulate", safe("misc/part_left.toml"), "-o", (folder / "r.h5").string()}),
                 "gravity = 1e+308: is beyond all measure");
}

TEST(HostileInput, TimesThatNoRunReachesAreRefused) {
  const Folder folder;
  const std::string out = (folder / "m.h5").string();
  for (const auto& [key, words] :
       {std::pair{"output_step=1e-12", "makes 1e+11 rows of 0.1 s; at most 1e+08"},
        std::pair{"fixed_step=1e-18", "makes 1e+17 steps"}, std::pair{"max_step=1e-30", "steps of 0.1 s"},
        std::pair{"first_step=1e-300", "steps of 0.1 s"},
        std::pair{"end_time=-1", "must not be before start_time"},
        std::pair{"end_time=1e-320", "lost in the round-off of the time"},
        std::pair{"stop_time=-1", "must not be before start_time"},
        std::pair{"output_step=-1", "must be above 0 s"}, std::pair{"end_time=1e30", "makes 1e+32 rows"}})
    expect_refused(run("flexura", {"simulate", safe("userlib/m.toml"), "-o", out, "--set",
                                   std::string("solver.") + key}),
                   words);
  // 1e15 s and 10 ms more are the same number.
  expect_refused(run("flexura", {"simulate", safe("userlib/m.toml"), "-o", out, "--set",
                                 "solver.start_time=1e15", "--set", "solver.end_time=1000000000000001"}),
                 "is lost in the round-off of the time");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(HostileInput, LibrariesThatNoLoaderSurvivesAreRefused) {
  const Folder folder;
  const auto with = [&](const std::filesystem::path& library) {
    return run("flexura",
               {"check", folder
                             .write("m.toml", test::replaced(test::read_text(safe("userlib/l.toml")), "d.so",
                                                             library.string()))
                             .string()});
  };
  const std::filesystem::path built = FLEXURA_USERLIBS;
  expect_refused(with(built / "userlib_a.so"), "has no FLEXURA_ELEMENTS");
  expect_refused(with(built / "userlib_b.so"), "is compiled for the interface 0");
  expect_refused(with(built / "userlib_c.so"), "is compiled for the interface \"\"");
  expect_refused(with(built / "userlib_d.so"), "undefined symbol");
  const std::string whole = test::read_text(built / "userlib_a.so");
  for (const std::size_t length :
       {std::size_t{0}, std::size_t{40}, std::size_t{100}, std::size_t{1000}, whole.size() / 2})
    expect_refused(with(folder.write("truncated.so", whole.substr(0, length))), "force.u.library");
  // The dynamic table and the symbols with every byte turned: the loader's own crash stays in its own
  // process.
  for (const std::size_t from : {std::size_t{0x200}, std::size_t{0x400}, whole.size() / 3}) {
    std::string turned = whole;
    for (std::size_t i = from; i < std::min(from + 512, turned.size()); ++i)
      turned[i] = static_cast<char>(~turned[i]);
    const Outcome outcome = with(folder.write("turned.so", turned));
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  }
  expect_refused(with(folder.path()), "is no file");
}

/// The same file with the group or dataset replaced: by a link to another file, by a soft link.
void put_link(const std::filesystem::path& file, const char* name, const char* other_file) {
  const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  ASSERT_GE(id, 0);
  ASSERT_GE(H5Lmove(id, name, id, "elsewhere", H5P_DEFAULT, H5P_DEFAULT), 0);
  if (other_file != nullptr)
    ASSERT_GE(H5Lcreate_external(other_file, name, id, name, H5P_DEFAULT, H5P_DEFAULT), 0);
  else
    ASSERT_GE(H5Lcreate_soft("/elsewhere", id, name, H5P_DEFAULT, H5P_DEFAULT), 0);
  H5Fclose(id);
}

TEST(HostileInput, LinksOutOfHdf5FilesAreNotFollowed) {
  const Folder folder;
  const std::string se = (folder / "x.se.h5").string(), results = (folder / "r.h5").string();
  ASSERT_EQ(run("flexura", {"reduce", "-q", safe("poisson/crash_young1e300.toml"), "-o", se, "--set",
                            "material.steel.young=210e9"})
                .exit_code,
            0);
  ASSERT_EQ(run("flexura", {"simulate", "-q", safe("userlib/m.toml"), "-o", results}).exit_code, 0);
  for (const auto& [file, name] : {std::pair{se, "matrices"}, std::pair{se, "header"},
                                   std::pair{results, "runs"}, std::pair{results, "model"}})
    for (const bool external : {true, false}) {
      const std::filesystem::path linked = folder / "linked.h5";
      std::filesystem::copy_file(file, linked, std::filesystem::copy_options::overwrite_existing);
      put_link(linked, name, external ? file.c_str() : nullptr);
      expect_refused(run("flexura", {file == se ? "modes" : "view", linked.string()}),
                     "is a link, which may lead out");
    }
}

constexpr const char* kDeckPart = R"([geometry]
file = "x.inp"
[material.steel]
young = "210 GPa"
poisson = 0.3
density = "7850 kg/m^3"
[interface.a]
by = "near"
point = [0, 0, 0]
tie = "average"
)";

TEST(HostileInput, DecksOfOddLinesAreRefusedWithTheLine) {
  const Folder folder;
  const auto part = folder.write("p.toml", kDeckPart);
  for (const auto& [deck, words] :
       {std::pair{"1, 2, 3\n*NODE\n", "holds no solid, shell or beam elements"},
        std::pair{"*\n1,2\n", "holds no solid, shell or beam elements"},
        std::pair{"*ELEMENT, TYPE=C3D4\n,,,\n", "holds no solid, shell or beam elements"},
        std::pair{"*NSET, NSET=a, GENERATE\n,,\n", "holds no solid, shell or beam elements"},
        std::pair{"*NSET, NSET=a, GENERATE\n1, 9000000000000000000\n", "a generated set from 1"},
        std::pair{"*NODE\n1, inf, 0, 0\n", "is not a number"},
        std::pair{"*NODE\n1, 1e300, 0, 0\n*ELEMENT, TYPE=C3D4\n1,1,1,1,1\n", "beyond all measure"},
        std::pair{"*INCLUDE, INPUT=x.inp\n*INCLUDE, INPUT=x.inp\n", "*INCLUDE"},
        std::pair{"*INCLUDE, INPUT=/dev/zero\n", "is no file"}}) {
    folder.write("x.inp", deck);
    expect_refused(run("flexura", {"reduce", part.string()}), words);
  }
}

TEST(HostileInput, WhatOpenCascadeGivesUpIsSaidInOurWords) {
  const Folder folder;
  const std::string whole = test::read_text(FLEXURA_SOURCE_DIR "/tests/mesh/data/drilled_box.brep");
  const auto damaged = folder.write("box.brep", test::replaced(whole, "\n+5 0 *\n", "\n+59 0 *\n"));
  const Outcome outcome = run("flexura", {"reduce", "--list-faces", damaged.string()});
  expect_refused(outcome, "box.brep: is given up by OpenCASCADE; it is damaged");
  EXPECT_THAT(outcome.err, HasSubstr("save it again from the CAD program"));
}

TEST(HostileInput, ACadFileThatIsReadForEverIsGivenUpWithItsStage) {
  const Folder folder;
  const std::string text =
      test::replaced(kDeckPart, "x.inp", safe("brep/x.brep")) + "[mesh]\ntime_limit = \"2 s\"\n";
  const Outcome outcome = run("flexura", {"reduce", folder.write("p.toml", text).string()});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("was not done within 2 s (it was reading the CAD file)"));
}

}  // namespace
}  // namespace flexura
