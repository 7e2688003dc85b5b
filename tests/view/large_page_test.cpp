// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// The modes page of a large part, from its file by the program: size, time and memory, as a table.  A solid
// of a million nodes in a mesh of 100 x 100 x 100 has 60,000 on its surface; thin-walled castings have more:
// 200,000 vertices and 400,000 triangles are taken here, and a million for the bounds of a part that is
// nothing but surface.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "mbs/superelement/file.hpp"
#include "mbs/view/pages.hpp"
#include "tests/mbs/app/run_program.hpp"
#include "tests/mbs/superelement/box_beam.hpp"
#include "tests/view/page_reader.hpp"
#include "tests/view/synthetic.hpp"

namespace flexura::view {
namespace {

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

/// The tube with matrices that a file may hold: the box beam's, and one uncoupled mode for each shape beyond
/// its own.
superelement::Superelement large_part(int around, int along, int n_modes) {
  auto se = synthetic::tube(around, along, n_modes);
  make_irregular(se, around, along);
  const auto beam = superelement::testing::make_box_beam();
  const int n = se.n(), n_beam = beam.n();
  const auto grown = [&](const Eigen::MatrixXd& A, bool unit) {
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(n, n);
    B.topLeftCorner(n_beam, n_beam) = A;
    if (unit) B.diagonal().tail(n - n_beam).setOnes();
    return B;
  };
  const auto widened = [&](const Eigen::MatrixXd& A) {
    Eigen::MatrixXd B = Eigen::MatrixXd::Zero(A.rows(), n);
    B.leftCols(n_beam) = A;
    return B;
  };
  se.K_se = grown(beam.K_se, false);
  for (int k = n_beam; k < n; ++k) se.K_se(k, k) = beam.omega2.maxCoeff() * (k - n_beam + 2);
  se.M_se = grown(beam.M_se, true);
  se.omega2 = se.K_se.diagonal().tail(se.n_q);
  se.inertia = beam.inertia;
  se.inertia.S_phi = widened(beam.inertia.S_phi);
  se.inertia.S_xphi = widened(beam.inertia.S_xphi);
  for (int p = 0; p < 6; ++p) se.inertia.S_phiphi[p] = grown(beam.inertia.S_phiphi[p], p == 1);
  se.interfaces = beam.interfaces;
  return se;
}

struct Measured {
  double megabytes = 0.0, seconds = 0.0,
         peak = 0.0;  ///< of the page [MB], wall time, memory of the program [MB]
};

/// `flexura modes FILE --html PAGE` with the default choice of modes: 26 of the free body and 20 held.
Measured page_of(const superelement::Superelement& se, const std::string& name) {
  const auto file = testing::scratch(name + ".se.h5"), html = testing::scratch(name + ".html");
  superelement::write(file, se);
  const auto start = std::chrono::steady_clock::now();
  const flexura::testing::Outcome outcome = flexura::testing::run_program(
      std::string(FLEXURA_BIN_DIR) + "/flexura modes -q " + file.string() + " --html " + html.string());
  Measured m;
  m.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  rusage usage{};  // the largest of all children: parts are taken in growing order
  getrusage(RUSAGE_CHILDREN, &usage);
  m.peak = static_cast<double>(usage.ru_maxrss) / 1e3;
  m.megabytes = static_cast<double>(std::filesystem::file_size(html)) / 1e6;
  fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.0f} |\n", se.surface.vertices.rows(),
             se.surface.triangles.rows(), 46, m.megabytes, m.seconds, m.peak);
  std::filesystem::remove(file);
  return m;
}

TEST(LargePages, OfSolidsOfAMillionNodesStayUnderFortyMegabytesTakeSecondsAndBoundedMemory) {
  constexpr int n_modes = 30;
  fmt::print(
      "| vertices | triangles | modes | page [MB] | time [s] | memory [MB] |\n|---|---|---|---|---|---|\n");
  for (const auto& [around, along] : {std::pair{250, 120}, std::pair{500, 200}, std::pair{1000, 500}}) {
    const auto se = large_part(around, along, n_modes);
    const Measured m = page_of(se, "large_page");
    // A compact solid of a million nodes shows 60,000 of them on its surface, a plate of two layers of cells
    // a few 100,000, a shell-like part all of them.
    EXPECT_LT(m.megabytes, 40.0);
    // Seconds on an idle machine; ten times that on one that is busy with other things.
    EXPECT_LT(m.seconds, 1e-3 * static_cast<double>(se.surface.vertices.rows()));
    // The shapes as the file holds them, n_v x 3 x n in 32 bits; for each vertex its place, triangles,
    // traversal and one packed shape, 500 bytes; the program itself 60 MB.
    const double vertices = static_cast<double>(se.surface.vertices.rows());
    EXPECT_LT(m.peak, 1e-6 * vertices * (3.0 * 4.0 * se.n() + 500.0) + 60.0);
  }
}

}  // namespace
}  // namespace flexura::view
