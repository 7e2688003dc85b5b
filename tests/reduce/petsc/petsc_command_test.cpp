// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// `flexura reduce --petsc`: PETSc's and SLEPc's other solvers give the same superelement.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <fstream>
#include <iterator>

#include "mbs/superelement/file.hpp"
#include "tests/app/command.hpp"

namespace flexura::reduce {
namespace {

using Eigen::MatrixXd;
using ::testing::HasSubstr;

std::string deck_part(const test::Folder& folder, const std::string& name, const std::string& more) {
  const std::string deck = std::string(FLEXURA_SOURCE_DIR) + "/tests/mesh/data/CHEXA08_.nas";
  return folder
      .write(name, "[geometry]\nfile = \"" + deck + "\"\n[modes]\ncount = 6\ncertify = true\n" + more)
      .string();
}

// A block of ten-node tetrahedra whose ends are held in the mean: its stiffness matrix is bordered.
std::string averaged_part(const test::Folder& folder, const std::string& name) {
  const std::string deck = std::string(FLEXURA_SOURCE_DIR) + "/tests/mesh/data/blockC3D10.inp";
  std::string text = "[geometry]\nfile = \"" + deck + "\"\n[modes]\ncount = 8\ncertify = true\n";
  for (const char* const end : {"0", "4"})
    text += std::string("[interface.at_") + end + "]\nby = \"plane\"\npoint = [" + end +
            ", 0, 0]\nnormal = [1, 0, 0]\ntie = \"average\"\n";
  return folder.write(name, text).string();
}

// mpirun starts two processes, without this program's own environment.
test::Outcome under_mpirun(const test::Folder& folder, const std::vector<std::string>& arguments) {
  std::vector<std::string> words = {"-i",
                                    "PATH=/usr/bin:/bin",
                                    "HOME=" + folder.path().string(),
                                    "ASAN_OPTIONS=detect_leaks=0",
                                    "/usr/bin/mpirun",
                                    "--allow-run-as-root",
                                    "--oversubscribe",
                                    "-n",
                                    "2",
                                    std::string(FLEXURA_BIN_DIR) + "/flexura-reduce"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return test::run("/usr/bin/env", words);
}

// The interface's dynamic stiffness at a frequency between modes: whatever signs the modes have and however those of
// equal frequency are turned, it is the same.
MatrixXd dynamic_stiffness(const superelement::Superelement& se, double omega2) {
  const MatrixXd D = se.K_se - omega2 * se.M_se;
  const auto n_b = se.n_b, n_q = se.n_q;
  return D.topLeftCorner(n_b, n_b) -
         D.topRightCorner(n_b, n_q) *
             D.bottomRightCorner(n_q, n_q).fullPivLu().solve(D.bottomLeftCorner(n_q, n_b));
}

void expect_same(const superelement::Superelement& a, const superelement::Superelement& b) {
  ASSERT_EQ(b.n_b, a.n_b);
  ASSERT_EQ(b.n_q, a.n_q);
  EXPECT_LT((b.omega2 - a.omega2).cwiseQuotient(a.omega2).cwiseAbs().maxCoeff(),
            2e-8);  // frequencies to 1e-8
  const auto difference = [](const MatrixXd& X, const MatrixXd& Y) { return (X - Y).norm() / X.norm(); };
  // Constraint modes are refined with K itself: round-off times its condition number, 1e5 here.
  EXPECT_LT(difference(a.K_se.topLeftCorner(a.n_b, a.n_b), b.K_se.topLeftCorner(a.n_b, a.n_b)), 1e-10);
  EXPECT_LT(difference(a.M_se.topLeftCorner(a.n_b, a.n_b), b.M_se.topLeftCorner(a.n_b, a.n_b)), 1e-10);
  for (const double factor : {0.3, 0.8, 3.0})
    EXPECT_LT(
        difference(dynamic_stiffness(a, factor * a.omega2(0)), dynamic_stiffness(b, factor * a.omega2(0))),
        1e-8)
        << factor;
}

struct Case {
  std::string name, options, more;
};

class OtherSolvers : public ::testing::TestWithParam<Case> {};

TEST_P(OtherSolvers, GiveTheSameSuperelement) {
  const test::Folder folder;
  for (const std::string& part : {deck_part(folder, "beam.toml", ""), averaged_part(folder, "block.toml")}) {
    const std::string ours = part + ".ours.se.h5", theirs = part + ".theirs.se.h5";
    const test::Outcome one = test::run("flexura-reduce", {part, "-o", ours, "-q"});
    ASSERT_EQ(one.exit_code, 0) << one.err;
    const test::Outcome other =
        test::run("flexura-reduce", {part, "-o", theirs, "-q", "--petsc", GetParam().options});
    ASSERT_EQ(other.exit_code, 0) << other.err;
    EXPECT_THAT(other.err, ::testing::Not(HasSubstr("PETSc")));  // all options were used
    expect_same(superelement::read(ours), superelement::read(theirs));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, OtherSolvers,
    ::testing::Values(
        Case{"KrylovSchurMumps", "-eps_type krylovschur -pc_factor_mat_solver_type mumps", ""},
        Case{"Cholmod", "-pc_factor_mat_solver_type cholmod", ""}, Case{"Lobpcg", "-eps_type lobpcg", ""},
        Case{"JacobiDavidson", "-eps_type jd", ""}, Case{"Lapack", "-eps_type lapack", ""},
        Case{"SliceOfAll", "-eps_blocklanczos_slice 1000000000", ""},
        Case{"LobpcgCholmod", "-eps_type lobpcg -pc_factor_mat_solver_type cholmod", ""},
        Case{"SinglePrecision", "-mat_fronts_precision single", ""},
        Case{"Slices", "-eps_blocklanczos_slice 2", ""},
        // Block low-rank factors, less accurate by far: refinement makes up for it.
        Case{"LowRank", "-pc_factor_mat_solver_type mumps -mat_mumps_icntl_35 2 -mat_mumps_cntl_7 1e-8", ""}),
    [](const auto& info) { return info.param.name; });

// 40 modes in slices of ten: the numbers, and the certificate that the slices are themselves.
TEST(Petsc, SlicesAreTheSameToTheBitTheNextTime) {
  const test::Folder folder;
  const std::string part = averaged_part(folder, "block.toml"), first = folder / "first.se.h5",
                    second = folder / "second.se.h5";
  for (const std::string& file : {first, second}) {
    const test::Outcome outcome = test::run("flexura-reduce", {part, "-o", file, "--set", "modes.count=40",
                                                               "--petsc", "-eps_blocklanczos_slice 10"});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("none missed: 40 below"));
    EXPECT_THAT(outcome.out, HasSubstr("found in slices of the spectrum"));
  }
  const superelement::Superelement a = superelement::read(first, {.shapes = true}),
                                   b = superelement::read(second, {.shapes = true});
  EXPECT_EQ(a.K_se, b.K_se);
  EXPECT_EQ(a.M_se, b.M_se);
  EXPECT_EQ(a.shapes, b.shapes);
}

// The modes of the free body are found with K + shift M, from whose factor the slices' shifts are to be counted.
TEST(Petsc, SlicesOfAFreeBodyAreTheModesOfOneBasis) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", "set = \"craig_chang\"\n");
  std::vector<Eigen::VectorXd>
      found;  // omega^2 of the free body: the modes of the full model, to their residual squared
  for (const char* const slice : {"0", "20"}) {
    const std::string file = folder / (std::string(slice) + ".se.h5");
    const test::Outcome outcome = test::run(
        "flexura-reduce", {part, "-o", file, "--set", "modes.count=60", "--set", "modes.certify=false",
                           "--petsc", std::string("-eps_blocklanczos_slice ") + slice});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    const superelement::Superelement se = superelement::read(file);
    const Eigen::GeneralizedSelfAdjointEigenSolver<MatrixXd> free(se.K_se, se.M_se, Eigen::EigenvaluesOnly);
    found.push_back(free.eigenvalues().segment(6, 60));
  }
  // Round-off of the dense problem, 1e-16 of the greatest eigenvalue, some 1e5 times the least.
  EXPECT_LT((found[1].cwiseQuotient(found[0]).array() - 1.0).abs().maxCoeff(), 1e-9);
}

// Mesh, elements, factor and the eigensolver's vectors lie on two processes, ties by averages border the matrix.
class UnderMpirun : public ::testing::TestWithParam<Case> {};

TEST_P(UnderMpirun, OptionsCountAndGiveTheSameSuperelement) {
  const test::Folder folder;
  for (const std::string& part : {averaged_part(folder, "block.toml"), deck_part(folder, "beam.toml", "")}) {
    const std::string ours = part + ".ours.se.h5", theirs = part + ".theirs.se.h5";
    const test::Outcome one = test::run("flexura-reduce", {part, "-o", ours, "-q"});
    ASSERT_EQ(one.exit_code, 0) << one.err;
    const test::Outcome two =
        under_mpirun(folder, {part, "-o", theirs, "--petsc", GetParam().options + " -eps_view -log_view"});
    ASSERT_EQ(two.exit_code, 0) << two.err;
    for (const char* text : {GetParam().more.c_str(), "type: mumps", "2 MPI processes", "EPSSolve"})
      EXPECT_THAT(two.out, HasSubstr(text));
    expect_same(superelement::read(ours), superelement::read(theirs));
  }
}
INSTANTIATE_TEST_SUITE_P(
    All, UnderMpirun,
    ::testing::Values(Case{"BlockLanczos", "-eps_blocklanczos_block 8", "type: blocklanczos"},
                      Case{"Slices", "-eps_blocklanczos_slice 2", "slices of the spectrum"},
                      Case{"KrylovSchur", "-eps_type krylovschur", "type: krylovschur"},
                      Case{"Lobpcg", "-eps_type lobpcg", "type: lobpcg"},
                      Case{"LowRank",
                           "-pc_factor_mat_solver_type mumps -mat_mumps_icntl_35 2 -mat_mumps_cntl_7 1e-8",
                           "type: blocklanczos"}),
    [](const auto& info) { return info.param.name; });

TEST(Petsc, UnderMpirunOptionsOfSolversThatAreNotInUseAreRefused) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", "");
  const test::Outcome outcome =
      under_mpirun(folder, {part, "-o", folder / "a.se.h5", "--petsc", "-ksp_type cg"});
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("the processes of mpirun factorise by MUMPS"));
  EXPECT_FALSE(std::filesystem::exists(folder / "a.se.h5"));
}

