// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// Links whose pictures are COLLADA and STEP files, and links that become flexible because their pictures are closed.
#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <numbers>
#include <tuple>

#include "mbs/superelement/file.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kCube = R"(<mesh>
  <source id="s"><float_array id="f" count="32">0 0 0 7 1 0 0 7 0 1 0 7 1 1 0 7 0 0 1 7 1 0 1 7 0 1 1 7 1 1 1 7</float_array>
   <technique_common><accessor source="#f" count="8" stride="4"/></technique_common></source>
  <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
  <polylist count="5"><input semantic="VERTEX" source="#v" offset="1"/><input semantic="NORMAL" source="#s" offset="0"/>
   <vcount>4 4 4 4 4</vcount>
   <p>0 0 0 2 0 3 0 1  0 4 0 5 0 7 0 6  0 0 0 1 0 5 0 4  0 2 0 6 0 7 0 3  0 0 0 4 0 6 0 2</p></polylist>
  <tristrips count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>1 3 5 7</p></tristrips></mesh>)";

std::string collada(const std::string& geometry, const std::string& nodes) {
  return "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><asset><unit "
         "meter=\"0.001\"/><up_axis>Y_UP</up_axis></asset>"
         "<library_geometries><geometry id=\"g\">" +
         geometry +
         "</geometry></library_geometries><library_nodes><node id=\"part\"><scale>400 100 20</scale>"
         "<instance_geometry url=\"#g\"/></node></library_nodes><library_visual_scenes><visual_scene "
         "id=\"v1\">" +
         nodes +
         "</visual_scene></library_visual_scenes><scene><instance_visual_scene "
         "url=\"#v1\"/></scene></COLLADA>";
}

std::string robot(const std::string& mesh, const std::string& more = "") {
  return R"(<robot name="r">
 <link name="base"><inertial><mass value="5"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
 <link name="arm"><inertial><origin xyz="0.2 0 0"/><mass value="2.16"/><inertia ixx="0.002" iyy="0.03" izz="0.03"/></inertial>
  <visual><geometry><mesh filename=")" +
         mesh + "\"/></geometry></visual>" + more + R"(</link>
 <joint name="a" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/></joint></robot>)";
}

// Turned, moved and by a node elsewhere: x -> (400 x, 100 y - 50, 20 z - 10) mm.
constexpr const char* kNodes =
    "<node><matrix>1 0 0 0  0 1 0 -50  0 0 1 -10  0 0 0 1</matrix><node><rotate>0 0 1 90</rotate><rotate>0 0 "
    "1 "
    "-90</rotate><instance_node url=\"#part\"/></node></node>";

TEST(UrdfMeshes, ColladaStandsWhereItsSceneSaysInItsUnit) {
  const Folder folder;
  folder.write("box.dae", collada(kCube, kNodes));
  const auto urdf = folder.write("r.urdf", robot("box.dae"));
  const Outcome imported = run("flexura", {"import", urdf, "-o", folder / "out"});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  const auto se = superelement::read(folder / "out/parts/arm.se.h5", {.surface = true});
  ASSERT_EQ(se.surface.triangles.rows(), 12);
  ASSERT_EQ(se.surface.vertices.rows(), 8);
  EXPECT_NEAR((se.surface.vertices.colwise().minCoeff() - Eigen::RowVector3d(0, -0.05, -0.01)).norm(), 0.0,
              1e-12);
  EXPECT_NEAR((se.surface.vertices.colwise().maxCoeff() - Eigen::RowVector3d(0.4, 0.05, 0.01)).norm(), 0.0,
              1e-12);
  // Turned outwards all over, strips as well: the volume by the divergence theorem.
  double volume = 0.0;
  for (Eigen::Index t = 0; t < 12; ++t) {
    Eigen::Matrix3d x;
    for (int k = 0; k < 3; ++k) x.col(k) = se.surface.vertices.row(se.surface.triangles(t, k)).transpose();
    volume += x.determinant() / 6.0;
  }
  EXPECT_NEAR(volume, 0.4 * 0.1 * 0.02, 1e-12);
}

