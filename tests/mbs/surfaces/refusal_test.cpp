// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gmock/gmock.h>

#include "mbs/superelement/file.hpp"
#include "tests/mbs/cases/text_case.hpp"
#include "tests/mbs/model/lattice.hpp"
#include "tests/mbs/surfaces/plate.hpp"

/// What is no surface in contact, each by its key and with a remedy; and which part of a surface a region is.
namespace flexura::mbs::surfaces {
namespace {

using cases::now;
using ::testing::AllOf;
using ::testing::HasSubstr;

class Regions : public cases::TextCase {
 protected:
  void SetUp() override {
    cases::TextCase::SetUp();
    superelement::write(folder_ / "plate.se.h5", plate(0.4, 8, 1.0));
    superelement::Superelement bare = plate(0.4, 8, 1.0);
    bare.surface = {};
    bare.shapes.resize(0, 6);
    superelement::write(folder_ / "bare.se.h5", bare);
  }
  static std::string text(const std::string& contact, const std::string& file = "plate",
                          const std::string& position = "[0, 0, -0.001]") {
    return "[body.plate]\nsuperelement = \"" + file +
           ".se.h5\"\nfidelity = \"rigid\"\nposition = " + position +
           "\n[body.ball]\nmass = 1\ninertia = [1, 1, 1]\n[force.touch]\ntype = \"surface_contact\"\n" +
           contact;
  }
  static std::string on_plane(const std::string& more) {
    return text("body = \"plate\"\nfrom = \"ground\"\n" + more);
  }
};

TEST_F(Regions, HoldWholeFacets) {
  const auto nodes_and_area = [&](const std::string& region) {
    return now(prepared(on_plane("stiffness = 1e6\n" + region)), {"touch.nodes", "touch.area"});
  };
  const auto expect = [&](const std::string& region, double nodes, double area) {
    SCOPED_TRACE(region);
    const Eigen::VectorXd found = nodes_and_area(region);
    EXPECT_EQ(found(0), nodes);
    EXPECT_NEAR(found(1), area, 1e-9);
  };
  expect("", 81, 0.16);
  expect("interfaces = [\"middle\"]\n", 81, 0.16);
  expect("facing = [0, 0, -2]\nfacing_angle = \"10 deg\"\n", 81, 0.16);
  // Two by four squares of 50 mm, whose corners lie on the box.
  expect("box = [[0.1, 0.2, 0.1], [0, 0, -0.1]]\n", 15, 0.02);
  expect("box = [[0, 0, -0.1], [0.12, 0.2, 0.1]]\ninterfaces = [\"middle\"]\n", 15, 0.02);
}

TEST_F(Regions, AreRefusedWhereNothingIs) {
  const std::string k = "stiffness = 1e6\n";
  EXPECT_THAT(
      refusal(on_plane(k + "interfaces = [\"midle\"]\n")),
      AllOf(HasSubstr("force.touch.interfaces"), HasSubstr("no interface \"midle\""), HasSubstr("middle")));
  EXPECT_THAT(
      refusal(on_plane(k + "box = [[1, 1, 1], [2, 2, 2]]\n")),
      AllOf(HasSubstr("force.touch.box"), HasSubstr("no facet of the surface lies there"), HasSubstr("0.2")));
  EXPECT_THAT(refusal(on_plane(k + "box = [[1, 1, 1]]\n")), HasSubstr("two opposite corners"));
  EXPECT_THAT(refusal(on_plane(k + "facing = [0, 0, 1]\n")), HasSubstr("no facet of the surface lies there"));
  EXPECT_THAT(refusal(on_plane(k + "facing = [0, 0, 0]\n")), HasSubstr("has no length"));
  EXPECT_THAT(refusal(on_plane(k + "facing_angle = \"10 deg\"\n")), HasSubstr("give facing, too"));
}

TEST_F(Regions, NeedASurfaceOfTheirOwn) {
  const std::string rest = "from = \"ground\"\nstiffness = 1e6\n";
  EXPECT_THAT(refusal(text("body = \"ball\"\n" + rest)),
              AllOf(HasSubstr("force.touch.body"), HasSubstr("\"ball\" has no superelement")));
  EXPECT_THAT(refusal(text("body = \"ground\"\nfrom = \"plate\"\nstiffness = 1e6\n")),
              HasSubstr("\"ground\" has no superelement"));
  EXPECT_THAT(refusal(text("body = \"plte\"\n" + rest)), HasSubstr("there is no body \"plte\""));
  EXPECT_THAT(refusal(text("body = \"plate\"\n" + rest, "bare")),
              HasSubstr("has no surface with shapes on it"));
  EXPECT_THAT(refusal(text("body = \"plate\"\nfrom = \"plate\"\nstiffness = 1\n")),
              HasSubstr("is on the body that touches"));
  EXPECT_THAT(refusal(text("from = \"ground\"\nstiffness = 1\n")), HasSubstr("body"));
}

TEST_F(Regions, NeedALawThatPushes) {
  EXPECT_THAT(refusal(on_plane("stiffness = -1e6\n")),
              AllOf(HasSubstr("force.touch.stiffness"), HasSubstr("must be above 0")));
  EXPECT_THAT(refusal(on_plane("total_stiffness = 0\n")), HasSubstr("must be above 0"));
  EXPECT_THAT(refusal(on_plane("")), HasSubstr("stiffness is missing"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\ntotal_stiffness = 1\n")),
              HasSubstr("stands beside stiffness"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\ndamping = -1\n")), HasSubstr("must not be negative"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\nexponent = 0.5\n")), HasSubstr("exponent"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\nfriction = -0.1\n")), HasSubstr("friction"));
}

TEST_F(Regions, TouchShapesThatAreWhole) {
  EXPECT_THAT(refusal(on_plane("stiffness = 1\nsurface_radius = 1\n")), HasSubstr("a plane has none"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\ninside = true\n")), HasSubstr("a plane has no inside"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\nsurface = \"sphere\"\n")),
              HasSubstr("surface_radius is missing"));
  EXPECT_THAT(refusal(on_plane("stiffness = 1\nsurface = \"torus\"\n")), HasSubstr("surface"));
}

// The surface of another body.
TEST_F(Regions, TouchSurfacesOfOtherBodies) {
  const std::string rest = "stiffness = 1\n", both =
                                                  "[body.table]\nsuperelement = \"plate.se.h5\"\nfidelity = "
                                                  "\"rigid\"\nrotation = [3.14159265358979, 0, 0]\n";
  const auto on_table = [&](const std::string& more) {
    return both + text("body = \"plate\"\nfrom_body = \"table\"\n" + rest + more);
  };
  EXPECT_EQ(now(prepared(on_table("")), {"touch.nodes"})(0), 81.0);
  EXPECT_THAT(refusal(text("body = \"plate\"\nfrom_body = \"plate\"\n" + rest)),
              AllOf(HasSubstr("force.touch.from_body"), HasSubstr("is the body that touches"),
                    HasSubstr("name another body")));
  EXPECT_THAT(refusal(text("body = \"plate\"\nfrom_body = \"ball\"\n" + rest)),
              AllOf(HasSubstr("force.touch.from_body"), HasSubstr("\"ball\" has no superelement"),
                    HasSubstr("rigid")));
  EXPECT_THAT(refusal(text("body = \"plate\"\nfrom_body = \"bal\"\n" + rest)),
              HasSubstr("there is no body \"bal\""));
  EXPECT_THAT(refusal(on_table("from = \"ground\"\n")),
              AllOf(HasSubstr("force.touch.from ="), HasSubstr("from_body names a body")));
  EXPECT_THAT(refusal(on_table("surface = \"plane\"\n")), HasSubstr("keep one of them"));
  EXPECT_THAT(refusal(on_table("from_facing = [0, 0, 1]\n")),
              AllOf(HasSubstr("force.touch.from_facing"), HasSubstr("no facet of the surface lies there")));
  EXPECT_THAT(refusal(on_table("from_facing_angle = \"10 deg\"\n")), HasSubstr("give from_facing, too"));
  EXPECT_THAT(refusal(on_table("from_interfaces = [\"midle\"]\n")),
              AllOf(HasSubstr("force.touch.from_interfaces"), HasSubstr("no interface \"midle\"")));
  EXPECT_THAT(refusal(on_plane(rest + "from_facing = [0, 0, 1]\n")), HasSubstr("give from_body, too"));
  EXPECT_THAT(refusal(text("body = \"plate\"\n" + rest)), HasSubstr("from is missing"));
}

// A sheet has no side to touch unless one is chosen.
TEST_F(Regions, HaveASideToTouch) {
  superelement::Superelement sheet = plate(0.4, 8, 1.0);
  const auto n = sheet.surface.vertices.rows();
  const auto facets = sheet.surface.triangles.rows();
  sheet.surface.vertices.conservativeResize(2 * n, Eigen::NoChange);
  sheet.shapes.conservativeResize(6 * n, Eigen::NoChange);
  sheet.shapes.bottomRows(3 * n) = sheet.shapes.topRows(3 * n).eval();
  for (Eigen::Index v = 0; v < n; ++v)
    sheet.surface.vertices.row(n + v) = sheet.surface.vertices.row(v) + Eigen::RowVector3d(0, 0, 0.01);
  sheet.surface.triangles.conservativeResize(2 * facets, Eigen::NoChange);
  for (Eigen::Index t = 0; t < facets; ++t)
    sheet.surface.triangles.row(facets + t) << static_cast<int>(n) + sheet.surface.triangles(t, 0),
        static_cast<int>(n) + sheet.surface.triangles(t, 2),
        static_cast<int>(n) + sheet.surface.triangles(t, 1);
  sheet.surface.triangle_interface.assign(static_cast<std::size_t>(2 * facets), -1);
  superelement::write(folder_ / "sheet.se.h5", sheet);
  const auto with = [&](const std::string& more) {
    return "[body.sheet]\nsuperelement = \"sheet.se.h5\"\nfidelity = \"rigid\"\nposition = [0, 0, 1]\n" +
           text("body = \"plate\"\nfrom_body = \"sheet\"\nstiffness = 1\n" + more);
  };
  EXPECT_THAT(refusal(with("")), AllOf(HasSubstr("force.touch.from_body"),
                                       HasSubstr("look into opposite directions"), HasSubstr("from_facing")));
  EXPECT_NO_THROW(prepared(with("from_facing = [0, 0, 1]\n")));
}

// A superelement bears stiffening by loads on its interfaces only.
TEST_F(Regions, AreNotForStiffenedBodies) {
  lattice::Lattice l = lattice::make_lattice(4, 4e4);
  l.se.stiffening = lattice::any_stiffening(l.se.n(), 3);
  superelement::write(folder_ / "beam.se.h5", lattice::with_surface(l));
  EXPECT_THAT(
      refusal(
          "[body.beam]\nsuperelement = \"beam.se.h5\"\nfidelity = \"modal-stiffened\"\n[force.touch]\ntype "
          "= \"surface_contact\"\nbody = \"beam\"\nfrom = \"ground\"\nstiffness = 1\n"),
      AllOf(HasSubstr("body.beam.fidelity"), HasSubstr("acts on the body's surface")));
}

}  // namespace
}  // namespace flexura::mbs::surfaces
