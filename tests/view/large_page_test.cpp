// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The pages of large parts: size, time and memory, as a table.  A solid of a million nodes in a mesh of 100 x
// 100 x 100 has 60,000 on its surface; thin-walled castings have more: 200,000 vertices and 400,000 triangles
// are taken here.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "mbs/superelement/file.hpp"
#include "mbs/view/pages.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1e3;
}

/// Vertices are moved along the surface by up to a third of the mesh size, as a mesher would place them, so
/// that the prediction of a shape by parallelograms does not come out too well; shapes follow.
void make_irregular(superelement::Superelement& se, int around, int along) {
  std::uint32_t state = 7;
  const auto random = [&] {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state) / 4294967296.0 - 0.5;
  };
  for (Eigen::Index v = 0; v < se.surface.vertices.rows(); ++v) {
    const Eigen::Vector3d p = se.surface.vertices.row(v);
    const double radius = std::hypot(p.y(), p.z());
    const double angle = std::atan2(p.z(), p.y()) + 0.66 * random() * 6.283185307179586 / around;
    const bool at_end = p.x() == 0.0 || p.x() == synthetic::tube_length;
    const double x = p.x() + (at_end ? 0.0 : 0.66 * random() * synthetic::tube_length / along);
    se.surface.vertices.row(v) << x, radius * std::cos(angle), radius * std::sin(angle);
    for (int k = 0; k < se.n_q; ++k) {
      se.shapes.block<3, 1>(3 * v, 12 + k) =
          synthetic::tube_displacement(k, se.surface.vertices.row(v)).cast<float>();
    }
  }
}

TEST(LargePages, TwoHundredThousandVerticesWithThirtyModesStayUnderFortyMegabytesAndTakeSeconds) {
  constexpr int around = 500, along = 200, n_modes = 30;
  auto se = synthetic::tube(around, along, n_modes);
  make_irregular(se, around, along);
  const double before = peak_megabytes();
  const auto html = testing::scratch("large_page.html");
  const auto start = std::chrono::steady_clock::now();
  write_modes_page(html, se, synthetic::tube_modes(se));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double megabytes = static_cast<double>(std::filesystem::file_size(html)) / 1e6;
  const double more = peak_megabytes() - before;
  fmt::print(
      "| vertices | triangles | modes | page [MB] | time [s] | memory beside the superelement [MB] |\n"
      "|---|---|---|---|---|---|\n| {} | {} | {} | {:.1f} | {:.1f} | {:.0f} |\n",
      se.surface.vertices.rows(), se.surface.triangles.rows(), n_modes, megabytes, seconds, more);
  EXPECT_LT(megabytes, 40.0);
  // Seconds on an idle machine; ten times that on one that is busy with other things.
  EXPECT_LT(seconds, 100.0);
  // Bounded: no more than the shapes take themselves (one of 42 at a time, and the traversal's lists).
  EXPECT_LT(more, 4e-6 * static_cast<double>(se.shapes.size()) + 50.0);
}

}  // namespace
}  // namespace flexura::view
