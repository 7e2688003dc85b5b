// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// The reference pages in cases/ are what the programs print from their schemas.
#include <gtest/gtest.h>

#include "tests/app/command.hpp"

namespace flexura::test {
namespace {

std::string page(const std::string& name) {
  return read_text(std::filesystem::path(FLEXURA_SOURCE_DIR) / "cases" / name);
}

TEST(ReferencePages, PartFilePageIsPrintedFromItsSchema) {
  const Outcome outcome = run("flexura-reduce", {"--schema"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, page("PART_FILE.md")) << "renew it: flexura reduce --schema > cases/PART_FILE.md";
}

TEST(ReferencePages, BeamFilePageIsPrintedFromItsSchema) {
  const Outcome outcome = run("flexura-reduce", {"--schema-beams"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, page("BEAM_FILE.md"))
      << "renew it: flexura reduce --schema-beams > cases/BEAM_FILE.md";
}

TEST(ReferencePages, FlexDataPageIsPrintedFromItsSchema) {
  const Outcome outcome = run("flexura-reduce", {"--schema-flexdata"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, page("FLEXDATA_FILE.md"))
      << "renew it: flexura reduce --schema-flexdata > cases/FLEXDATA_FILE.md";
}

TEST(ReferencePages, SectionFilePageIsPrintedFromItsSchema) {
  const Outcome outcome = run("flexura", {"section", "--schema"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, page("SECTION_FILE.md"))
      << "renew it: flexura section --schema > cases/SECTION_FILE.md";
}

TEST(ReferencePages, MechanismFilePageIsPrintedFromItsSchema) {
  const Outcome outcome = run("flexura", {"simulate", "--schema"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, page("MECHANISM_FILE.md"))
      << "renew it: flexura simulate --schema > cases/MECHANISM_FILE.md";
}

TEST(ReferencePages, StudyFilePageIsPrintedFromItsSchema) {
  const Outcome outcome = run("flexura", {"study", "--schema"});
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.out, page("STUDY_FILE.md")) << "renew it: flexura study --schema > cases/STUDY_FILE.md";
}

}  // namespace
}  // namespace flexura::test
