// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/threads/pool.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <numeric>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

namespace flexura::threads {
namespace {

TEST(Pool, DoesEachPieceOnce) {
  for (const int n : {0, 1, 2, 7, 1000})
    for (const int most : {1, 2, 5}) {
      std::vector<std::atomic<int>> times(static_cast<std::size_t>(n));
      parallel_for(
          n, [&](int i) { ++times[static_cast<std::size_t>(i)]; }, most);
      for (const auto& count : times) EXPECT_EQ(count, 1);
    }
}

TEST(Pool, TakesAsManyThreadsAsAllowed) {
  std::mutex guard;
  for (const int most : {1, 2, 3}) {
    std::set<std::thread::id> seen;
    parallel_for(
        200,
        [&](int) {
          std::this_thread::sleep_for(std::chrono::microseconds(50));
          const std::lock_guard lock(guard);
          seen.insert(std::this_thread::get_id());
        },
        most);
    EXPECT_GE(seen.size(), 1u);
    EXPECT_LE(seen.size(), static_cast<std::size_t>(most));
  }
}

TEST(Pool, HandsOnTheFirstExceptionAndGoesOnServing) {
  for (int round = 0; round < 50; ++round) {
    EXPECT_THROW(parallel_for(
                     100,
                     [](int i) {
                       if (i == 13) throw std::runtime_error("thirteen");
                     },
                     4),
                 std::runtime_error);
    std::atomic<int> sum{0};
    parallel_for(
        100, [&](int i) { sum += i; }, 4);
    EXPECT_EQ(sum, 4950);
  }
}

// Within shared work, and from two threads at once: nobody waits for one another.
TEST(Pool, IsUsedFromWithinAndBySeveralThreads) {
  std::atomic<int> sum{0};
  const auto use = [&] {
    parallel_for(
        20,
        [&](int) {
          parallel_for(
              20, [&](int) { ++sum; }, 3);
        },
        3);
  };
  std::thread other(use);
  use();
  other.join();
  EXPECT_EQ(sum, 800);
}

}  // namespace
}  // namespace flexura::threads
