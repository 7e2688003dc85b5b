// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The reduction program under MPI's launcher.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>

#include "mbs/superelement/file.hpp"
#include "mesh/partition/cell_parts.hpp"
#include "tests/app/command.hpp"
#include "tests/reduce/parts.hpp"

namespace flexura::reduce {
namespace {

// mpirun starts `size` processes, without this program's own environment, in which MPI has started already.
test::Outcome under_mpirun(const test::Folder& folder, int size, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"-i",
                                    "PATH=/usr/bin:/bin",
                                    "HOME=" + folder.path().string(),
                                    "OPENBLAS_NUM_THREADS=1",
                                    "ASAN_OPTIONS=detect_leaks=0",
                                    "/usr/bin/mpirun",
                                    "--allow-run-as-root",
                                    "--oversubscribe",
                                    "-n",
                                    std::to_string(size),
                                    std::string(FLEXURA_BIN_DIR) + "/flexura-reduce"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return test::run("/usr/bin/env", words);
}

std::string deck_part(const test::Folder& folder, const std::string& name, const std::string& more) {
  const std::string deck = std::string(FLEXURA_SOURCE_DIR) + "/tests/mesh/data/CHEXA08_.nas";
  return folder
      .write(name, "[geometry]\nfile = \"" + deck + "\"\n[modes]\ncount = 6\ncertify = true\n" + more)
      .string();
}

// The smallest cosine of an angle between the spans of two sets of shapes.
double least_cosine(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
  const auto basis = [](const Eigen::MatrixXd& X) {
    return Eigen::MatrixXd(Eigen::HouseholderQR<Eigen::MatrixXd>(X).householderQ() *
                           Eigen::MatrixXd::Identity(X.rows(), X.cols()));
  };
  return Eigen::JacobiSVD<Eigen::MatrixXd>(basis(A).transpose() * basis(B)).singularValues().minCoeff();
}

// The cantilever of hexahedra is square: its bending modes come in pairs, whose directions nothing tells
// apart.
TEST(Launch, ProcessesThatShareTheWorkGiveTheSuperelementOfOne) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", ""), alone = folder / "alone.se.h5";
  const test::Outcome one = test::run("flexura-reduce", {part, "-o", alone, "-q"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const superelement::Superelement a = superelement::read(alone, {.shapes = true});
  for (const int size : {2, 3}) {
    const std::string together = folder / ("together" + std::to_string(size) + ".se.h5");
    const test::Outcome all = under_mpirun(folder, size, {part, "-o", together});
    ASSERT_EQ(all.exit_code, 0) << all.err;
    EXPECT_THAT(all.out, ::testing::HasSubstr(std::to_string(size) + " processes share the elements"));
    const superelement::Superelement b = superelement::read(together, {.shapes = true});
    ASSERT_EQ(b.n_b, a.n_b);
    ASSERT_EQ(b.n_q, a.n_q);
    // Elements are added up in another order and the factors are others: round-off times the condition number
    // of K_ii, 1e5 for 480 cells.
    const auto boundary = [&](const Eigen::MatrixXd& X) { return X.topLeftCorner(a.n_b, a.n_b); };
    EXPECT_LT((boundary(b.K_se) - boundary(a.K_se)).norm(), 1e-10 * boundary(a.K_se).norm());
    EXPECT_LT((boundary(b.M_se) - boundary(a.M_se)).norm(), 1e-10 * boundary(a.M_se).norm());
    EXPECT_LT((b.omega2.cwiseQuotient(a.omega2).cwiseSqrt().array() - 1.0).abs().maxCoeff(), 1e-8);
    for (int first = 0, next; first < a.n_q; first = next) {
      for (next = first + 1; next < a.n_q && a.omega2(next) - a.omega2(next - 1) < 1e-4 * a.omega2(next);)
        ++next;
      const auto modes = [&](const superelement::Superelement& se) {
        return Eigen::MatrixXd(se.shapes.middleCols(a.n_b + first, next - first).cast<double>());
      };
      // Shapes are kept with 24 bits; an angle of 1e-6 makes 5e-13.
      EXPECT_GT(least_cosine(modes(a), modes(b)), 1.0 - 1e-10) << "modes " << first << " to " << next - 1;
    }
  }
}

// A bar of 12 x 2 x 2 cells in two: half of the cells each, METIS allows 3 per cent, and they touch in about
// one cross-section of 9 nodes.
TEST(CellParts, HalveABarAcrossItsLength) {
  const mesh::Mesh bar = testing::box({12.0, 2.0, 2.0}, {12, 2, 2}, mesh::CellType::hex8);
  const std::vector<int> part_of = mesh::cell_parts(bar, 2);
  ASSERT_EQ(part_of.size(), 48u);
  EXPECT_NEAR(static_cast<double>(std::count(part_of.begin(), part_of.end(), 0)), 24.0, 1.0);
  std::vector<int> seen(bar.n_nodes(), 0);
  for (std::size_t cell = 0; cell < part_of.size(); ++cell)
    for (const mesh::Index node : bar.solids[0].nodes.row(static_cast<Eigen::Index>(cell)))
      seen[node] |= 1 << part_of[cell];
  EXPECT_LE(std::count(seen.begin(), seen.end(), 3), 2 * 9);
  EXPECT_EQ(mesh::cell_parts(bar, 2), part_of);
}

TEST(Launch, ARefusalEndsAllProcesses) {
  const test::Folder folder;
  const test::Outcome bad = under_mpirun(folder, 2, {"missing.toml"});
  EXPECT_NE(bad.exit_code, 0);
  EXPECT_THAT(bad.err, ::testing::HasSubstr("missing.toml"));
}

// The numbers are written and read back through a file: the superelement is the same.
TEST(Launch, AFactorInAFileMakesTheSameSuperelement) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", ""), usual = folder / "usual.se.h5",
                    filed = folder / "filed.se.h5";
  ASSERT_EQ(test::run("flexura-reduce", {part, "-o", usual, "-q"}).exit_code, 0);
  const test::Outcome out = test::run("flexura-reduce", {part, "-o", filed, "--factor-in-file"});
  ASSERT_EQ(out.exit_code, 0) << out.err;
  EXPECT_THAT(out.out, ::testing::HasSubstr("was kept in a temporary file"));
  const superelement::Superelement a = superelement::read(usual), b = superelement::read(filed);
  EXPECT_EQ(a.K_se, b.K_se);
  EXPECT_EQ(a.M_se, b.M_se);
}

}  // namespace
}  // namespace flexura::reduce
