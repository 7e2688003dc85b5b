// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <source_location>
#include <string>

/// Comparisons with references for the verification manual: they fail like EXPECT_NEAR, and leave what they compared in
/// the test's XML (--gtest_output), from which tests/setup/references_page.py makes docs/verification/references.md.
namespace flexura::test {

/// Where a reference comes from, and why the tolerance is what it is.
struct Reference {
  const char* source;
  const char* why;
};

/// |ours - reference| <= tolerance, all in `unit` ("" where it has none).
inline void expect_reference(const std::string& what, const char* unit, double ours, double reference,
                             double tolerance, const Reference& from,
                             std::source_location where = std::source_location::current()) {
  static int count = 0;  // a property of the same name would take the other's place
  char numbers[100];
  std::snprintf(numbers, sizeof numbers, "%.10g\t%.10g\t%.3g", ours, reference, tolerance);
  ::testing::Test::RecordProperty("reference_" + std::to_string(++count),
                                  what + "\t" + unit + "\t" + numbers + "\t" + from.source + "\t" + from.why);
  if (!(std::abs(ours - reference) <= tolerance))
    ADD_FAILURE_AT(where.file_name(), static_cast<int>(where.line()))
        << what << ": " << numbers << " (ours, reference, tolerance) " << unit;
}

}  // namespace flexura::test
