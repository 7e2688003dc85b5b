// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// flexura reduce --list-faces --html: numbers on the faces of a part.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/app/command.hpp"
#include "tests/view/page_reader.hpp"

namespace flexura::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::Not;
using view::testing::PageReader;

const std::string kConrod = FLEXURA_SOURCE_DIR "/cases/steam_engine/conrod.step";

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
    EXPECT_THAT(shown["lines"].get<std::string>(),
                HasSubstr("faces = [" + std::to_string(shown["number"].get<int>()) + "]"));
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
  EXPECT_THAT(faces[11]["lines"].get<std::string>(), HasSubstr("write faces = [12, 22] for all of it"));
  // Two fillets of a slot are none.
  EXPECT_THAT(faces[53]["lines"].get<std::string>(), Not(HasSubstr("all of it")));
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
