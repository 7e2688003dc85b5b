// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/documents/document.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <random>

#include "tests/setup/scratch_place.hpp"

namespace flexura::input {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// A small mechanism's schema with one key of every kind.
TableSchema schema() {
  TableSchema material{
      .name = "material",
      .doc = "What the part is made of.",
      .keys = {quantity("density", dim::density, "mass per volume").required().above(0.0),
               quantity("poisson", dim::none, "Poisson's ratio").or_default("0.3").above(-1).below(0.5)}};
  TableSchema joint{
      .name = "joint",
      .doc = "Joins two markers.",
      .keys = {text("from", "first marker").required(),
               choice("type", {"revolute", "fixed", "spring"}, "kind").required()},
      .selector = "type",
      .variants = {{"revolute", {.keys = {vector3("axis", dim::none, "axis").or_default("[0, 0, 1]")}}},
                   {"fixed", {}},
                   {"spring",
                    {.keys = {quantity("stiffness", dim::angular_stiffness, "").required(),
                              expression("torque", dim::torque, "law")}}}}};
  TableSchema body{.name = "body",
                   .keys = {quantity("mass", dim::mass, "").at_least(0.0), text("file", "path"),
                            quaternion("orientation", ""), vector3("at", dim::length, "position")}};
  return {
      .name = "Test file",
      .doc = "A page.",
      .keys = {text("name", "the name").or_default("unnamed"), flag("verbose", "talk").or_default("false"),
               integer("modes", "number of modes").or_default("20").at_least(0),
               quantity("size", dim::length, "mesh size").or_default("5 mm"), texts("tags", ""),
               integers("strike", "modes struck out"), quantities("times", dim::time, "").sized(2),
               vectors3("points", dim::length, ""), matrix("section", ""),
               expression("speed", dim::angular_velocity, "driven speed"),
               table("material", material, "material"), tables("joint", joint, "joints"),
               table_map("body", body, "bodies")}};
}

class Document : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = ::flexura::test::scratch_place() / ("flexura_input_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
    file_ = folder_ / "engine.toml";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Section read(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    std::ofstream(file_, std::ios::binary) << text;
    return read_document(file_, schema(), overrides);
  }

  // The message without the folder.
  std::string refusal(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    try {
      read(text, overrides);
    } catch (const InputError& failure) {
      std::string message = failure.what();
      const std::string prefix = folder_.string() + "/";
      if (message.starts_with(prefix)) message.erase(0, prefix.size());
      return message;
    }
    return "accepted";
  }

  std::filesystem::path folder_, file_;
};

const char* const good = R"toml(name = "crank"
modes = 12
size = "3 mm"
tags = ["a", "b"]
strike = [7, 9]
times = ["10 ms", 2]
points = [[0, 0, 1], ["1 mm", "2 mm", "3 mm"]]
section = [[1, 2, 3], [4, 5, 6]]
speed = "600 rpm"
[material]
density = "7850 kg/m^3"
[[joint]]
from = "ground.o"
type = "revolute"
[[joint]]
from = "rod.small"
type = "spring"
stiffness = "5 N*m"
torque = "3*sin(t)"
[body.rod]
mass = "250 g"
file = "rod.se.h5"
at = "0, 0, 12.5 mm"
[body.crank]
orientation = [2, 0, 0, 2]
)toml";

TEST_F(Document, AnglesOfManyTurnsWithoutUnitAreRemarkedOn) {
  TableSchema turned{.name = "Turned",
                     .keys = {quantity("angle", dim::angle, ""), quantity("size", dim::length, ""),
                              quantities("table", dim::angle, "")}};
  const auto remarks = [&](const std::string& text) {
    std::ofstream(file_, std::ios::binary) << text;
    return read_document(file_, turned).remarks();
  };
  EXPECT_THAT(remarks("angle = 90\n"), ElementsAre(HasSubstr("engine.toml:1: angle = 90: is 14.3 turns")));
  EXPECT_EQ(remarks("size = 3\ntable = [1, -360.0, 7]\n").size(), 2u);
  EXPECT_THAT(remarks("angle = \"90 deg\"\nsize = 90\ntable = [6.283185307179586, \"20 rad\"]\n"),
              ElementsAre());
}

