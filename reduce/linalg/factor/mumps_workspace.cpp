// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/mumps_workspace.hpp"

#include <dlfcn.h>
#include <dmumps_c.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>

namespace flexura::linalg {
namespace {

MumpsWorkspace* lent = nullptr;

// MUMPS counts in millions where a number is negative.
std::size_t count(MUMPS_INT number) {
  return number < 0 ? std::size_t{1000000} * static_cast<std::size_t>(-number)
                    : static_cast<std::size_t>(number);
}

// Of the documentation's names, ICNTL(k) and INFO(k), which count from one.
MUMPS_INT icntl(const DMUMPS_STRUC_C& id, int k) {
  return id.icntl[k - 1];
}
MUMPS_INT info(const DMUMPS_STRUC_C& id, int k) {
  return id.info[k - 1];
}

// Neither on disk nor of low rank, where a factor is kept otherwise, nor within a bound that the user has set.
bool is_kept_whole(const DMUMPS_STRUC_C& id) {
  return icntl(id, 22) == 0 && icntl(id, 35) == 0 && icntl(id, 23) == 0;
}

}  // namespace

MumpsWorkspace::~MumpsWorkspace() {
  if (begin_) munmap(begin_, bytes_);
}

MumpsWorkspace::Lent::Lent(MumpsWorkspace& workspace) {
  lent = &workspace;
}

MumpsWorkspace::Lent::~Lent() {
  lent = nullptr;
}

double* MumpsWorkspace::reserve(std::size_t numbers) {
  if (begin_) munmap(begin_, bytes_);
  begin_ = nullptr;
  kept_ = 0;
  bytes_ = sizeof(double) * numbers;
  void* const space =
      mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (space != MAP_FAILED) begin_ = static_cast<double*>(space);
  return begin_;
}

void MumpsWorkspace::keep(std::size_t numbers) {
  kept_ = numbers;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t kept = (sizeof(double) * numbers + page - 1) / page * page;
  if (begin_ && kept < bytes_) madvise(reinterpret_cast<char*>(begin_) + kept, bytes_ - kept, MADV_DONTNEED);
}

}  // namespace flexura::linalg

/// MUMPS' own entry, which PETSc calls: a program's functions come before those of its libraries.
extern "C" __attribute__((visibility("default"))) void dmumps_c(DMUMPS_STRUC_C* id) {
  constexpr MUMPS_INT kFactorise = 2;
  using flexura::linalg::count, flexura::linalg::info, flexura::linalg::lent;
  static const auto mumps = reinterpret_cast<void (*)(DMUMPS_STRUC_C*)>(dlsym(RTLD_NEXT, "dmumps_c"));
  const bool is_lent = lent && id->job == kFactorise && flexura::linalg::is_kept_whole(*id);
  if (is_lent) {
    // INFO(8): what it estimates.  A length of 32 bits counts in millions where it is negative.
    const std::size_t millions = 2 * count(info(*id, 8)) / 1000000 + 1;
    id->wk_user = lent->reserve(1000000 * millions);
    id->lwk_user = id->wk_user ? -static_cast<MUMPS_INT>(millions) : 0;
  }
  mumps(id);
  // INFO(9): the numbers from the first on that hold the factor.
  if (is_lent && id->wk_user && info(*id, 1) >= 0) lent->keep(count(info(*id, 9)));
}
