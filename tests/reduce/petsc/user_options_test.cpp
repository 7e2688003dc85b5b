// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/session/user_options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

namespace flexura::linalg {
namespace {

using ::testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    const UserOptions options(parse_options(text));
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), ::testing::Not(HasSubstr("\n")));
    return error.what();
  }
  return "";
}

TEST(UserOptions, NamesAndValuesAreTakenApart) {
  const auto options = parse_options("  -eps_type krylovschur -EPS_VIEW  -eps_tol 1e-12\t-ksp_rtol -1 ");
  ASSERT_EQ(options.size(), 4u);
  EXPECT_EQ(options[0].name, "-eps_type");
  EXPECT_EQ(options[0].value, "krylovschur");
  EXPECT_EQ(options[1].name, "-eps_view");  // PETSc does not tell capital letters apart
  EXPECT_EQ(options[1].value, "");
  EXPECT_EQ(options[3].value, "-1");
  EXPECT_TRUE(parse_options(" ").empty());
  EXPECT_THAT(refusal("krylovschur"), HasSubstr("\"krylovschur\" stands where a name"));
  EXPECT_THAT(refusal("-eps_type krylovschur lobpcg"), HasSubstr("\"lobpcg\" stands where a name"));
}

// Whatever reads or writes files, runs programs or opens windows, in every spelling that PETSc takes.
TEST(UserOptions, FilesAreOutOfReach) {
  for (const char* text : {"-options_file /etc/passwd",
                           "-options_file x",
                           "-OPTIONS_FILE x",
                           "-options_file_yaml x",
                           "-options_string_yaml x",
                           "-log_view :file.txt",
                           "-log_view ascii:file.txt",
                           "-log_trace file",
                           "-log_all file",
                           "-history file",
                           "-eps_view :file",
                           "-eps_view ascii:file:ascii_info",
                           "-eps_view binary",
                           "-eps_view binary:file",
                           "-eps_view hdf5:file",
                           "-eps_view_vectors binary:file",
                           "-eps_view_values :values.txt",
                           "-eps_view_values draw",
                           "-Eps_View :file",
                           "-eps_monitor :file",
                           "-eps_monitor ascii:file",
                           "-eps_monitor_lg",
                           "-ksp_monitor :file",
                           "-ksp_monitor_short :f",
                           "-ksp_view_mat binary",
                           "-ksp_view_mat matlab",
                           "-ksp_view_rhs ascii:x",
                           "-ksp_view ::ascii_info:x",
                           "-ksp_view file.txt",
                           "-eps_error_relative :file",
                           "-eps_converged_reason :file",
                           "-mat_mumps_ooc_tmpdir x",
                           "-mat_mumps_icntl_22 1",
                           "-ksp_python_type a.b",
                           "-pc_type :x",
                           "-pc_python_type x",
                           "-pc_type ./x.so",
                           "-eps_type lib/x.so:create",
                           "-ksp_saws_block",
                           "-saws_port 80",
                           "-dll_prepend x",
                           "-dll_append x",
                           "-info file",
                           "-info :file",
                           "-on_error_attach_debugger",
                           "-start_in_debugger",
                           "-malloc_dump",
                           "-viewer_socket_machine x",
                           "-memory_view :f",
                           "-mat_view :file",
                           "-pc_svd_monitor :f",
                           "-eps_type $(id)",
                           "-eps_type `id`",
                           "-eps_tol 1;id",
                           "-prefix_push x",
                           "-prefix_pop",
                           "-@x",
                           "--eps_type",
                           "-eps-type x",
                           "-eps_type=krylovschur",
                           "-eps_view_values @f"})
    EXPECT_NE(refusal(text), "") << text;
}

TEST(UserOptions, WhatThePartFileDecidesIsRefused) {
  for (const char* text :
       {"-eps_nev 5", "-eps_target 3", "-eps_interval 0,1", "-eps_largest_real", "-eps_smallest_magnitude",
        "-st_shift 1", "-st_type cayley", "-eps_non_hermitian", "-eps_all"})
    EXPECT_THAT(refusal(text), HasSubstr("follows from the part file")) << text;
}

TEST(UserOptions, MisspeltAndUnusedOnesAreNamedBeforeTheWorkBegins) {
  EXPECT_THAT(refusal("-eps_typ krylovschur"), HasSubstr("-eps_typ: nothing in this reduction asks for it"));
  EXPECT_THAT(refusal("-eps_type krylovschr"), HasSubstr("krylovschr"));
  EXPECT_THAT(refusal("-pc_factor_mat_solver_type mumsp"), HasSubstr("mumsp"));
  EXPECT_THAT(refusal("-ksp_type nothing"), HasSubstr("nothing"));
  EXPECT_THAT(refusal("-eps_tol small"), HasSubstr("small"));
  EXPECT_THAT(refusal("-mat_fronts_storage attic"), HasSubstr("attic"));
  EXPECT_THAT(refusal("-eps_blocklanczos_slice -5"), HasSubstr("-5 less than allowed bound 0"));
  // What a type cannot do at all, not only for one problem; a preconditioner that is no solver.
  EXPECT_THAT(refusal("-eps_type ciss"), HasSubstr("only computing all eigenvalues"));
  EXPECT_THAT(refusal("-eps_harmonic"), HasSubstr("only supports Ritz extraction"));
  EXPECT_THAT(refusal("-st_pc_type none"), HasSubstr("by the reduction's own solver"));
  EXPECT_THAT(refusal("-pc_type jacobi"), HasSubstr("it needs a method (-ksp_type cg)"));
  EXPECT_EQ(refusal("-eps_ncv 300 -eps_mpd 200 -eps_blocklanczos_slice 250"), "");
  // Of a solver that is not chosen.
  EXPECT_THAT(refusal("-mat_mumps_icntl_14 50"), HasSubstr("-mat_mumps_icntl_14: nothing"));
  EXPECT_THAT(refusal("-eps_blocklanczos_block 8 -eps_type krylovschur"),
              HasSubstr("-eps_blocklanczos_block: nothing"));
  // All are forgotten afterwards.
  EXPECT_EQ(refusal(""), "");
  EXPECT_EQ(refusal("-eps_view"), "");
}

TEST(UserOptions, WhatMakesSenseIsTaken) {
  for (const char* text :
       {"-eps_type krylovschur -pc_factor_mat_solver_type mumps", "-eps_type lobpcg", "-eps_type jd",
        "-eps_type gd", "-pc_factor_mat_solver_type cholmod",
        "-pc_factor_mat_solver_type mumps -mat_mumps_icntl_14 50", "-eps_view -log_view",
        "-eps_view ::ascii_info_detail", "-eps_monitor -eps_converged_reason", "-eps_tol 1e-13 -eps_ncv 200",
        "-eps_blocklanczos_block 8", "-mat_fronts_storage file", "-eps_error_relative ::ascii_info_detail",
        "-pc_factor_mat_solver_type mumps -mat_mumps_icntl_35 1 -mat_mumps_cntl_7 1e-10",
        "-ksp_type cg -pc_type icc"})
    EXPECT_EQ(refusal(text), "") << text;
}

TEST(UserOptions, ReportsThatNothingGaveAreNamed) {
  const UserOptions options(parse_options("-eps_view_vales"));
  EXPECT_THAT(options.unused(), ::testing::ElementsAre("-eps_view_vales"));
}

}  // namespace
}  // namespace flexura::linalg
