// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What the files of others have that changes nothing is a note; what everybody would mend alike is mended and said, and refused by
// --strict.
#include <gmock/gmock.h>

#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

using testing::HasSubstr;

std::string limited(const std::string& limit, const std::string& type = "prismatic") {
  return robot(kTwo + joint("j", type, "a", "b", "<limit " + limit + "/>"));
}
std::string drawn(const std::string& visual) {
  return robot(link("a", kMass + "<visual>" + visual + "</visual>"));
}
std::string inertia(const std::string& numbers) {
  return robot(link("a", "<inertial><mass value=\"1\"/><inertia " + numbers + "/></inertial>"));
}
const std::string kMoves = joint("j", "continuous", "a", "b");

struct Odd {
  std::string name, text, says;
  std::string writes = {};  ///< what stands in the mechanism then
};

void expect_comes_in(const Odd& odd, int strict_exit_code) {
  const Folder folder;
  const auto file = folder.write("r.urdf", odd.text);
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr(odd.says));
  EXPECT_THAT(outcome.err, testing::ContainsRegex("\n[0-9]+ notes?: 1 ")) << "the count at the end";
  const std::string written = read_text(folder / "out/mechanism.toml");
  EXPECT_THAT(written, HasSubstr(odd.writes));
  EXPECT_THAT(written, HasSubstr("# note: "));
  const Outcome strict = run("flexura", {"import", file, "-o", folder / "strict", "--strict"});
  EXPECT_EQ(strict.exit_code, strict_exit_code) << strict.err;
  if (strict_exit_code != 0) EXPECT_THAT(strict.err, HasSubstr("repaired without --strict"));
}

