// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// URDFs that cannot become a mechanism end in one sentence and write nothing; hostile names stay inside the folder.
#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Bad {
  std::string name, text, says;
  std::vector<std::string> words = {};
};

class BadUrdf : public testing::TestWithParam<Bad> {};

TEST_P(BadUrdf, EndsInOneSentenceAndWritesNothing) {
  const Folder folder;
  const auto file = folder.write("r.urdf", GetParam().text);
  std::vector<std::string> words = {"import", file, "-o", folder / "out"};
  words.insert(words.end(), GetParam().words.begin(), GetParam().words.end());
  const Outcome outcome = run("flexura", words);
  EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(GetParam().says));
  EXPECT_THAT(outcome.err, testing::StartsWith("error: "));
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_FALSE(fs::exists(folder / "out"));
}

INSTANTIATE_TEST_SUITE_P(
    All, BadUrdf,
    testing::Values(
        Bad{"empty", "", "is no URDF"}, Bad{"text", "hello", "is no URDF"}, Bad{"not_closed", "<robot name='r'><link name='a'>", "not well-formed"},
        Bad{"other_root", "<sdf/>", "<robot> is wanted"}, Bad{"no_links", robot(""), "no <link>"},
        Bad{"deep", [] { std::string s; for (int i = 0; i < 20000; ++i) s += "<robot>"; return s; }(), "nested too deep"},
        Bad{"xacro_element", robot("<xacro:macro name=\"x\"/><xacro:x/>" + kTwo), "xacro macro"},
        Bad{"xacro_value", robot(link("a", "<inertial><mass value=\"${m}\"/></inertial>")), "xacro macro"},
        Bad{"no_name", robot("<link/>"), "<link> has no name"}, Bad{"empty_name", robot("<link name=\" \"/>"), "is empty"},
        Bad{"two_links", robot(link("a") + link("a", "")), "a second link \"a\""},
        Bad{"two_roots", robot(kTwo), "2 links have no parent (\"a\", \"b\")"},
        Bad{"unknown_link", robot(kTwo + joint("j", "fixed", "a", "c")), "link \"c\", which the file does not have"},
        Bad{"unknown_type", robot(kTwo + joint("j", "hinge", "a", "b")), "is of type \"hinge\""},
        Bad{"two_parents", robot(kTwo + link("c") + joint("i", "fixed", "a", "b") + joint("j", "fixed", "a", "c") + joint("k", "fixed", "b", "c")), "child of joint \"j\" and of joint \"k\""},
        Bad{"ring", robot(kTwo + joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "a")), "form a ring"},
        Bad{"ring_aside", robot(kTwo + link("root") + joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "a")), "belongs to a ring"},
        Bad{"own_parent", robot(link("a") + joint("j", "fixed", "a", "a")), "form a ring"},
        Bad{"two_joints", robot(kTwo + link("c") + joint("j", "fixed", "a", "b") + joint("j", "fixed", "a", "c")), "a second joint \"j\""},
        Bad{"no_axis", robot(kTwo + joint("j", "continuous", "a", "b", R"(<axis xyz="0 0 0"/>)")), "has no length"},
        Bad{"two_numbers", robot(kTwo + joint("j", "continuous", "a", "b", R"(<axis xyz="0 1"/>)")), "has 2 numbers, 3 are wanted"},
        Bad{"not_a_number", robot(kTwo + joint("j", "continuous", "a", "b", R"(<origin xyz="0 0,5 0"/>)")), "\"0,5\", a finite number is wanted"},
        Bad{"infinite", robot(kTwo + joint("j", "continuous", "a", "b", R"(<origin xyz="0 inf 0"/>)")), "a finite number is wanted"},
        Bad{"beyond_all_bounds", robot(kTwo + joint("j", "continuous", "a", "b", R"(<origin xyz="0 1e300 0"/>)")), "a finite number is wanted"},
        Bad{"too_many", [] { std::string s = link("l0"); for (int i = 1; i <= 1001; ++i) s += link("l" + std::to_string(i)) + joint("j" + std::to_string(i), "continuous", "l0", "l" + std::to_string(i)); return robot(s); }(), "1001 movable joints"},
        Bad{"negative_damping", robot(kTwo + joint("j", "continuous", "a", "b", R"(<dynamics damping="-1"/>)")), "cannot be negative"},
        Bad{"negative_inertia", robot(link("a", R"(<inertial><mass value="1"/><inertia ixx="-1" iyy="-1" izz="-3"/></inertial>)")), "sum of its principal moments is not positive"},
        Bad{"inertia_without_mass", robot(link("a", R"(<inertial><inertia ixx="1" iyy="1" izz="1"/></inertial>)")), "has no <mass>"},
        Bad{"half_an_inertia", robot(link("a", R"(<inertial><mass value="1"/><inertia ixx="1" iyy="1"/></inertial>)")), "<inertia> has no izz"},
        Bad{"no_number", robot(link("a", R"(<inertial><mass value="nan"/></inertial>)")), "value of <mass> is \"nan\""},
        Bad{"negative_mass", robot(link("a", R"(<inertial><mass value="-1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>)")), "cannot be negative"},
        Bad{"no_inertia_at_the_end", robot(link("a") + link("b", "") + joint("j", "continuous", "a", "b")), "joint \"j\" moves links without inertia", {"--massless", "refuse"}},
        // Two axes in line, nothing between them: only their sum moves anything.
        Bad{"no_inertia_between", robot(link("a") + link("b", "") + link("c") + joint("j", "continuous", "a", "b") + joint("k", "continuous", "b", "c")), "joint \"k\" moves links that have no inertia apart", {"--massless", "refuse"}},
        Bad{"point_mass_on_its_axis", robot(link("a") + link("b", R"(<inertial><mass value="1"/><inertia ixx="0" iyy="0" izz="0"/></inertial>)") + joint("j", "continuous", "a", "b")), "joint \"j\" moves links without inertia", {"--massless", "refuse"}},
        Bad{"mimics_nobody", robot(kTwo + joint("j", "continuous", "a", "b", R"(<mimic joint="k"/>)")), "mimics \"k\", which the file does not have"},
        Bad{"mimics_itself", robot(kTwo + joint("j", "continuous", "a", "b", R"(<mimic joint="j"/>)")), "mimics itself"}),
    [](const auto& info) { return info.param.name; });

