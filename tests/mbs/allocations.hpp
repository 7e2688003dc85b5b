// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstdlib>

#include "tests/sanitized.hpp"

/// Counts every allocation of the program, those of Eigen through malloc too.  Include it in one file of a
/// program.  Under the address sanitizer, which owns malloc, nothing is counted.
namespace {
std::atomic<long> allocations{0};
}

extern "C" void* __libc_malloc(std::size_t);
#if !defined(FLEXURA_ADDRESS_SANITIZER)
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
#endif