TEST_F(Document, EveryKindIsReadInSi) {
  const Section root = read(good);
  EXPECT_EQ(root.text("name"), "crank");
  EXPECT_FALSE(root.flag("verbose"));
  EXPECT_FALSE(root.has("verbose"));
  EXPECT_TRUE(root.has("modes"));
  EXPECT_EQ(root.integer("modes"), 12);
  EXPECT_DOUBLE_EQ(root.quantity("size"), 0.003);
  EXPECT_THAT(root.texts("tags"), ElementsAre("a", "b"));
  EXPECT_THAT(root.integers("strike"), ElementsAre(7, 9));
  EXPECT_THAT(root.quantities("times"), ElementsAre(0.01, 2.0));
  ASSERT_EQ(root.vectors3("points").size(), 2u);
  EXPECT_DOUBLE_EQ(root.vectors3("points")[1].y(), 0.002);
  ASSERT_EQ(root.matrix("section").cols(), 3);
  EXPECT_EQ(root.matrix("section")(1, 0), 4.0);
  EXPECT_NEAR(std::stod(root.text("speed")), 62.83185307179586, 1e-13);  // 20 pi, 16 digits
  EXPECT_DOUBLE_EQ(root.table("material").quantity("density"), 7850.0);
  EXPECT_DOUBLE_EQ(root.table("material").quantity("poisson"), 0.3);
  const auto joints = root.tables("joint");
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_EQ(joints[0].vector3("axis"), Eigen::Vector3d(0, 0, 1));
  EXPECT_DOUBLE_EQ(joints[1].quantity("stiffness"), 5.0);
  EXPECT_EQ(joints[1].text("torque"), "3*sin(t)");
  const auto bodies = root.table_map("body");
  ASSERT_EQ(bodies.size(), 2u);
  EXPECT_EQ(bodies[0].first, "rod");  // file order, not the alphabet
  EXPECT_EQ(bodies[1].first, "crank");
  EXPECT_DOUBLE_EQ(bodies[0].second.vector3("at").z(), 0.0125);
  EXPECT_EQ(bodies[0].second.file("file"), folder_ / "rod.se.h5");
  EXPECT_DOUBLE_EQ(bodies[1].second.quaternion("orientation")[3], std::sqrt(0.5));
}

