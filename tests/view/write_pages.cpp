// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Writes what the browser's and the Python tests open:  view_write_pages DIRECTORY
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>

#include "mbs/superelement/file.hpp"
#include "mbs/view/parts_page.hpp"
#include "mbs/view/reports/report.hpp"
#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/view/synthetic.hpp"

namespace {

using namespace flexura::view;

/// One of everything a report can hold, with numbers known to the test.
Report sample_report() {
  Report report{.title = "sample · report", .summary = "One of everything.", .created_by = "flexura tests"};
  report.facts = {{"runs", "3"}, {"wall time", "1.5 s"}};
  report.add("Table").add(ReportTable{.title = "Runs",
                                      .columns = {{"run"}, {"wall time", "s"}, {"error"}},
                                      .rows = {{"modal", 0.3125, 2.0e-4},
                                               {"rigid", 0.02, {0.125, Tone::bad}},
                                               {"full", 12.0, {1.0e-7, Tone::good}}}});
  ReportCurve sine{.name = "sine", .x = {}, .y = {}}, points{.name = "points",
                                                             .x = {0.5, 1.0, 1.5},
                                                             .y = {0.5, 0.8, 0.1},
                                                             .style = CurveStyle::line_and_points,
                                                             .labels = {"a", "b", "c"}};
  for (int i = 0; i <= 200; ++i) {
    sine.x.push_back(0.01 * i);
    sine.y.push_back(std::sin(6.283185307179586 * sine.x.back()));
  }
  report.add("Plot")
      .add(ReportText{"A sine and three points."})
      .add(ReportNotice{Tone::warning, "the points are not measured"})
      .add(
          ReportPlot{.title = "Signals", .x = {"time", "s"}, .y = {"signal", "m"}, .curves = {sine, points}});
  report.add("Source").add(ReportCode{"input file", "key = 1\n"});
  return report;
}

/// A box from the origin along x; faces are numbered -x, +x, -y, +y, -z, +z.
DrawnPart bar(const std::string& name, double length) {
  DrawnPart part{.name = name, .file = "parts/" + name + ".toml", .color = ""};
  const Eigen::Vector3d low(0, -0.15, -0.1), high(length, 0.15, 0.1);
  for (int i = 0; i < 8; ++i)
    part.vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                               i & 4 ? high.z() : low.z());
  const int corners[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (int f = 0; f < 6; ++f) {
    const auto& c = corners[f];
    part.triangles.emplace_back(c[0], c[1], c[2]);
    part.triangles.emplace_back(c[0], c[2], c[3]);
    part.face.insert(part.face.end(), 2, f);
    for (int k = 0; k < 4; ++k) part.edges.emplace_back(c[k], c[(k + 1) % 4]);
    NumberedFace face{.number = f + 1, .text = "plane of the sample", .kind = "plane"};
    face.axis = Eigen::Vector3d::Unit(f / 2) * (f % 2 == 0 ? -1.0 : 1.0);
    face.point = 0.5 * (low + high) + 0.5 * (high - low).cwiseProduct(face.axis);
    face.lines = "by = \"plane\"\npoint = [0.0, 0.0, " + std::to_string(f) + "]\n";
    part.faces.push_back(face);
  }
  return part;
}

/// A four-bar linkage on hinges along z: ground 4 m, crank 1 m at 60 degrees, coupler 3.5 m, rocker 3 m.
PartsPage linkage() {
  const Eigen::Vector2d A(0, 0), D(4, 0), B(0.5, std::sqrt(0.75));
  const double r1 = 3.5, r2 = 3.0, d = (D - B).norm(), along = (r1 * r1 - r2 * r2 + d * d) / (2 * d);
  const Eigen::Vector2d u = (D - B) / d,
                        C = B + along * u +
                            std::sqrt(r1 * r1 - along * along) * Eigen::Vector2d(-u.y(), u.x());
  PartsPage page{.title = "linkage", .created_by = "flexura tests"};
  const auto add = [&](const char* body, const char* part, const Eigen::Vector2d& from,
                       const Eigen::Vector2d& to) {
    const Eigen::Vector2d x = (to - from).normalized();
    PlacedBody placed{.name = body, .text = "a bar", .part = static_cast<int>(page.parts.size())};
    placed.R_WB << x.x(), -x.y(), 0, x.y(), x.x(), 0, 0, 0, 1;
    placed.p_WB << from, 0;
    page.parts.push_back(bar(part, (to - from).norm()));
    page.bodies.push_back(placed);
  };
  add("frame", "frame", A, D);
  add("crank", "bar1", A, B);
  add("coupler", "bar2", B, C);
  add("rocker", "bar3", D, C);
  const auto hinge = [&](const char* name, int a, int b, const Eigen::Vector2d& at, std::array<int, 2> on) {
    ProposedJoint joint{.name = name,
                        .type = "revolute",
                        .a = a,
                        .b = b,
                        .confidence = "high",
                        .doubt = "",
                        .evidence = {"two ends"},
                        .faces = {{a, on[0]}, {b, on[1]}},
                        .on = on};
    joint.p_WJ << at, 0;
    page.joints.push_back(joint);
  };
  hinge("frame_crank", 0, 1, A, {1, 1});
  hinge("crank_coupler", 1, 2, B, {2, 1});
  hinge("coupler_rocker", 2, 3, C, {2, 2});
  hinge("frame_rocker", 0, 3, D, {2, 1});
  page.joints[3].confidence = "medium";
  page.joints[3].doubt = "held from one side only";
  page.doubts = {"crank and rocker come within 0.2 mm of each other"};
  page.ground = 0;
  page.head = "name = \"linkage\"\n";
  return page;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: view_write_pages DIRECTORY\n");
    return 2;
  }
  const std::filesystem::path directory = argv[1];
  std::filesystem::create_directories(directory);
  auto se = synthetic::tube(48, 60, 12);
  synthetic::add_stress(se);
  write_modes_page(directory / "modes.html", se, synthetic::tube_modes(se));
  Pictures pictures;
  const auto engine = synthetic::engine(pictures);
  MotionPage motion;
  motion.plots = {"slider.position", "crank.speed", "rod.deflection", "energy.kinetic, energy.strain"};
  write_motion_page(directory / "motion.html", engine, pictures, motion);
  write_parts_page(directory / "parts.html", linkage());
  PartsPage alone{.title = "bar.step", .created_by = "flexura tests"};
  alone.parts = {bar("bar", 1.0)};
  alone.bodies = {{.name = "bar", .text = "one solid"}};
  write_parts_page(directory / "faces.html", alone);
  write_report_page(directory / "report.html", sample_report());
  flexura::superelement::write(directory / "beam.se.h5", flexura::superelement::testing::make_box_beam());
}
