// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/dense/blas_threads.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <sys/mman.h>

#include <algorithm>
#include <stdexcept>

#include "mbs/base/threads/pool.hpp"

namespace flexura::linalg {
namespace {

// Other libraries of the same interface do not have these.
int (*const get_threads)() = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
void (*const set_threads)(int) = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT,
                                                                       "openblas_set_num_threads"));

}  // namespace

OneBlasThread::OneBlasThread() : before_(get_threads && set_threads ? get_threads() : 1) {
  if (before_ > 1) set_threads(1);
}

OneBlasThread::~OneBlasThread() {
  if (before_ > 1) set_threads(before_);
}

SomeCores::SomeCores(int n)
    : before_(threads::count()), blas_before_(get_threads && set_threads ? get_threads() : 0) {
  threads::set_count(std::min(n, before_));
  if (blas_before_ > n) set_threads(n);
}

SomeCores::~SomeCores() {
  threads::set_count(before_);
  if (blas_before_ > 0) set_threads(blas_before_);
}

void set_blas_threads(int n) {
  if (set_threads) set_threads(n);
}

void require_blas_memory(int n_threads) {
  if (!get_threads) return;
  constexpr std::size_t kEach = std::size_t{129} << 20;
  const std::size_t size = kEach * static_cast<std::size_t>(n_threads);
  void* const space = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (space == MAP_FAILED)
    throw std::runtime_error(
        fmt::format("out of memory: the linear algebra wants {} MB of address space for its {} thread{}, "
                    "which the system "
                    "does not give; free memory, or raise the limit (ulimit -v)",
                    size >> 20, n_threads, n_threads == 1 ? "" : "s"));
  munmap(space, size);
}

}  // namespace flexura::linalg
