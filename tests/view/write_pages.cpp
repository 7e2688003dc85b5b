// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Writes what the browser's and the Python tests open:  view_write_pages DIRECTORY
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "mbs/superelement/file.hpp"
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
  write_report_page(directory / "report.html", sample_report());
  flexura::superelement::write(directory / "beam.se.h5", flexura::superelement::testing::make_box_beam());
}
