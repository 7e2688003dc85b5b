// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The reduction program under MPI's launcher.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <Eigen/SVD>
#include <array>
#include <cmath>
#include <cstdio>

#include "mbs/superelement/file.hpp"
#include "mesh/partition/cell_parts.hpp"
#include "tests/app/command.hpp"
#include "tests/reduce/parts.hpp"
#include "tests/sanitized.hpp"

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

// K_bb, M_bb, frequencies and the space of the modes.
void expect_same(const superelement::Superelement& a, const superelement::Superelement& b) {
  ASSERT_EQ(b.n_b, a.n_b);
  ASSERT_EQ(b.n_q, a.n_q);
  // Elements are added up in another order and the factors are others: round-off times the condition number
  // of K_ii, 1e5 for 480 cells.
  const auto boundary = [&](const Eigen::MatrixXd& X) { return X.topLeftCorner(a.n_b, a.n_b); };
  EXPECT_LT((boundary(b.K_se) - boundary(a.K_se)).norm(), 1e-10 * boundary(a.K_se).norm());
  EXPECT_LT((boundary(b.M_se) - boundary(a.M_se)).norm(), 1e-10 * boundary(a.M_se).norm());
  EXPECT_LT((b.omega2.cwiseQuotient(a.omega2).cwiseSqrt().array() - 1.0).abs().maxCoeff(), 1e-8);
  ASSERT_EQ(b.shapes.rows(), a.shapes.rows());
  // Constraint modes are the same, whatever the modes are; 24 bits are kept.
  EXPECT_LT((b.shapes.leftCols(a.n_b) - a.shapes.leftCols(a.n_b)).norm(),
            1e-6 * a.shapes.leftCols(a.n_b).norm());
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

constexpr superelement::Parts kAll{.stiffening = true, .shapes = true, .stress = true, .mesh_error = true};

void expect_near(const Eigen::MatrixXd& x, const Eigen::MatrixXd& y, const char* name) {
  ASSERT_EQ(x.rows(), y.rows()) << name;
  EXPECT_LT((x - y).norm(), 1e-9 * x.norm()) << name;
}

// What belongs to the interfaces' own shapes, whatever signs the modes have, of parts with dampers, load cases, stiffening and
// stresses; and the mesh's share.
void expect_same_fields(const superelement::Superelement& a, const superelement::Superelement& b) {
  const auto corner = [&](const Eigen::MatrixXd& X) { return X.topLeftCorner(a.n_b, a.n_b); };
  expect_near(a.inertia.S_xx, b.inertia.S_xx, "S_xx");
  expect_near(a.inertia.S_xphi.leftCols(a.n_b), b.inertia.S_xphi.leftCols(a.n_b), "S_xphi");
  ASSERT_TRUE(a.D_se.size() > 0 && b.D_se.size() > 0);
  expect_near(corner(a.D_se), corner(b.D_se), "D_se");
  ASSERT_EQ(b.load_cases.size(), a.load_cases.size());
  for (std::size_t k = 0; k < a.load_cases.size(); ++k) {
    expect_near(a.load_cases[k].p_se.head(a.n_b), b.load_cases[k].p_se.head(a.n_b), "p_se");
    expect_near(a.load_cases[k].moment.leftCols(a.n_b), b.load_cases[k].moment.leftCols(a.n_b), "moment");
  }
  ASSERT_TRUE(a.stiffening && b.stiffening);
  for (int k = 0; k < 6; ++k)
    expect_near(corner(a.stiffening->K0omega[k]), corner(b.stiffening->K0omega[k]), "K0omega");
  expect_near(corner(a.stiffening->K0t[0]), corner(b.stiffening->K0t[0]), "K0t");
  expect_near(corner(a.stiffening->K0F.front()), corner(b.stiffening->K0F.front()), "K0F");
  ASSERT_EQ(b.stiffening->K0p.size(), a.stiffening->K0p.size());
  for (std::size_t k = 0; k < a.stiffening->K0p.size(); ++k)
    expect_near(corner(a.stiffening->K0p[k]), corner(b.stiffening->K0p[k]), "terms of the loads");
  ASSERT_TRUE(a.stress && b.stress);
  expect_near(a.stress->S.leftCols(a.n_b), b.stress->S.leftCols(a.n_b), "stress");
  // Estimates follow from the motions, which agree to 1e-8 or so; -1: unknown.
  ASSERT_TRUE(a.mesh_error && b.mesh_error);
  ASSERT_EQ(b.mesh_error->modes.size(), a.mesh_error->modes.size());
  for (std::size_t k = 0; k < a.mesh_error->modes.size(); ++k)
    EXPECT_NEAR(b.mesh_error->modes[k].error, a.mesh_error->modes[k].error,
                1e-6 * std::abs(a.mesh_error->modes[k].error))
        << k;
  ASSERT_EQ(b.mesh_error->interfaces.size(), a.mesh_error->interfaces.size());
  for (std::size_t k = 0; k < a.mesh_error->interfaces.size(); ++k)
    EXPECT_NEAR(b.mesh_error->interfaces[k].compliance_error, a.mesh_error->interfaces[k].compliance_error,
                1e-6 * std::abs(a.mesh_error->interfaces[k].compliance_error))
        << a.mesh_error->interfaces[k].name;
}

// The superelements that one process makes and `size` of them.
std::array<superelement::Superelement, 2> by_one_and_by(const test::Folder& folder, int size,
                                                        std::vector<std::string> arguments) {
  arguments.push_back("-o");
  arguments.push_back(folder / "alone.se.h5");
  const test::Outcome one = test::run("flexura-reduce", arguments);
  EXPECT_EQ(one.exit_code, 0) << one.err;
  arguments.back() = folder / "together.se.h5";
  const test::Outcome all = under_mpirun(folder, size, arguments);
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.out, ::testing::HasSubstr(std::to_string(size) + " processes share the elements"));
  return {superelement::read(folder / "alone.se.h5", kAll),
          superelement::read(folder / "together.se.h5", kAll)};
}