class Harmless : public testing::TestWithParam<Odd> {};
TEST_P(Harmless, IsANote) {
  expect_comes_in(GetParam(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    All, Harmless,
    testing::Values(
        Odd{"empty_name",
            drawn(
                R"(<geometry><sphere radius="1"/></geometry><material name=""><color rgba="1 0 0 1"/></material>)"),
            "a <material> has no name", "color = \"#ff0000\""},
        Odd{"two_materials",
            drawn(
                R"(<geometry><sphere radius="1"/></geometry><material name="x"><color rgba="1 0 0 1"/></material><material name="y"/>)"),
            "2 materials: the first is taken", "color = \"#ff0000\""},
        Odd{"flat_box", drawn(R"(<geometry><box size="0 0 0"/></geometry>)"), "three positive numbers"},
        Odd{"negative_sphere", drawn(R"(<geometry><sphere radius="-1"/></geometry>)"), "must be positive"},
        Odd{"other_shape", drawn("<geometry><cone/></geometry>"), "<cone> of link \"a\" is no shape"},
        Odd{"no_geometry", drawn("<origin/>"), "has no <geometry>"},
        Odd{"empty_geometry", drawn("<geometry/>"), "has no <geometry>"},
        Odd{"two_geometries", drawn(R"(<geometry><sphere radius="0.25"/><box size="1 1 1"/></geometry>)"),
            "2 geometries: the first", "radius = 0.25"},
        Odd{"mesh_without_file", drawn("<geometry><mesh/></geometry>"), "<mesh> has no filename"},
        Odd{"drives_nobody",
            robot(kTwo + kMoves + R"(<transmission name="t"><joint name="k"/></transmission>)"),
            "drives joint \"k\", which the file does not have"},
        Odd{"drives_a_fixed_joint",
            robot(kTwo + joint("j", "fixed", "a", "b") +
                  R"(<transmission name="t"><joint name="j"/></transmission>)"),
            "has no single coordinate"},
        Odd{"no_reduction",
            robot(
                kTwo + kMoves +
                R"(<transmission name="t"><joint name="j"/><mechanicalReduction>0</mechanicalReduction></transmission>)"),
            "a number other than 0 is wanted"},
        Odd{"effort_of_minus_one", limited(R"(lower="-1" upper="1" effort="-1")"),
            "effort of joint \"j\" is \"-1\": taken as none"},
        Odd{"speed_without_bound", limited(R"(lower="-1" upper="1" velocity="inf")"),
            "velocity of joint \"j\" is \"inf\": taken as none"},
        Odd{"no_travel", limited(R"(lower="0.5" upper="0.5")"), "joint \"j\" has no travel",
            "type = \"fixed\"\nfrom = \"a.j\""},
        Odd{"unknown_element", robot(kTwo + kMoves + "<drake:ignored/>"), "passed over: <drake:ignored>"},
        Odd{"left_by_xacro", robot(kTwo + kMoves + "<xacro:sensors at=\"b\"/>"),
            "passed over: <xacro:sensors>"},
        Odd{"definitions_that_nothing_uses",
            robot(kTwo + kMoves +
                  "<xacro:macro name=\"m\"><link "
                  "name=\"${p}\"/></xacro:macro>"),
            "passed over: <xacro:macro>"},
        Odd{"no_weight_in_gazebo",
            robot(kTwo + kMoves + "<gazebo reference=\"b\"><turnGravityOff>true</turnGravityOff></gazebo>"),
            "link \"b\" has no weight in Gazebo"},
        Odd{"degrees", robot(kTwo + joint("j", "continuous", "a", "b", R"(<origin rpy="90 0 0"/>)")),
            "rpy of <origin> is 90 0 0: taken as radians"},
        Odd{"twice_alike", robot(kTwo + link("b") + kMoves), "link \"b\" stands there twice, alike"},
        Odd{"loose_frame", robot(kTwo + link("c", "") + kMoves), "no joint names link \"c\""},
        Odd{"fixed_mimics", robot(kTwo + joint("j", "fixed", "a", "b", R"(<mimic joint="k"/>)")),
            "is fixed and mimics nothing"},
        Odd{"inertia_alone",
            robot(link(
                "a",
                R"(<inertial><mass value="0"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>)")),
            "moments of inertia but no mass"},
        Odd{"package_without_the_file",
            drawn(R"(<geometry><mesh filename="package://robots/meshes/a.stl"/></geometry>)"),
            "robots/meshes/a.stl is missing"}),
    [](const auto& info) { return info.param.name; });

class Repair : public testing::TestWithParam<Odd> {};
TEST_P(Repair, IsMadeAndSaidAndRefusedByStrict) {
  expect_comes_in(GetParam(), 2);
}

INSTANTIATE_TEST_SUITE_P(
    All, Repair,
    testing::Values(
        Odd{"limits_exchanged", limited(R"(lower="2" upper="-1")"),
            "lower 2 of joint \"j\" is above upper -1: exchanged", "lower = -1.0\nupper = 2.0"},
        Odd{"limit_infinite", limited(R"(lower="-inf" upper="2")"),
            "lower of joint \"j\" is \"-inf\": it has none", "joint = \"j\"\nupper = 2.0"},
        Odd{"no_limit", robot(kTwo + joint("j", "revolute", "a", "b")), "joint \"j\" has no <limit>"},
        Odd{"inertia_of_no_body", inertia(R"(ixx="1" iyy="1" izz="3" ixy="0" ixz="0" iyz="0")"),
            "principal moments 1, 1, 3 kg m^2, which no body has; taken are the nearest that one has, 1.25, "
            "1.25, 2.5",
            "inertia = [1.25, 1.25, 2.5"},
        Odd{"mass_as_a_point", robot(link("a", R"(<inertial><mass value="2"/></inertial>)")),
            "its mass, 2 kg, is taken as a point", "mass = 2.0"},
        Odd{"world", robot(kTwo + kMoves + joint("to_ground", "fixed", "world", "a")),
            "the parent of joint \"to_ground\" is \"world\""},
        Odd{"loop",
            robot(kTwo + kMoves + R"(<loop_joint name="l"><link1 link="a"/><link2 link="b"/></loop_joint>)"),
            "<loop_joint> \"l\" joins two links"},
        Odd{"loop_of_gazebo",
            robot(
                kTwo + kMoves +
                R"(<gazebo><joint name="l" type="revolute"><parent>a</parent><child>b</child></joint></gazebo>)"),
            "<joint> \"l\" joins two links"},
        Odd{"include", robot(kTwo + kMoves + R"(<xacro:include filename="$(find r)/plugins.xacro"/>)"),
            "plugins.xacro\" is left out"},
        Odd{"loose_link", robot(kTwo + link("c") + kMoves),
            "no joint names link \"c\": it is left out, with 1 kg"},
        Odd{"two_origins",
            robot(kTwo + joint("j", "continuous", "a", "b", R"(<origin xyz="1 0 0"/><origin xyz="2 0 0"/>)")),
            "a second <origin> in <joint>", "position = [1.0, 0.0, 0.0]"}),
    [](const auto& info) { return info.param.name; });

TEST(UrdfImport, NamesThatChangeAreToldInATable) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf", robot(link("arm/1") + link("Arm") + link("arm") + joint("arm", "continuous", "arm/1", "Arm") +
                      joint("to", "continuous", "Arm", "arm")));
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_THAT(outcome.out, testing::ContainsRegex("link \"arm/1\" +arm_1"));
  EXPECT_THAT(outcome.out, testing::ContainsRegex("link \"arm\" +arm\n"));  // like "Arm" but for the case
  EXPECT_THAT(outcome.out, testing::ContainsRegex("joint \"arm\" +arm_2"));
  EXPECT_THAT(read_text(folder / "out/mechanism.toml"), HasSubstr("# name: link \"arm/1\" is arm_1 here\n"));
}

