// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace flexura::linalg {

inline int n_cores() {
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

/// Calls work(0) ... work(n - 1), each once, on as many threads as the machine has cores.  The first
/// exception is thrown again here.
template <class Work>
void parallel_for(int n, const Work& work) {
  const int n_threads = std::min(n, n_cores());
  std::atomic<int> next{0};
  std::exception_ptr error;
  std::atomic_flag error_taken = ATOMIC_FLAG_INIT;
  const auto run = [&] {
    try {
      for (int i = next++; i < n; i = next++) work(i);
    } catch (...) {
      if (!error_taken.test_and_set()) error = std::current_exception();
      next = n;
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int t = 1; t < n_threads; ++t) helpers.emplace_back(run);
    run();
  }
  if (error) std::rethrow_exception(error);
}

}  // namespace flexura::linalg