TEST_F(Document, RefusalsSayWhereWhatAndWhatToDo) {
  EXPECT_EQ(refusal("[material]\ndensty = 7850\n"),
            "engine.toml:2: material.densty: unknown key, did you mean \"density\"?");
  EXPECT_EQ(refusal("colour = 1\n").substr(0, 57),
            "engine.toml:1: colour: unknown key; known are name, verbo");
  EXPECT_EQ(refusal("[material]\npoisson = 0.2\n"),
            "engine.toml:1: material.density: is missing; give a density (mass per volume)");
  EXPECT_EQ(refusal("\n[material]\ndensity = \"-5 kg/m^3\"\n"),
            "engine.toml:3: material.density = \"-5 kg/m^3\": must be above 0 kg/m^3");
  EXPECT_EQ(refusal("[material]\ndensity = 1\npoisson = 0.5\n"),
            "engine.toml:3: material.poisson = 0.5: must be above -1 and below 0.5");
  EXPECT_EQ(refusal("size = \"3 kg\"\n"),
            "engine.toml:1: size = \"3 kg\": is a mass, a length is wanted, like \"12 mm\"");
  EXPECT_EQ(refusal("modes = 2.5\n"), "engine.toml:1: modes = 2.5: a whole number is wanted");
  EXPECT_EQ(refusal("modes = 9999999999\n"),
            "engine.toml:1: modes = 9999999999: is too large for a whole number; the largest is 2147483647");
  EXPECT_EQ(refusal("name = 5\n"), "engine.toml:1: name = 5: a text in quotes is wanted");
  EXPECT_EQ(refusal("verbose = 1\n"), "engine.toml:1: verbose = 1: true or false is wanted");
  EXPECT_EQ(refusal("size = inf\n"), "engine.toml:1: size = inf: is not finite; give a number");
  EXPECT_EQ(refusal("times = [1]\n"), "engine.toml:1: times = [1]: has 1 entries, 2 are wanted");
  EXPECT_EQ(refusal("section = [[1], [2, 3]]\n"),
            "engine.toml:1: section = [[1], [2, 3]]: has rows of 1 and 2 entries, a list of rows of equal "
            "length is "
            "wanted");
  EXPECT_EQ(refusal("[body.a]\norientation = [0, 0, 0, 0]\n"),
            "engine.toml:2: body.a.orientation = [0, 0, 0, 0]: is no rotation: all its entries are zero; [1, "
            "0, 0, 0] is "
            "no rotation at all");
  EXPECT_EQ(
      refusal("speed = \"3 m/s\"\n"),
      "engine.toml:1: speed = \"3 m/s\": is a velocity, an angular velocity is wanted, like \"600 rpm\"");
  EXPECT_EQ(refusal("material = 3\n"), "engine.toml:1: material = 3: a table [material] is wanted");
  EXPECT_EQ(refusal("joint = 3\n"), "engine.toml:1: joint = 3: a list of tables [[joint]] is wanted");
  EXPECT_EQ(refusal("[body]\nmass = 3\n"), "engine.toml:2: body.mass = 3: tables [body.NAME] are wanted");
}

TEST_F(Document, VariantsHaveTheirOwnKeys) {
  EXPECT_EQ(refusal("[[joint]]\nfrom = \"a\"\ntype = \"revolut\"\n"),
            "engine.toml:3: joint[1].type = \"revolut\": is not a known choice, did you mean \"revolute\"?");
  EXPECT_EQ(
      refusal("[[joint]]\nfrom = \"a\"\ntype = \"glue\"\n"),
      "engine.toml:3: joint[1].type = \"glue\": is not a known choice; known are revolute, fixed, spring");
  EXPECT_EQ(refusal("[[joint]]\nfrom = \"a\"\ntype = \"fixed\"\naxis = [1, 0, 0]\n"),
            "engine.toml:4: joint[1].axis: unknown key for type = \"fixed\"; known are from, type");
  EXPECT_EQ(
      refusal("[[joint]]\nfrom = \"a\"\n"),
      "engine.toml:1: joint[1].type: is missing; give one of \"revolute\", \"fixed\", \"spring\" (kind)");
}

TEST_F(Document, SyntaxAndFilesAreRefusedInOneSentence) {
  EXPECT_THAT(refusal("a = [1\nb = 2\n"), HasSubstr("engine.toml:2:1: is not valid TOML: "));
  EXPECT_THAT(refusal("modes = 1\nmodes = 2\n"), HasSubstr("engine.toml:2"));
  EXPECT_THAT(refusal("\x89HDF\r\n\x1a\n"), HasSubstr("is an HDF5 file, a TOML file is wanted"));
  read("");
  try {
    read_document(folder_ / "engin.toml", schema());
    FAIL();
  } catch (const InputError& failure) {
    EXPECT_THAT(failure.what(),
                HasSubstr("engin.toml: there is no such file, did you mean \"engine.toml\"?"));
  }
  try {
    read_document(folder_, schema());
    FAIL();
  } catch (const InputError& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("is a folder, a TOML file is wanted"));
  }
}

