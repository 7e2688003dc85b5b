// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What is decided about proposed joints: one by one on the terminal, or on the page that every import writes.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "cases/assembly/drawing.hpp"
#include "tests/app/command.hpp"
#include "tests/view/page_reader.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using namespace drawing;
using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const gp_Dir kZ(0, 0, 1);

// A rod without shoulders in a plate's bore: cylindrical. A lid on the plate's corner, bolted by two holes: fixed.
void draw(const fs::path& file) {
  Assembly a("bush");
  const auto holes = [](const TopoDS_Shape& shape, double z, double length) {
    return shape - cylinder({-25, -25, z}, kZ, 2, length) - cylinder({-25, 25, z}, kZ, 2, length);
  };
  a.place(a.part("plate", holes(box({-30, -30, 0}, {30, 30, 10}) - cylinder({0, 0, 0}, kZ, 5.05, 10), 0, 10)),
          at({0, 0, 0}));
  a.place(a.part("rod", cylinder({0, 0, -20}, kZ, 5, 50)), at({0, 0, 0}));
  a.place(a.part("lid", holes(box({-30, -30, 10}, {-20, 30, 15}), 10, 5)), at({0, 0, 0}));
  a.write(file);
}

// Both streams together, as a user sees them.
Outcome answered(const Folder& folder, const std::string& answers) {
  draw(folder / "a.step");
  const auto file = folder.write("answers", answers);
  const std::string command = std::string(FLEXURA_BIN_DIR) + "/flexura import '" +
                              (folder / "a.step").string() + "' -o '" + (folder / "out").string() +
                              "' --joints ask < '" + file.string() + "' 2>&1";
  Outcome outcome;
  std::FILE* pipe = popen(command.c_str(), "r");
  char part[512];
  while (std::fgets(part, sizeof part, pipe)) outcome.out += part;
  outcome.exit_code = WEXITSTATUS(pclose(pipe));
  return outcome;
}

TEST(AskAboutJoints, EachIsTakenLeftOutOrOfAnotherType) {
  const Folder folder;
  const Outcome o = answered(folder, "yes\nrevolute\n");
  ASSERT_EQ(o.exit_code, 0) << o.out;
  EXPECT_THAT(o.out, AllOf(HasSubstr("joint 1 of 2: plate and lid, fixed, confidence high"),
                           HasSubstr("2 holes in common across one plane: bolted"),
                           HasSubstr("joint 2 of 2: plate and rod, cylindrical")));
  const std::string mechanism = read_text(folder / "out/mechanism.toml");
  EXPECT_THAT(mechanism, HasSubstr("# proposed was cylindrical\n[joint.plate_rod]\ntype = \"revolute\""));
  EXPECT_THAT(o.out, HasSubstr("degrees of freedom: 1\n"));
  EXPECT_EQ(run("flexura", {"check", folder / "out/mechanism.toml"}).exit_code, 0);
}

TEST(AskAboutJoints, WithoutAJointItsBodyFloats) {
  const Folder folder;
  const Outcome o = answered(folder, "n\n\n");  // an empty answer is a yes
  ASSERT_EQ(o.exit_code, 0) << o.out;
  EXPECT_THAT(read_text(folder / "out/mechanism.toml"), Not(HasSubstr("[joint.plate_lid]")));
  EXPECT_THAT(o.out, HasSubstr("degrees of freedom: 8\n"));  // 6 of the lid, 2 of the rod
}

// The lid turns about the normal of the plane on which it lies.
TEST(AskAboutJoints, AFixedJointMadeAHingeGetsTheAxisOfItsFaces) {
  const Folder folder;
  const Outcome o = answered(folder, "revolute\na\n");
  ASSERT_EQ(o.exit_code, 0) << o.out;
  EXPECT_THAT(o.out, HasSubstr("degrees of freedom: 3\n"));
  const std::string mechanism = read_text(folder / "out/mechanism.toml");
  const auto at = mechanism.find("[body.lid.marker.plate_lid]");
  ASSERT_NE(at, std::string::npos);
  // z along +z or -z: no quaternion, or half a turn about an axis across z.
  const std::string marker = mechanism.substr(at, mechanism.find("\n\n", at) - at);
  const auto q = marker.find("quaternion = [0.0, ");
  EXPECT_TRUE(marker.find("quaternion") == std::string::npos || q != std::string::npos) << marker;
}

TEST(AskAboutJoints, AnswersThatEndOrStopWriteNothing) {
  for (const char* const answers : {"", "y\n", "q\n", "y\nquit\n"}) {
    const Folder folder;
    const Outcome o = answered(folder, answers);
    EXPECT_EQ(o.exit_code, 2) << o.out;
    EXPECT_THAT(o.out, testing::ContainsRegex("error: .*joint [12] of 2"));
    EXPECT_FALSE(fs::exists(folder / "out"));
  }
  const Folder folder;
  const Outcome o = answered(folder, "perhaps\na\n");
  EXPECT_EQ(o.exit_code, 0);
  EXPECT_THAT(o.out, HasSubstr("\"perhaps\" is no answer"));
}

