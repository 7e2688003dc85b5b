// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/dense/blas_kernels.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <string>

#include "tests/app/command.hpp"

namespace flexura::linalg {
namespace {

using ::testing::HasSubstr;

TEST(BlasKernels, AreThoseOfTheProcessor) {
  constexpr VectorUnits none{}, avx2{true, false}, avx512{true, true};
  for (const char* const old : {"Prescott", "Core2", "Nehalem", "Barcelona", "Sandybridge", "Piledriver"}) {
    EXPECT_EQ(better_kernels(old, none), "");
    EXPECT_EQ(better_kernels(old, avx2), "Haswell");
    EXPECT_EQ(better_kernels(old, avx512), "SkylakeX");
  }
  for (const char* const good :
       {"Haswell", "Zen", "Excavator", "SkylakeX", "Cooperlake", "SapphireRapids", "armv8", ""})
    EXPECT_EQ(better_kernels(good, avx512), "") << good;
}

TEST(BlasKernels, AreRight) {
  EXPECT_TRUE(kernels_are_right());
}

// As the program runs once it has started itself anew on a machine whose processor OpenBLAS does not know.
TEST(BlasKernels, AreProvedAndNamedWhereTheProgramChoseThem) {
  const VectorUnits units = vector_units();
  const auto version = [](const std::map<std::string, std::string>& variables) {
    for (const auto& [name, value] : variables) setenv(name.c_str(), value.c_str(), 1);
    const std::string out = test::run("flexura-reduce", {"--version"}).out;
    for (const auto& [name, value] : variables) unsetenv(name.c_str());
    return out;
  };
  if (version({}).find("kernels: OpenBLAS") == std::string::npos) GTEST_SKIP() << "another BLAS";
  if (units.avx2)
    EXPECT_THAT(version({{"FLEXURA_OPENBLAS_CHOICE", "Prescott"}, {"OPENBLAS_CORETYPE", "Haswell"}}),
                HasSubstr("kernels: OpenBLAS Haswell (its own choice is Prescott)"));
  if (units.avx512)
    EXPECT_THAT(version({{"FLEXURA_OPENBLAS_CHOICE", "Prescott"}, {"OPENBLAS_CORETYPE", "SkylakeX"}}),
                HasSubstr("kernels: OpenBLAS SkylakeX (its own choice is Prescott)"));
  // What the user asks for stays, slow as it is.
  EXPECT_THAT(version({{"OPENBLAS_CORETYPE", "Nehalem"}}), HasSubstr("kernels: OpenBLAS Nehalem\n"));
}

}  // namespace
}  // namespace flexura::linalg