// A block of ten-node tetrahedra, 4 m long, with all that a part can have beside its cells: its left end follows a rigid
// interface node of which four directions are retained, the right one has the given tie; a mass beside the rigid one and one at
// a node, a spring and damper, gravity, stiffening and stresses.
std::string block_part(const test::Folder& folder, const std::string& modes, const std::string& right_tie,
                       int lamp, const std::string& more) {
  return folder
      .write("block.toml",
             "stiffening = true\n[geometry]\nfile = \"" + std::string(FLEXURA_SOURCE_DIR) +
                 "/tests/mesh/data/blockC3D10.inp\"\n[modes]\n" + modes +
                 "[recovery]\nstress = true\nprecision = \"double\"\n"
                 "[interface.left]\nby = \"plane\"\npoint = [0, 0, 0]\nnormal = [1, 0, 0]\n"
                 "directions = [\"x\", \"y\", \"z\", \"rx\"]\n"
                 "[interface.right]\nby = \"plane\"\npoint = [4, 0, 0]\nnormal = [1, 0, 0]\n"
                 "tie = \"" +
                 right_tie +
                 "\"\n"
                 "[mass_point.motor]\nmass = 2000\ninterface = \"left\"\noffset = [-0.3, 0.1, 0]\n"
                 "[mass_point.lamp]\nmass = 500\nnode = " +
                 std::to_string(lamp) +
                 "\n"
                 "[link.strut]\nnodes = [13, 17]\nstiffness = \"1e9 N/m\"\ndamping = \"100 N s/m\"\n"
                 "[load.weight]\ntype = \"gravity\"\nacceleration = [0, 0, -9.81]\n" +
                 more)
      .string();
}

class ByProcesses : public ::testing::TestWithParam<int> {};

// The cantilever of hexahedra is square: its bending modes come in pairs, whose directions nothing tells
// apart.
TEST_P(ByProcesses, TheWorkIsSharedAndTheSuperelementIsThatOfOne) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", ""), alone = folder / "alone.se.h5",
                    together = folder / "together.se.h5";
  const test::Outcome one = test::run("flexura-reduce", {part, "-o", alone, "-q"});
  ASSERT_EQ(one.exit_code, 0) << one.err;
  const test::Outcome all = under_mpirun(folder, GetParam(), {part, "-o", together});
  ASSERT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.out, ::testing::HasSubstr(std::to_string(GetParam()) + " processes share the elements"));
  expect_same(superelement::read(alone, {.shapes = true}), superelement::read(together, {.shapes = true}));
}

// One end is held in the mean; response modes and a preload, too.
TEST_P(ByProcesses, MassesLinksLoadsStiffeningAndStressesAreThoseOfOne) {
  const test::Folder folder;
  const std::string part = block_part(folder, "count = 8\nresponse_at = [0]\n", "average", 17,
                                      "keep_shape = true\n[load.heat]\ntype = \"preload\"\n"
                                      "strain = \"1e-4 * (1 + x - 2 * z)\"\n");
  const auto [a, b] = by_one_and_by(folder, GetParam(), {part});
  expect_same(a, b);
  expect_same_fields(a, b);
  ASSERT_TRUE(a.load_cases.size() == 2 && b.load_cases.size() == 2);
  EXPECT_TRUE(a.load_cases[1].is_preload && b.load_cases[1].is_preload);
  ASSERT_GT(a.stress->of_loads.norm(), 0.0);
  expect_near(a.stress->of_loads, b.stress->of_loads, "stress of the preload");
}