TEST_F(Document, OverridesReplaceAndAddValues) {
  const Section root =
      read(good, {"material.density=2700 kg/m^3", "joint[1].axis = [1, 0, 0]", "body.wheel={mass = 3}",
                  "name=12", "tags=[\"c\"]", "joint[2].from=rod.big"});
  EXPECT_DOUBLE_EQ(root.table("material").quantity("density"), 2700.0);
  EXPECT_EQ(root.tables("joint")[0].vector3("axis"), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(root.tables("joint")[1].text("from"), "rod.big");
  EXPECT_EQ(root.text("name"), "12");
  EXPECT_THAT(root.texts("tags"), ElementsAre("c"));
  ASSERT_EQ(root.table_map("body").size(), 3u);
  EXPECT_EQ(root.table_map("body")[2].first, "wheel");

  EXPECT_EQ(refusal(good, {"size=3 kg"}),
            "command line: size = \"3 kg\": is a mass, a length is wanted, like \"12 mm\"");
  EXPECT_EQ(refusal(good, {"sizes=3"}), "command line: sizes: unknown key, did you mean \"size\"?");
  EXPECT_EQ(refusal(good, {"joint[3].from=x"}),
            "command line: joint[3]: there is no such entry; joint has 2, counted from 1");
  EXPECT_EQ(refusal(good, {"body.rodd.mass=3"}),
            "command line: body.rodd: there is no body \"rodd\", did you mean \"rod\"?");
  EXPECT_THAT(refusal("", {"body.rod.mass=3"}), HasSubstr("there is no body \"rod\""));
  EXPECT_THAT(refusal(good, {"size"}),
              HasSubstr("command line: \"size\": is not of the form key.path=value"));
  EXPECT_THAT(refusal(good, {"=3"}), HasSubstr("is not of the form"));
  EXPECT_THAT(refusal(good, {"joint[0].from=3"}), HasSubstr("is not of the form"));
  EXPECT_THAT(refusal(good, {"size.x=3"}),
              HasSubstr("command line: size: is not a table, so it has no key x"));
}

TEST_F(Document, AnAbsentTableHasItsDefaults) {
  const Section material = read("").table("material");
  EXPECT_DOUBLE_EQ(material.quantity("poisson"), 0.3);
  EXPECT_THROW(material.quantity("density"), InputError);
  EXPECT_TRUE(read("").tables("joint").empty());
  EXPECT_TRUE(read("").table_map("body").empty());
}

TEST_F(Document, RefuseAndWherePointAtTheLine) {
  const Section rod = read(good).table_map("body")[0].second;
  EXPECT_EQ(rod.where("mass"), file_.string() + ":21: body.rod.mass");
  EXPECT_EQ(rod.where(), file_.string() + ":20: body.rod");
  try {
    rod.refuse("file", "there is no such file", "reduce the part first");
    FAIL();
  } catch (const InputError& failure) {
    EXPECT_EQ(
        failure.what(),
        file_.string() + ":22: body.rod.file = \"rod.se.h5\": there is no such file; reduce the part first");
  }
}

TEST_F(Document, AskingOutsideTheSchemaIsAProgrammingError) {
  const Section root = read(good);
  EXPECT_THROW(root.text("nonsense"), std::logic_error);
  EXPECT_THROW(root.integer("name"), std::logic_error);
}

TEST(Reference, NamesEveryKeyWithUnitRangeAndDefault) {
  const std::string page = reference_page(schema());
  EXPECT_THAT(page, HasSubstr("# Test file"));
  EXPECT_THAT(page, HasSubstr("| `size` | quantity [`m`] | `5 mm` | mesh size |"));
  EXPECT_THAT(page, HasSubstr("| `density` | quantity [`kg/m^3`], > 0 | **required** | mass per volume |"));
  EXPECT_THAT(page, HasSubstr("`[[joint]]`"));
  EXPECT_THAT(page, HasSubstr("`type = \"spring\"`"));
  EXPECT_THAT(page, HasSubstr("`[body.NAME]`"));
}

// A variant under another name says in its schema which one it is: it stands once, its synonyms in its heading.
TEST(Reference, ATypeStandsOnceWithItsSynonymsInItsHeading) {
  TableSchema joint;
  joint.name = "joint";
  joint.selector = "type";
  for (const char* name : {"hinge", "pin", "revolute"})
    joint.variants[name] = {
        .name = "revolute", .doc = "Turns.", .keys = {quantity("angle", dim::angle, "at the start")}};
  joint.variants["slider"] = {.name = "what slides", .doc = "Slides."};  // a title, no other variant's name
  const std::string page = reference_page(joint);
  EXPECT_THAT(page, HasSubstr("## `type = \"revolute\"`, `\"hinge\"`, `\"pin\"`\n"));
  EXPECT_THAT(page, HasSubstr("## `type = \"slider\"`\n"));
  EXPECT_EQ(page.find("Turns."), page.rfind("Turns."));
}

// What a connection takes is told under the joint of the same name: there with all keys, here by name.
TEST(Reference, ATypeOfAnotherTableIsToldOnce) {
  TableSchema turns, slides, joint, connection, file;
  turns.doc = "Turns.";
  turns.keys = {quantity("angle", dim::angle, "at the start"), quantity("drive", dim::angle, "by a formula")};
  slides.doc = "Slides.";
  joint.selector = connection.selector = "type";
  joint.variants = {{"revolute", turns}, {"slider", slides}};
  turns.keys.pop_back();
  slides.doc = "Slides otherwise.";
  connection.variants = {{"revolute", turns}, {"slider", slides}};
  file.name = "file";
  file.keys = {table_map("joint", joint, "joints"), table_map("connection", connection, "connections")};
  const std::string page = reference_page(file);
  EXPECT_EQ(page.find("Turns."), page.rfind("Turns."));
  EXPECT_THAT(page, HasSubstr("| `type = \"revolute\"` | `[joint.NAME]` | `angle` |\n"));
  EXPECT_THAT(page, HasSubstr("Slides otherwise."));
}

// 1500 damaged files and overrides: each is read or refused with a message that names the file,
// nothing else.
TEST_F(Document, DamagedFilesAreReadOrRefused) {
  std::mt19937 generator(1);
  const auto pick = [&](std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(generator);
  };
  const std::string text = good;
  const std::vector<std::string> pieces = {"[",       "]",
                                           "[[",      "]]",
                                           "=",       "\"",
                                           "'",       ".",
                                           "\n",      "nan",
                                           "inf",     "-",
                                           "1e999",   "{",
                                           "}",       "9223372036854775807",
                                           "\xff",    std::string(1, '\0'),
                                           "x = ",    "\"\"\"",
                                           "#",       "mm",
                                           "kg/(m",   "^^",
                                           "0x",      "1979-05-27",
                                           "[joint]", "[body]",
                                           "true",    ","};
  int read_well = 0, refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string bad = text;
    for (std::size_t change = 0; change <= pick(3); ++change) {
      const std::size_t at = pick(bad.size());
      switch (pick(4)) {
        case 0:
          bad.erase(at, 1 + pick(20));
          break;
        case 1:
          bad.insert(at, pieces[pick(pieces.size())]);
          break;
        case 2:
          bad[at] = static_cast<char>(pick(256));
          break;
        default:
          bad.insert(at, bad.substr(pick(bad.size()), pick(40)));
      }
    }
    std::vector<std::string> overrides;
    if (i % 4 == 0) overrides.push_back(bad.substr(pick(bad.size()), pick(30)));
    const std::string message = refusal(bad, overrides);
    message == "accepted" ? ++read_well : ++refused;
    if (message != "accepted") {
      EXPECT_TRUE(message.starts_with("engine.toml:") || message.starts_with("command line")) << message;
    }
  }
  EXPECT_GT(read_well, 10);
  EXPECT_GT(refused, 100);
}

}  // namespace
}  // namespace flexura::input