TEST(UrdfImport, MeshesOfAPackageLieInAnyNeighbour) {
  const Folder folder;
  const std::string stl =
      "solid t\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid t\n";
  for (const char* made : {"of_the_robot/meshes", "of_the_robot/urdf", "other/meshes"})
    std::filesystem::create_directories(folder / made);
  folder.write("of_the_robot/meshes/a.stl", stl);
  folder.write("other/meshes/b.stl", stl);
  const auto mesh = [](const std::string& uri) {
    return "<visual><geometry><mesh filename=\"" + uri + "\"/></geometry></visual>";
  };
  const auto file = folder.write(
      "of_the_robot/urdf/r.urdf",
      robot(link("a", kMass + mesh("package://called_otherwise/meshes/a.stl") +
                          mesh("model://other/meshes/b.stl") + mesh("$(find other)/meshes/b.stl") +
                          mesh("..\\meshes\\a.stl") + mesh("package://other/meshes/a.stl"))));
  const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("other/meshes/a.stl is missing"));
  EXPECT_THAT(outcome.err, HasSubstr("1 pictures that are not read"));
}

TEST(UrdfImport, MotorsFollowTargets) {
  const Folder folder;
  const auto file = folder.write(
      "r.urdf",
      robot(kTwo + joint("j", "continuous", "a", "b", R"(<axis xyz="0 0 1"/><limit effort="50"/>)") +
            R"(<transmission name="t"><joint name="j"/><actuator name="m"><mechanicalReduction>20)"
            R"(</mechanicalReduction></actuator></transmission>)"));
  const results::Run run = run_robot(
      folder, file, {"--end-time", "2", "--set", "input.target_m.value=0.3", "output.quantities=[\"j.*\"]"},
      {"--controllers", "pd"});
  // 2 Hz, critically damped: (1 + w t) exp(-w t) of the way is left after 2 s, 3e-10.
  const Eigen::VectorXd angle = column(run, "j.angle");
  EXPECT_NEAR(angle[angle.size() - 1], 0.3, 1e-5);
  EXPECT_LT(angle.maxCoeff(), 0.3 * 1.02);  // the filter of the derivative, 1 ms, lets it pass by a little
}

}  // namespace
}  // namespace flexura::test