// Free-free modes and attachment modes of the same block, with one interface of each tie: the free body is a second model,
// which the processes share as they share the first.
TEST_P(ByProcesses, FreeModesAndAttachmentModesAreThoseOfOne) {
  const test::Folder folder;
  const std::string part = block_part(folder, "set = \"craig_chang\"\ncount = 8\n", "average", 17,
                                      "[interface.eye]\nby = \"nodes\"\nnodes = [13]\ntie = \"node\"\n"
                                      "directions = [\"y\", \"z\"]\n");
  const auto [a, b] = by_one_and_by(folder, GetParam(), {part});
  expect_same(a, b);
  expect_same_fields(a, b);
}

// Elastic ties are two models, one with the averages and one with rigid faces.  A face of 25 nodes, whose motions are treated
// as a whole; a mass and a load on it.
TEST_P(ByProcesses, InterfaceModesOfElasticTiesAreThoseOfOne) {
  const test::Folder folder;
  const std::string part = block_part(folder, "count = 8\ncertify = true\ninterface_count = 12\n", "elastic",
                                      12, "keep_shape = true\n");
  const auto [a, b] = by_one_and_by(folder, GetParam(), {part});
  EXPECT_EQ(a.n_q, 8 + 1 + 12);
  ASSERT_TRUE(a.mesh_error);
  EXPECT_EQ(a.mesh_error->interfaces.size(), 1u)
      << "four directions of the left end do not hold the right one";
  expect_same(a, b);
  expect_same_fields(a, b);
}

// A bore of 202 nodes, where Lanczos works; the other ties rigid and, with all that hold it, averages.  Interface modes up to a
// frequency, and for an accuracy of the static stiffness.
TEST_P(ByProcesses, InterfaceModesUpToAFrequencyOrAnAccuracyAreThoseOfOne) {
  const test::Folder folder;
  const std::vector<std::string> bracket = {std::string(FLEXURA_SOURCE_DIR) + "/cases/cad_parts/bracket.toml",
                                            "--mesh-size",
                                            "12 mm",
                                            "-n",
                                            "8",
                                            "--set",
                                            "interface.bearing.tie=elastic"};
  for (const std::vector<std::string>& more : std::vector<std::vector<std::string>>{
           {"--set", "modes.interface_up_to=60 kHz"},
           {"--set", "modes.interface_accuracy=0.02", "--set", "interface.screw_left.tie=average", "--set",
            "interface.screw_right.tie=average"}}) {
    std::vector<std::string> arguments = bracket;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto [a, b] = by_one_and_by(folder, GetParam(), arguments);
    EXPECT_GT(a.n_q, 8 + 4) << more[1];
    expect_same(a, b);
  }
}

INSTANTIATE_TEST_SUITE_P(Launch, ByProcesses, ::testing::Values(2, 4),
                         [](const auto& info) { return std::to_string(info.param); });

// Modes by their effective mass: the rigid motions' masses are sums over the processes, too.
TEST(Launch, ModesChosenByEffectiveMassAreThoseOfOne) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", "effective_mass = 0.8\n"),
                    alone = folder / "alone.se.h5", together = folder / "together.se.h5";
  ASSERT_EQ(test::run("flexura-reduce", {part, "-o", alone, "-q"}).exit_code, 0);
  const test::Outcome all = under_mpirun(folder, 2, {part, "-o", together, "-q"});
  ASSERT_EQ(all.exit_code, 0) << all.err;
  expect_same(superelement::read(alone, {.shapes = true}), superelement::read(together, {.shapes = true}));
}