TEST(UrdfMeshes, DamagedColladaCostsThePictureAndSaysWhy) {
  const std::string good = collada(kCube, kNodes);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::pair<std::string, const char*> cases[] = {
      {good.substr(0, good.size() / 2), "is not XML"},
      {"<svg/>", "is no COLLADA document (it begins with <svg>)"},
      {with("#part", "#lost"), "names \"#lost\", which the file does not hold"},
      {with("0 5 0 4", "0 5 0 99"), "names vertex 99 of 8"},
      {with("0 5 0 4", "0 5 0 x"), "no number"},
      {with("<vcount>4", "<vcount>400"), "fewer corners than <vcount> says"},
      {with("<scale>400 100 20", "<instance_node url=\"#part\"/><scale>400 100 20"), "within themselves"},
      {with("meter=\"0.001\"", "meter=\"-1\""), "unit is not positive"},
      {with("POSITION", "COLOR"), "POSITION"},
  };
  for (const auto& [text, why] : cases) {
    SCOPED_TRACE(why);
    const Folder folder;
    folder.write("box.dae", text);
    const auto urdf = folder.write("r.urdf", robot("box.dae"));
    const Outcome imported = run("flexura", {"import", urdf, "-o", folder / "out"});
    EXPECT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_THAT(imported.err, HasSubstr("link \"arm\" without that picture: "));
    EXPECT_THAT(imported.err, HasSubstr(why));
  }
}

TEST(UrdfMeshes, ALinkWithAClosedPictureBecomesFlexibleByReduce) {
  const Folder folder;
  folder.write("box.dae", collada(kCube, kNodes));
  const auto urdf = folder.write("r.urdf", robot("box.dae"));
  ASSERT_EQ(run("flexura", {"import", urdf, "-o", folder / "out"}).exit_code, 0);
  const Outcome ran = run(
      "flexura", {"simulate", folder / "out/mechanism.toml", "--reduce", "--set", "body.arm.fidelity=modal",
                  "--end-time", "0.01", "--no-estimate", "-o", folder / "r.h5"});
  ASSERT_EQ(ran.exit_code, 0) << ran.err;
  int made = 0;
  for (const auto& entry : fs::directory_iterator(folder / "out/parts/reduced")) {
    if (!entry.path().string().ends_with(".se.h5")) continue;
    ++made;
    const auto se = superelement::read(entry.path());
    EXPECT_NEAR(se.inertia.mass, 2.16, 1e-6);
    EXPECT_NEAR(se.inertia.S_x.x() / se.inertia.mass, 0.2, 1e-6);
  }
  EXPECT_EQ(made, 1);
}

TEST(UrdfMeshes, OfACadFileAreClosedOnceItsFacesAreWelded) {
  const Folder folder;
  const auto urdf =
      folder.write("r.urdf", robot("file://" FLEXURA_SOURCE_DIR "/cases/steam_engine/conrod.step"));
  const Outcome imported = run("flexura", {"import", urdf, "-o", folder / "out"});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_TRUE(fs::exists(folder / "out/parts/arm.toml")) << imported.err;
  EXPECT_THAT(imported.err, Not(HasSubstr("cannot be made flexible")));
}

TEST(UrdfMeshes, OpenPicturesAndSeveralBodiesAreNamed) {
  const Folder folder;
  folder.write("two.dae", collada(kCube, kNodes));
  const auto urdf = folder.write(
      "r.urdf",
      robot("two.dae",
            "<visual><origin xyz=\"0 0 1\"/><geometry><mesh filename=\"two.dae\"/></geometry></visual>"));
  const Outcome imported = run("flexura", {"import", urdf, "-o", folder / "out"});
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_THAT(
      imported.err,
      HasSubstr("arm cannot be made flexible by --reduce: its picture is no closed surface of one body"));
  EXPECT_FALSE(fs::exists(folder / "out/parts/arm.toml"));
}

// A box of 8e-4 m^3: of aluminium's density within 10 % it keeps the link's mass; hollow it takes both constants of the nearest material.
TEST(UrdfMeshes, PartsTakeModulusAndDensityOfOneMaterial) {
  for (const auto& [mass, material, density] :
       {std::tuple("2.2", "[material.aluminium]\nyoung = \"70 GPa\"", "density = 2750"),
        std::tuple("6.0", "[material.steel]\nyoung = \"210 GPa\"", "density = 7500"),
        std::tuple("0.08", "[material.polymer]\nyoung = \"2.3 GPa\"", "density = 1050")}) {
    const Folder folder;
    const auto file = folder.write(
        "r.urdf",
        test::robot(link("a", std::string("<inertial><mass value=\"") + mass +
                                  R"("/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
             <visual><origin rpy="0 0 1"/><geometry><box size="0.4 0.04 0.05"/></geometry></visual>)")));
    const Outcome outcome = run("flexura", {"import", file, "-o", folder / "out"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const std::string part = read_text(folder / "out/parts/a.toml");
    EXPECT_THAT(part, HasSubstr(material));
    EXPECT_THAT(part, HasSubstr(density));
  }
}

}  // namespace
}  // namespace flexura::test
