// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura reduce --list-faces --html: numbers on the faces of a part.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "mesh/gmsh/cad.hpp"
#include "mesh/model/select.hpp"
#include "reduce/file/part_file.hpp"
#include "tests/app/command.hpp"
#include "tests/view/page_reader.hpp"

namespace flexura::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using view::testing::PageReader;

const std::string kConrod = FLEXURA_SOURCE_DIR "/cases/steam_engine/conrod.step";
const std::string kWorker = FLEXURA_BIN_DIR "/flexura-mesh";

TEST(FacesPage, ShowsEveryFaceThatIsListedUnderItsNumber) {
  const Folder folder;
  const Outcome o = run("flexura", {"reduce", "--list-faces", kConrod, "--html", folder / "faces.html"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  const PageReader page(read_text(folder / "faces.html"));
  EXPECT_EQ(page.header["ground"], -1);
  const json& part = page.header["parts"][0];
  // Area of the triangles of each face [mm^2].
  const std::string key = part["key"];
  const auto v = page.block<float>(key + "/vertices");
  const auto triangles = page.block<std::int32_t>(key + "/triangles"),
             face = page.block<std::int32_t>(key + "/face");
  std::map<std::int32_t, double> area;
  const auto corner = [&](std::size_t i) {
    const auto k = 3 * static_cast<std::size_t>(triangles[i]);
    return Eigen::Vector3d(v[k], v[k + 1], v[k + 2]);
  };
  for (std::size_t t = 0; t < face.size(); ++t) {
    const Eigen::Vector3d a = corner(3 * t);
    area[face[t]] += 0.5e6 * (corner(3 * t + 1) - a).cross(corner(3 * t + 2) - a).norm();
  }
  // Beside what the terminal says: "  face 12: bore, ..., area 314.2 mm^2".
  std::istringstream lines(o.out);
  std::size_t listed = 0;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  face ")) continue;
    ASSERT_LT(listed, part["faces"].size());
    const json& shown = part["faces"][listed];
    EXPECT_EQ(shown["number"], std::stoi(line.substr(7)));
    EXPECT_THAT(line, HasSubstr(shown["text"].get<std::string>()));
    const double exact = std::stod(line.substr(line.find("area ") + 5));
    // Twenty pieces around a circle: a polygon's area is less by (2 pi / 20)^2 / 6 = 1.6 %, of a narrow ring by twice that.
    EXPECT_NEAR(area[static_cast<std::int32_t>(listed)], exact, 0.035 * exact) << line;
    ++listed;
  }
  EXPECT_EQ(listed, part["faces"].size());
  EXPECT_GT(listed, 5U);
}

TEST(FacesPage, OffersABoreThatTheFileHasCutIntoHalvesAsOne) {
  // The seat of the hip's motor, of radius 12.5 mm: faces 12 and 22, 180 deg each.
  const Folder folder;
  const Outcome o = run(
      "flexura", {"reduce", "--list-faces", FLEXURA_SOURCE_DIR "/cases/cad_parts/odri_hip_aa_support.step",
                  "--html", folder / "faces.html"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.out, HasSubstr("# faces 12 and 22 together\n[interface.bore]\nby = \"cylinder\"\n"));
  EXPECT_THAT(o.out, HasSubstr("radius = \"12.5 mm\""));
  const PageReader page(read_text(folder / "faces.html"));
  const json& faces = page.header["parts"][0]["faces"];
  EXPECT_THAT(faces[11]["lines"].get<std::string>(), HasSubstr("by = \"cylinder\"\n"));
  EXPECT_THAT(faces[11]["lines"].get<std::string>(), HasSubstr("# faces 12 and 22 together\n"));
  EXPECT_EQ(faces[11]["lines"], faces[21]["lines"]);  // the page writes it once
  // Two fillets of a slot are none.
  EXPECT_THAT(faces[53]["lines"].get<std::string>(), Not(HasSubstr("together")));
}

/// What a part file with these lines chooses on the part's mesh.
std::vector<mesh::Index> chosen(const Folder& folder, const std::string& step, const std::string& lines,
                                const mesh::CadMesh& part) {
  const auto file = folder.write(
      "part.toml",
      "[geometry]\nfile = \"" + step +
          "\"\n[material.steel]\nyoung = 2.1e11\npoisson = 0.3\ndensity = 7850.0\n[interface.chosen]\n" +
          lines);
  const reduce::PartInput input = reduce::read_part(file);
  return mesh::select_nodes(part.mesh, part.cad.faces, input.interfaces.at(0).rule).face_numbers;
}

// Whatever face is ticked, and whatever lies in line with it, beside it in its plane or across a slot: the table of the page chooses
// this face (of a bore in pieces all of them), without its number, which the next drawing gives to another.
TEST(FacesPage, WritesATableThatChoosesTheTickedFaceByItsGeometry) {
  const Folder folder;
  std::size_t tried = 0, by_surface = 0, in_line = 0, near = 0;
  for (const char* const name : {"steam_engine/conrod.step", "cad_parts/odri_hip_aa_support.step",
                                 "cad_parts/odri_lower_leg_structure_fork.step",
                                 "cad_parts/odri_motor_antigravity_4004_custom_shaft.step"}) {
    SCOPED_TRACE(name);
    const std::string step = std::string(FLEXURA_SOURCE_DIR "/cases/") + name;
    ASSERT_EQ(run("flexura", {"reduce", "--list-faces", step, "--html", folder / "faces.html"}).exit_code, 0);
    const PageReader page(read_text(folder / "faces.html"));
    // As coarse as the smallest faces allow: what is chosen does not depend on it.
    const mesh::CadMesh part =
        mesh::mesh_cad({.path = step, .order = 1, .most_triangles = 6000, .worker = kWorker});
    for (const json& face : page.header["parts"][0]["faces"]) {
      const std::string lines = face["lines"];
      SCOPED_TRACE(lines);
      std::vector<mesh::Index> expected = {face["number"].get<mesh::Index>()};
      if (const auto from = lines.find("# faces "); from != std::string::npos) {
        std::istringstream words(lines.substr(from + 8));
        expected.clear();
        for (std::string word; words >> word;)
          if (word != "and" && word != "together") expected.push_back(std::stoi(word));
      }
      EXPECT_EQ(chosen(folder, step, lines, part), expected);
      EXPECT_THAT(lines, Not(HasSubstr("by = \"faces\"")));
      ++tried;
      by_surface += lines.find("by = \"cylinder\"") == 0 || lines.find("by = \"plane\"") == 0;
      in_line += lines.find("extent") != std::string::npos;
      near += lines.find("by = \"near\"") == 0;
    }
  }
  EXPECT_GE(tried, 200U);
  EXPECT_GE(by_surface, 100U);
  EXPECT_GE(in_line, 2U);
  EXPECT_GE(near, 20U);
}

// The page's text for a bore of a link, on the same link with one hole more: it still is that bore.
TEST(FacesPage, ChoosesTheSameBoreAfterAChangeOfTheDrawing) {
  const std::string before = FLEXURA_SOURCE_DIR "/tests/app/link.step",
                    after = FLEXURA_SOURCE_DIR "/tests/app/link_with_hole.step";
  const Folder folder;
  ASSERT_EQ(run("flexura", {"reduce", "--list-faces", before, "--html", folder / "faces.html"}).exit_code, 0);
  const PageReader page(read_text(folder / "faces.html"));
  const mesh::CadMesh old = mesh::mesh_cad({.path = before, .order = 1, .worker = kWorker}),
                      changed = mesh::mesh_cad({.path = after, .order = 1, .worker = kWorker});
  const auto face_of = [](const mesh::CadMesh& part, mesh::Index number) {
    return *std::ranges::find(part.cad.faces, number, &mesh::Face::number);
  };
  int bores = 0;
  for (const json& face : page.header["parts"][0]["faces"]) {
    if (!face["text"].get<std::string>().starts_with("bore")) continue;
    const mesh::Face was = face_of(old, face["number"].get<mesh::Index>());
    const auto now = chosen(folder, after, face["lines"], changed);
    ASSERT_EQ(now.size(), 1U);
    EXPECT_NEAR(face_of(changed, now[0]).radius, was.radius, 1e-9);
    EXPECT_NEAR((face_of(changed, now[0]).axis_point - was.axis_point).norm(), 0.0, 1e-9);
    ++bores;
  }
  EXPECT_EQ(bores, 2);
}

TEST(FacesPage, NeverWritesOverAPart) {
  const Folder folder;
  const auto copy = folder.write("part.step", read_text(kConrod));
  // "--html part.step" with the part forgotten, or behind it.
  const Outcome o = run("flexura", {"reduce", "--list-faces", copy, "--html", copy});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, HasSubstr("must end in .html"));
  EXPECT_EQ(read_text(copy), read_text(kConrod));
  const Outcome alone = run("flexura", {"reduce", copy, "--html", folder / "x.html"});
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_THAT(alone.err, HasSubstr("--html is the picture of --list-faces"));
}

TEST(FacesPage, StandsBesideThePartWhereNoNameIsGiven) {
  const Folder folder;
  const auto copy = folder.write("rod.step", read_text(kConrod));
  const Outcome o = run("flexura", {"reduce", "--list-faces", copy, "--html"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_TRUE(std::filesystem::exists(folder / "rod.faces.html"));
}

}  // namespace
}  // namespace flexura::test