TEST(AssemblyPage, HoldsWhatTheMechanismHas) {
  const Folder folder;
  draw(folder / "a.step");
  const Outcome o = run("flexura", {"import", (folder / "a.step").string(), "-o", folder / "out"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("assembly.html"));
  const view::testing::PageReader page(read_text(folder / "out/assembly.html"));
  const json& header = page.header;
  EXPECT_EQ(header["page"], "parts");
  ASSERT_EQ(header["bodies"].size(), 3U);
  EXPECT_EQ(header["bodies"][header["ground"].get<std::size_t>()]["name"], "plate");
  ASSERT_EQ(header["joints"].size(), 2U);
  const json& joint = header["joints"][1];
  EXPECT_EQ(joint["name"], "plate_rod");
  EXPECT_EQ(joint["type"], "cylindrical");
  EXPECT_EQ(joint["confidence"], "high");
  // Its z axis is the bore's.
  EXPECT_NEAR(std::abs(joint["rotation"][8].get<double>()), 1.0, 1e-12);
  EXPECT_NEAR(joint["position"][0].get<double>(), 0.0, 1e-9);
  // The rod's mantle, with its radius and the lines of the part file's interface.
  const json& rod =
      header["parts"][header["bodies"][joint["b"].get<std::size_t>()]["part"].get<std::size_t>()];
  const auto on = joint["on"][1].get<std::size_t>();
  const json& mantle = rod["faces"][on - 1];
  EXPECT_EQ(mantle["kind"], "cylinder");
  EXPECT_THAT(mantle["text"].get<std::string>(), HasSubstr("radius 5 mm, length 50 mm, 360 deg"));
  EXPECT_THAT(read_text(folder / "out/parts/rod.toml"),
              HasSubstr("[interface.face" + std::to_string(on) + "]\n" + mantle["lines"].get<std::string>()));
  // Its triangles lie on the mantle: corners are right to 32 bits.
  const auto vertices = page.block<float>(rod["key"].get<std::string>() + "/vertices");
  const auto triangles = page.block<std::int32_t>(rod["key"].get<std::string>() + "/triangles");
  const auto face = page.block<std::int32_t>(rod["key"].get<std::string>() + "/face");
  int of_mantle = 0;
  for (std::size_t t = 0; t < face.size(); ++t) {
    if (face[t] != static_cast<std::int32_t>(on) - 1) continue;
    ++of_mantle;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = static_cast<std::size_t>(triangles[3 * t + k]);
      EXPECT_NEAR(std::hypot(vertices[3 * v], vertices[3 * v + 1]), 0.005, 1e-9);
    }
  }
  EXPECT_GT(of_mantle, 10);
  // What is there is not written over.
  fs::remove(folder / "out/mechanism.toml");
  const Outcome again = run("flexura", {"import", (folder / "a.step").string(), "-o", folder / "out"});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_FALSE(fs::exists(folder / "out/mechanism.toml"));
}

// Three cubes of 10 mm in a row: the first two overlap by 1 mm, the last two touch.  100 mm^3 in a layer whose surface is 240 mm^2.
TEST(AssemblyOverlaps, AreFoundByTheExactShapesAndShownOnThePage) {
  const Folder folder;
  Assembly a("row");
  const TDF_Label cube = a.part("cube", box({0, 0, 0}, {10, 10, 10}));
  double x = 0.0;
  for (const double step : {9.0, 10.0, 0.0}) {
    a.place(cube, at({x, 0, 0}));
    x += step;
  }
  a.write(folder / "a.step");
  const Outcome o = run("flexura", {"import", (folder / "a.step").string(), "-o", folder / "out"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("cube and cube_2 overlap: 100 mm^3, about 0.83 mm thick, at (9.5, 5, 5) mm"));
  EXPECT_THAT(o.err, Not(HasSubstr("cube_3 overlap")));
  const json header = view::testing::PageReader(read_text(folder / "out/assembly.html")).header;
  ASSERT_EQ(header["overlaps"].size(), 1U);
  EXPECT_EQ(header["overlaps"][0]["a"], 0);
  EXPECT_EQ(header["overlaps"][0]["b"], 1);
  EXPECT_NEAR(header["overlaps"][0]["place"][0].get<double>(), 0.0095, 1e-9);
  // A clearance of a millimetre lets it pass.
  const Outcome wide =
      run("flexura", {"import", (folder / "a.step").string(), "-o", folder / "wide", "--clearance", "1 mm"});
  EXPECT_THAT(wide.err, Not(HasSubstr("overlap:")));
}

}  // namespace
}  // namespace flexura::test
