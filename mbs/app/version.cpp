// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <linux/seccomp.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <Eigen/Core>
#include <cstdint>

#include "mbs/app/commands.hpp"
#include "mbs/base/terminal/libraries.hpp"
#include "mbs/view/html/resources.hpp"

namespace flexura::app {

namespace {

// Where it does, the programs that read meshes and CAD files give up what reading does not need (mesh/gmsh/worker/sandbox.hpp).
bool kernel_filters_calls() {
  const std::uint32_t action = SECCOMP_RET_ERRNO;
  return ::syscall(SYS_seccomp, SECCOMP_GET_ACTION_AVAIL, 0, &action) == 0;
}

}  // namespace

std::string version_details() {
  std::string text = fmt::format("compiler: {}\nlibraries: Eigen {}.{}.{}, {}\n",
#ifdef __clang__
                                 "clang " __clang_version__,
#else
                                 "g++ " __VERSION__,
#endif
                                 EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                                 terminal::loaded_libraries());
  text += fmt::format("pages for the browser: {}\n", view::has_pages() ? "yes" : view::kNoPages);
  for (const char* const companion :
       {"flexura-reduce", "flexura-mesh", "flexura-import", "flexura-assembly"}) {
    const bool is_there = ::access((program_folder() / companion).c_str(), X_OK) == 0;
    text += fmt::format("{}: {}\n", companion,
                        is_there ? "yes" : "not beside this program; install the package flexura-reduce");
  }
  text += fmt::format("sandbox of flexura-mesh and flexura-assembly: {}\n",
                      kernel_filters_calls() ? "seccomp" : "none, this kernel has no seccomp filters");
  return text;
}

}  // namespace flexura::app
