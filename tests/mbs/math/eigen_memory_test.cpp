// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstdlib>
#include <new>

// A reduction without memory ended with "double free or corruption" and left its lock behind: Eigen frees a
// matrix's numbers twice where the new ones are refused.
TEST(EigenMemory, AMatrixThatCannotGrowIsFreedOnce) {
  constexpr Eigen::Index kFarTooMany = Eigen::Index{1} << 44;  // 128 TiB
  for (const Eigen::Index size : {2, 10, 100, 1000}) {
    EXPECT_THROW(
        {
          Eigen::MatrixXd A = Eigen::MatrixXd::Ones(size, size);
          A.resize(kFarTooMany, 1);
        },
        std::bad_alloc);
    EXPECT_THROW(
        {
          Eigen::VectorXd x = Eigen::VectorXd::Ones(size);
          x.resize(kFarTooMany);
        },
        std::bad_alloc);
  }
}

// Nor does what is asked for in between get its place.
TEST(EigenMemory, ItsPlaceIsGivenToNobodyElse) {
  for (int k = 0; k < 100; ++k) try {
      Eigen::VectorXd x = Eigen::VectorXd::Ones(8);
      const double* const old = x.data();
      try {
        x.resize(Eigen::Index{1} << 44);
      } catch (const std::bad_alloc&) {
        Eigen::VectorXd other = Eigen::VectorXd::Constant(8, 3.0);
        EXPECT_NE(other.data(), old);
        throw;
      }
    } catch (const std::bad_alloc&) {
    }
}
