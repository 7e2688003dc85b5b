// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_start.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "mesh/gmsh/job.hpp"

// g++ tells the address sanitizer by a macro, clang by a feature.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define __SANITIZE_ADDRESS__
#endif
#endif

namespace flexura::mesh {

bool start_worker(pid_t parent) {
#ifndef __SANITIZE_ADDRESS__  // its shadow takes terabytes of addresses
  const auto memory =
      static_cast<rlim_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  const rlimit most{memory, memory};
  setrlimit(RLIMIT_AS, &most);
#endif
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  close_range(kProgressDescriptor + 1, ~0U, 0);  // of files that the parent has open
  return getppid() == parent;                    // it may have gone before the line above took hold
}

}  // namespace flexura::mesh
