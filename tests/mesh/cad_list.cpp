// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>
#include <thread>

#include "tests/mesh/cad_parts.hpp"
#include "tests/mesh/scratch.hpp"

namespace flexura::mesh {
namespace {

using ::testing::HasSubstr;

std::string refusal(const CadOptions& options, bool with_mesh = false) {
  try {
    with_mesh ? (void)mesh_cad(options) : (void)list_faces(options);
  } catch (const std::exception& e) {
    return e.what();
  }
  return "(accepted)";
}

std::string content_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Volumes and centroids in mm that OpenCASCADE itself prints for these parts (cases/cad_parts/
/// occ_mass_properties.txt, six decimals): half a unit of the last digit, and 1e-9 of the volume for the
/// units.
TEST(CadList, SolidsHaveTheirPublishedMassProperties) {
  struct Row {
    const char* file;
    int solid;
    double volume, x, y, z;
  };
  for (const Row& row :
       {Row{"chrono_assembly.stp", 2, 265542.309104, 18.139098, -6.712111, 80.093985},
        Row{"chrono_assembly.stp", 4, 265542.309104, 0, 21.287889, 5.195460},
        Row{"odri_hip_aa_support.step", 1, 17413.813660, -27.130885, 0.000003, 4.503852},
        Row{"odri_lower_leg_structure_fork.step", 1, 4184.052643, -6.596878, 0.000001, -141.168833},
        Row{"odri_motor_antigravity_4004_custom_shaft.step", 1, 413.399134, 0, 0, -16.582935}}) {
    const CadReport report = list_faces(options_for(part_file(row.file)));
    const CadSolid& solid = report.solids.at(static_cast<std::size_t>(row.solid - 1));
    EXPECT_NEAR(1e9 * solid.volume, row.volume, 1e-6 + 1e-9 * row.volume) << row.file;
    EXPECT_LT((1e3 * solid.centroid - Eigen::Vector3d(row.x, row.y, row.z)).cwiseAbs().maxCoeff(), 1e-6)
        << row.file;
  }
}

TEST(CadList, ASolidGivenTwiceIsNoticed) {
  const CadReport report = list_faces(options_for(part_file("chrono_assembly.stp")));
  ASSERT_EQ(report.solids.size(), 4u);
  EXPECT_EQ(report.solids[2].same_as, 1);
  EXPECT_EQ(report.solids[1].same_as, 0);
  EXPECT_EQ(report.solids[3].same_as, 0);  // the same part in another place is another solid
  EXPECT_EQ(report.unit, "m");
  EXPECT_THAT(report.messages,
              ::testing::Contains(HasSubstr("solid 3 is solid 1 given twice in the same place")));
  EXPECT_TRUE(
      std::none_of(report.faces.begin(), report.faces.end(), [](const Face& f) { return f.solid == 3; }));
}

/// The conrod's bores as its conrod.geo states them: radius 25 mm about the z axis and 15 mm about the
/// parallel at x = 300 mm.  STEP holds 15 digits, the fit is exact for true cylinders: 1e-9 m.
TEST(CadList, BoresOfTheConrodAreRecognised) {
  const CadReport report = list_faces(options_for(project("cases/steam_engine/conrod.step")));
  EXPECT_EQ(report.unit, "mm");
  int found = 0;
  for (const Face& face : report.faces) {
    if (face.kind != FaceKind::cylinder || !face.hole || face.sweep < 6) continue;
    const bool big = face.axis_point.x() < 0.1;
    EXPECT_NEAR(face.radius, big ? 0.025 : 0.015, 1e-9);
    EXPECT_LT((face.axis_point - Eigen::Vector3d(big ? 0 : 0.3, 0, 0)).norm(), 1e-9);
    EXPECT_LT((face.axis - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(face.length, big ? 0.036 : 0.032, 1e-9);
    EXPECT_NEAR(face.area, 2 * std::numbers::pi * face.radius * face.length, 1e-9);
    EXPECT_NEAR(face.sweep, 2 * std::numbers::pi, 1e-6);
    ++found;
  }
  EXPECT_EQ(found, 2);
}

TEST(CadList, ReadsBrepAndIges) {
  const CadReport brep = list_faces(options_for(project("tests/mesh/data/drilled_box.brep")));
  EXPECT_NEAR(1e9 * brep.solids.at(0).volume, 6000 - std::numbers::pi * 9 * 30, 1e-6);
  EXPECT_THAT(brep.messages, ::testing::Contains(HasSubstr("BREP files have no unit")));
  CadOptions options = options_for(project("tests/mesh/data/box.igs"));
  const CadReport iges = list_faces(options);  // six loose faces
  EXPECT_NEAR(1e9 * iges.solids.at(0).volume, 6000, 1e-6);
  EXPECT_EQ(iges.unit, "mm");
  EXPECT_THAT(iges.messages, ::testing::Contains(HasSubstr("sewn to a solid")));
  EXPECT_EQ(iges.faces.size(), 6u);
}

/// The same numbers in other units: the file's own declaration changed, or overridden.
TEST(CadList, UnitsConvertLengths) {
  const std::string path = part_file("odri_motor_antigravity_4004_custom_shaft.step");
  const double volume = 413.399134e-9;
  CadOptions options = options_for(path);
  options.unit = "inch";
  const CadReport inch = list_faces(options);
  EXPECT_NEAR(inch.solids.at(0).volume / volume, 25.4 * 25.4 * 25.4, 1e-4);
  EXPECT_THAT(inch.messages,
              ::testing::Contains(HasSubstr("the file says mm; its numbers are taken as inch")));

  std::string text = content_of(path);
  for (std::size_t at; (at = text.find(".MILLI.")) != std::string::npos;) text.replace(at, 7, ".CENTI.");
  const Scratch centimetres("shaft.step", text);
  const CadReport cm = list_faces(options_for(centimetres.path().string()));
  EXPECT_EQ(cm.unit, "cm");
  EXPECT_NEAR(cm.solids.at(0).volume / volume, 1000, 1e-5);
  CadOptions back = options_for(centimetres.path().string());
  back.unit = "mm";
  EXPECT_NEAR(list_faces(back).solids.at(0).volume / volume, 1, 1e-8);
  back.unit = "furlong";
  EXPECT_THAT(refusal(back), HasSubstr("\"furlong\" is no unit of length"));
}

TEST(CadRefusal, OfWhatIsNoCadFile) {
  const auto of = [](const std::string& name, const std::string& text) {
    const Scratch file(name, text);
    return refusal(options_for(file.path().string()));
  };
  EXPECT_THAT(refusal(options_for("nowhere/conrod.step")), HasSubstr("nowhere/conrod.step: no such file"));
  EXPECT_THAT(refusal(options_for("/")), HasSubstr("is a folder"));
  EXPECT_THAT(of("a.step", ""), HasSubstr("a.step: is empty"));
  EXPECT_THAT(of("a.step", "once upon a time\n"),
              HasSubstr("a.step: not a STEP file: it does not begin with ISO-10303-21 (it begins with \"once "
                        "upon a time.\")"));
  EXPECT_THAT(of("a.igs", "once\n"), HasSubstr("not an IGES file"));
  EXPECT_THAT(of("a.brep", "once\n"), HasSubstr("not a BREP file"));
  EXPECT_THAT(of("a.txt", "once\n"), HasSubstr("neither a STEP, an IGES, a BREP nor an STL file"));
  const std::string shaft = content_of(part_file("odri_motor_antigravity_4004_custom_shaft.step"));
  EXPECT_THAT(of("a.step", shaft.substr(0, shaft.size() / 2)), HasSubstr("is a STEP file cut short"));
  EXPECT_THAT(of("a.step", "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"),
              HasSubstr("a.step: "));
}

TEST(CadRefusal, OfOptionsAndChoices) {
  CadOptions options = options_for(part_file("chrono_assembly.stp"));
  EXPECT_THAT(refusal(options, true),
              AllOf(HasSubstr("3 solids to mesh; choose one by its number (solid = 1 in the table "
                              "[geometry]), or join those that "
                              "touch (fuse = true there):\n  solid 1 \"body1\": 518384 mm^3")));
  options.solids = {7};
  EXPECT_THAT(refusal(options, true), HasSubstr("there is no solid 7; it has\n  solid 1"));
  CadOptions apart = options_for(project("tests/mesh/data/two_touching_one_apart.step"));
  apart.fuse = true;
  EXPECT_THAT(refusal(apart, true), HasSubstr("its solids do not fuse to one"));
  CadOptions bad = options_for(project("cases/steam_engine/conrod.step"));
  bad.order = 3;
  EXPECT_THAT(refusal(bad), HasSubstr("element order 3 is not possible; take 1 (tet4) or 2 (tet10)"));
  bad.order = 2;
  bad.size = -1;
  EXPECT_THAT(refusal(bad), HasSubstr("mesh size -1 m is negative"));
  CadOptions lost = options_for(project("cases/steam_engine/conrod.step"));
  lost.worker = "/nowhere/flexura-mesh";
  EXPECT_THAT(refusal(lost), HasSubstr("the meshing program /nowhere/flexura-mesh is missing"));
}

/// Stand-ins for the meshing program: what hangs is killed when its time is up, what crashes is reported.
TEST(MeshingChild, HangsAndCrashesBecomeSentences) {
  CadOptions options = options_for(project("cases/steam_engine/conrod.step"));
  const auto with = [&](const std::string& script) {
    const Scratch program("flexura-mesh", "#!/bin/sh\n" + script + "\n");
    chmod(program.path().c_str(), 0755);
    options.worker = program.path();
    return refusal(options);
  };
  options.time_limit_s = 0.3;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_THAT(with("exec sleep 60"),
              HasSubstr("conrod.step: reading the CAD file failed: it was not done within 0.3 s"));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
  options.time_limit_s = 30;
  EXPECT_THAT(with("kill -SEGV $$"),
              HasSubstr("made the mesher fail: it stopped with signal 11 (Segmentation fault)"));
  EXPECT_THAT(with("echo 'Error   : no luck'; exit 3"), HasSubstr("ended with code 3 (gmsh: no luck)"));
  EXPECT_THAT(with("printf abc >&3"), HasSubstr("handed over an incomplete result"));
}

/// Processes that carry a mark in their environment, without this one's own child `except`.
int count_marked(const std::string& mark, pid_t except) {
  int n = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string pid = entry.path().filename();
    if (pid.find_first_not_of("0123456789") != std::string::npos || pid == std::to_string(except)) continue;
    n += content_of(entry.path() / "environ").find(mark) != std::string::npos;
  }
  return n;
}

/// A program that is killed while its part is meshed takes the mesher with it.
TEST(MeshingChild, DiesWithItsParent) {
  const std::string mark = "FLEXURA_TEST_MARK=" + std::to_string(getpid());
  const pid_t parent = fork();
  if (parent == 0) {
    putenv(strdup(mark.c_str()));
    try {
      mesh_cad(options_for(part_file("odri_lower_leg_structure_base.step")));
    } catch (...) {
    }
    _exit(0);
  }
  const auto wait_for = [&](bool running) {
    for (int k = 0; k < 1000 && (count_marked(mark, parent) > 0) != running; ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return count_marked(mark, parent) > 0;
  };
  EXPECT_TRUE(wait_for(true));
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // the mesher asks for its fate when it starts
  kill(parent, SIGKILL);
  waitpid(parent, nullptr, 0);
  EXPECT_FALSE(wait_for(false));
}

TEST(MeshingChild, TheRealOneIsKilledInTime) {
  CadOptions options = options_for(project("cases/steam_engine/conrod.step"));
  options.time_limit_s = 0.005;  // not even its libraries are loaded by then
  EXPECT_THAT(refusal(options, true), HasSubstr("was not done within 0.005 s"));
}

}  // namespace
}  // namespace flexura::mesh