TEST(Petsc, OptionsOfThePartFileCountAndThoseOfTheCommandComeAfter) {
  const test::Folder folder;
  const std::string part =
      deck_part(folder, "beam.toml", "[solver]\npetsc = \"-eps_type krylovschur -eps_view\"\n");
  const test::Outcome first = test::run("flexura-reduce", {part, "-o", folder / "a.se.h5"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("type: krylovschur"));
  const test::Outcome second =
      test::run("flexura-reduce", {part, "-o", folder / "a.se.h5", "--petsc", "-eps_type blocklanczos"});
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_THAT(second.out, HasSubstr("type: blocklanczos"));
}

TEST(Petsc, ReportsHaveTheWorkInThem) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", "");
  const test::Outcome outcome = test::run(
      "flexura-reduce", {part, "-o", folder / "a.se.h5", "--petsc", "-eps_view -log_view -eps_ncv 47"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.err.find("warning: PETSc"), std::string::npos) << outcome.err;
  for (const char* text :
       {"type: blocklanczos", "blocks of 8 right-hand sides", "(ncv): 47", "type: sinvert", "type: cholesky",
        "package used to perform factorization: fronts", "multifrontal factor", "EPSSolve", "MatMatSolve",
        "MatCholFctrNum", "Summary of Stages", "Assembly", "Factorisation", "Constraint modes",
        "Normal modes", "Projection", "Certificate"})
    EXPECT_THAT(outcome.out, HasSubstr(text));
}

TEST(Petsc, WhatIsRefusedLeavesNothingBehind) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", "");
  const auto expect_refusal = [&](const std::string& file, const std::vector<std::string>& more,
                                  const char* text) {
    std::vector<std::string> words{file, "-o", folder / "a.se.h5"};
    words.insert(words.end(), more.begin(), more.end());
    const test::Outcome outcome = test::run("flexura-reduce", words);
    EXPECT_EQ(outcome.exit_code, 2) << text;
    EXPECT_THAT(outcome.err, HasSubstr(text));
    EXPECT_FALSE(std::filesystem::exists(folder / "a.se.h5"));
  };
  expect_refusal(part, {"--petsc", "-options_file options"}, "-options_file");
  expect_refusal(part, {"--petsc", "-log_view :log.txt"}, "-log_view");
  expect_refusal(part, {"--petsc", "-eps_typ lobpcg"}, "-eps_typ");
  expect_refusal(part, {"--petsc", "-eps_type krylovschur -eps_ncv 3"}, "ncv must be at least nev+1");
  expect_refusal(deck_part(folder, "bad.toml", "[solver]\npetsc = \"-eps_view :x\"\n"), {},
                 "solver.petsc: PETSc option -eps_view :x");
  // Files that PETSc reads and variables that it looks at do not count.
  std::ofstream(folder.path() / ".petscrc") << "-eps_type krylovschur\n";
  const test::Outcome outcome =
      test::run("/usr/bin/env", {"PETSC_OPTIONS=-eps_type krylovschur", "HOME=" + folder.path().string(),
                                 std::string(FLEXURA_BIN_DIR) + "/flexura-reduce", part, "-o",
                                 folder / "b.se.h5", "--petsc", "-eps_view"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("type: blocklanczos"));
}

TEST(Petsc, EqualInputGivesEqualSuperelementsButForTheReport) {
  const test::Folder folder;
  const std::string part = deck_part(folder, "beam.toml", "");
  std::vector<superelement::Superelement> both;
  for (const char* name : {"a.se.h5", "b.se.h5"}) {
    ASSERT_EQ(test::run("flexura-reduce", {part, "-o", folder / name, "-q"}).exit_code, 0);
    both.push_back(superelement::read(folder / name, {.shapes = true}));
  }
  EXPECT_EQ(both[0].K_se, both[1].K_se);
  EXPECT_EQ(both[0].M_se, both[1].M_se);
  EXPECT_EQ(both[0].omega2, both[1].omega2);
  EXPECT_EQ(both[0].shapes, both[1].shapes);
  EXPECT_EQ(both[0].inertia.S_xphi, both[1].inertia.S_xphi);
}

}  // namespace
}  // namespace flexura::reduce