TEST(UrdfImport, AllFaultsAreToldAtOnce) {
  const Folder folder;
  const auto file =
      folder.write("r.urdf", robot(kTwo + link("c", R"(<inertial><mass value="-1"/></inertial>)") +
                                   joint("j", "hinge", "a", "b", R"(<origin xyz="0 0 x"/>)") +
                                   joint("k", "prismatic", "b", "lost", R"(<axis xyz="0 0 0"/>)")));
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_THAT(outcome.err, testing::StartsWith("error: " + file.string() + ": 5 faults"));
  for (const char* fault : {":4: the mass of link \"c\" is -1", ":5: joint \"j\" is of type \"hinge\"",
                            ":5: xyz of <origin> is \"x\"", ":6: the axis of joint \"k\" has no length",
                            ":6: the child of joint \"k\" is link \"lost\""})
    EXPECT_THAT(outcome.err, HasSubstr("\n  " + file.string() + fault));
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(UrdfImport, TemplatesAndOtherFilesAreRefusedByName) {
  const Folder folder;
  EXPECT_THAT(run("flexura", {"import", folder.write("r.robot", robot(kTwo))}).err,
              HasSubstr("is not of a kind that is imported"));
  EXPECT_EQ(run("flexura", {"import", folder / "lost.urdf"}).exit_code, 2);
}

TEST(UrdfImport, MasslessLinkBetweenCrossedAxesIsFine) {
  const Folder folder;
  const auto file =
      folder.write("r.urdf", robot(link("a") + link("cross", "") + link("c") +
                                   joint("j", "continuous", "a", "cross", R"(<axis xyz="1 0 0"/>)") +
                                   joint("k", "continuous", "cross", "c", R"(<axis xyz="0 1 0"/>)")));
  run_robot(folder, file, {"--end-time", "0.1"});
}

TEST(UrdfImport, HostileNamesStayInsideTheFolder) {
  const Folder folder;
  const std::string names[] = {
      "../../evil", "/etc/passwd",          "a\"]\n[run.x]\nset=[",       "a.b", "a b",          "a_b",
      "ground",     std::string(5000, 'x'), std::string(5000, 'x') + "y", "1st", "\xc3\xa4\xff", "${",
      "t"};
  std::string text = link("base");
  int n = 0;
  for (std::string name : names) {
    if (name == "${") continue;  // a template's
    std::string escaped;
    for (const char c : name)
      escaped += c == '"' ? std::string("&quot;") : c == '\n' ? std::string("&#10;") : std::string(1, c);
    text +=
        link(escaped,
             kMass + R"(<visual><origin rpy="0 0 1"/><geometry><box size="1 1 1"/></geometry></visual>)") +
        joint(escaped, "continuous", "base", escaped);
    ++n;
  }
  const auto file = folder.write("r.urdf", robot(text));
  const results::Run run = run_robot(folder, file, {"--end-time", "0.01"});
  EXPECT_EQ(run.name, "run");
  int files = 0;
  for (const auto& entry : fs::directory_iterator(folder / "robot/parts"))
    files += entry.is_regular_file() ? 1 : 0;
  EXPECT_EQ(files, 3 * n);  // superelement, surface and part file of each: its box is closed
  std::set<std::string> beside;
  for (const auto& entry : fs::directory_iterator(folder.path()))
    beside.insert(entry.path().filename().string());
  EXPECT_EQ(beside, (std::set<std::string>{"r.urdf", "robot", "robot.h5"}));
}

TEST(UrdfImport, NothingIsOverwrittenWithoutForce) {
  const Folder folder;
  const auto file = folder.write("r.urdf", robot(link("a")));
  ASSERT_EQ(run("flexura", {"import", file, "-o", folder / "out"}).exit_code, 0);
  folder.write("out/mechanism.toml", "mine");
  const Outcome second = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_THAT(second.err, HasSubstr("is there already"));
  EXPECT_EQ(read_text(folder / "out/mechanism.toml"), "mine");
  EXPECT_EQ(run("flexura", {"import", file, "-o", folder / "out", "--force"}).exit_code, 0);
  EXPECT_THAT(read_text(folder / "out/mechanism.toml"), HasSubstr("[body.a]"));
  // Not through a link either.
  fs::remove(folder / "out/mechanism.toml");
  fs::create_symlink(folder / "elsewhere", folder / "out/mechanism.toml");
  EXPECT_EQ(run("flexura", {"import", file, "-o", folder / "out", "--force"}).exit_code, 2);
  EXPECT_FALSE(fs::exists(folder / "elsewhere"));
}

}  // namespace
}  // namespace flexura::test