// One brick between two rigid interfaces: no process has anything to factorise, which MUMPS refused.
TEST(Launch, APartWithoutInteriorDofsIsThatOfOne) {
  const test::Folder folder;
  folder.write(
      "brick.inp",
      "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n5, 0, 0, 1\n6, 1, 0, 1\n7, 1, 1, 1\n8, 0, 1, "
      "1\n"
      "*ELEMENT, TYPE=C3D8, ELSET=E\n1, 1, 2, 3, 4, 5, 6, 7, 8\n*SOLID SECTION, ELSET=E, MATERIAL=S\n"
      "*MATERIAL, NAME=S\n*ELASTIC\n2.1e11, 0.3\n*DENSITY\n7850.\n");
  const std::string part = folder
                               .write("brick.toml",
                                      "[geometry]\nfile = \"brick.inp\"\nunit = \"m\"\n[modes]\ncount = 5\n"
                                      "[interface.left]\nby = \"nodes\"\nnodes = [1, 4, 5, 8]\n"
                                      "[interface.right]\nby = \"nodes\"\nnodes = [2, 3, 6, 7]\n")
                               .string();
  const std::string alone = folder / "alone.se.h5", together = folder / "together.se.h5";
  ASSERT_EQ(test::run("flexura-reduce", {part, "-o", alone, "-q"}).exit_code, 0);
  const test::Outcome all = under_mpirun(folder, 2, {part, "-o", together, "-q"});
  ASSERT_EQ(all.exit_code, 0) << all.err;
  const superelement::Superelement a = superelement::read(alone), b = superelement::read(together);
  EXPECT_EQ(b.n_q, 0);
  EXPECT_LT((a.K_se - b.K_se).norm(), 1e-12 * a.K_se.norm());  // sums of eight terms
  EXPECT_LT((a.M_se - b.M_se).norm(), 1e-12 * a.M_se.norm());
  const std::vector<std::string> free = {part, "-o", together, "-q", "--set", "modes.set=craig_chang"};
  for (const test::Outcome& outcome : {test::run("flexura-reduce", free), under_mpirun(folder, 2, free)}) {
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_THAT(outcome.err, ::testing::HasSubstr("all dofs of the part are its interfaces'"));
  }
}

// Peak memory of each process in GB, as the summary prints it; the first, then the greatest of the others.
std::array<double, 2> peaks(const test::Outcome& outcome) {
  std::array<double, 2> peak{};
  const std::size_t at = outcome.out.find("peak memory ");
  if (at != std::string::npos)
    std::sscanf(outcome.out.c_str() + at, "peak memory %lf GB (the other processes up to %lf GB)", &peak[0],
                &peak[1]);
  return peak;
}

// 400 modes of 14,451 dofs: vectors are most of the memory.  Measured on 26 November 2026: one process 0.37 GB, the first of
// two 0.23 and the other 0.22 (each program by itself has 0.05); with larger bases 0.50, 0.31 and 0.29, and 0.40 and 0.36 while the
// first held matrices, modes and the shapes of all nodes and each vectors of full length.
TEST(Launch, TheFirstOfTwoProcessesNeedsLittleMoreMemoryThanTheOther) {
  const test::Folder folder;
  const std::vector<std::string> arguments = {
      std::string(FLEXURA_SOURCE_DIR) + "/cases/cad_parts/bracket.toml",
      "--mesh-size",
      "12 mm",
      "-n",
      "400",
      "--set",
      "modes.certify=false",
      "-o",
      folder / "bracket.se.h5"};
  const test::Outcome one = test::run("flexura-reduce", arguments), two = under_mpirun(folder, 2, arguments);
  ASSERT_EQ(one.exit_code, 0) << one.err;
  ASSERT_EQ(two.exit_code, 0) << two.err;
  const auto [alone, none] = peaks(one);
  const auto [first, other] = peaks(two);
  ASSERT_GT(other, 0.0) << two.out;
  EXPECT_LT(first, 1.15 * other);
#ifndef FLEXURA_ADDRESS_SANITIZER  // which keeps what is freed
  EXPECT_LT(first, 0.72 * alone);
#endif
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

// What all of them find within their work.
TEST(Launch, AnAccuracyThatNoInterfaceModesReachIsRefusedByAll) {
  const test::Folder folder;
  const std::string deck = std::string(FLEXURA_SOURCE_DIR) + "/tests/mesh/data/blockC3D10.inp";
  std::string text = "[geometry]\nfile = \"" + deck + "\"\n[modes]\ncount = 2\ninterface_accuracy = 1e-15\n";
  for (const char* const end : {"0", "4"})
    text += std::string("[interface.at_") + end + "]\nby = \"plane\"\npoint = [" + end +
            ", 0, 0]\nnormal = [1, 0, 0]\ntie = \"elastic\"\n";
  const test::Outcome bad =
      under_mpirun(folder, 2, {folder.write("block.toml", text).string(), "-o", folder / "a.se.h5"});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.err, ::testing::HasSubstr("the interfaces' static stiffness is within"));
  EXPECT_THAT(bad.err, ::testing::HasSubstr("tie them as an average, which is exact"));
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
