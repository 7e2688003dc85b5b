// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/sandbox.hpp"

#include <fcntl.h>
#include <sched.h>
#include <seccomp.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <cerrno>
#include <memory>

namespace flexura::mesh {
namespace {

// What gmsh, OpenCASCADE, a BLAS with threads and the C library do while they read and compute.  No ioctl: it types into a
// terminal.
constexpr const char* kAllowed[] = {
    // files, for reading, and descriptors
    "read", "readv", "pread64", "preadv", "write", "writev", "lseek", "_llseek", "close", "close_range",
    "dup", "dup2", "dup3", "stat", "stat64", "lstat", "lstat64", "fstat", "fstat64", "newfstatat",
    "fstatat64", "statx", "statfs", "statfs64", "fstatfs", "fstatfs64", "access", "faccessat", "faccessat2",
    "readlink", "readlinkat", "getcwd", "getdents", "getdents64", "fadvise64", "pipe", "pipe2", "poll",
    "ppoll", "select", "pselect6",
    // memory
    "brk", "mmap", "mmap2", "munmap", "mremap", "mprotect", "madvise", "mincore", "membarrier",
    "get_mempolicy", "set_mempolicy", "mbind",
    // threads and time
    "futex", "futex_time64", "set_robust_list", "get_robust_list", "set_tid_address", "rseq", "sched_yield",
    "sched_getaffinity", "sched_getparam", "sched_getscheduler", "getcpu", "arch_prctl", "clock_gettime",
    "clock_gettime64", "clock_getres", "clock_nanosleep", "nanosleep", "gettimeofday", "time", "times",
    "restart_syscall",
    // signals to itself, its end
    "rt_sigaction", "rt_sigprocmask", "rt_sigreturn", "sigreturn", "sigaltstack", "exit", "exit_group",
    // what it is and has
    "getpid", "gettid", "getppid", "getuid", "getuid32", "geteuid", "geteuid32", "getgid", "getgid32",
    "getegid", "getegid32", "uname", "sysinfo", "getrusage", "getrlimit", "ugetrlimit", "getrandom"};

using Filter = std::unique_ptr<void, void (*)(scmp_filter_ctx)>;

/// An argument that is `value`, or has it in the bits of `mask`.
scmp_arg_cmp is(unsigned argument, scmp_datum_t value) {
  return {argument, SCMP_CMP_EQ, value, 0};
}
scmp_arg_cmp is(unsigned argument, scmp_datum_t mask, scmp_datum_t value) {
  return {argument, SCMP_CMP_MASKED_EQ, mask, value};
}

int allow(const Filter& filter, const char* name, std::initializer_list<scmp_arg_cmp> where = {}) {
  const int number = seccomp_syscall_resolve_name(name);
  if (number == __NR_SCMP_ERROR) return 0;  // not on this processor
  return seccomp_rule_add_array(filter.get(), SCMP_ACT_ALLOW, number, static_cast<unsigned>(where.size()),
                                where.begin());
}

}  // namespace

bool enter_sandbox() {
  const Filter filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)), seccomp_release);
  if (!filter) return false;
  int failed = 0;
  for (const char* const name : kAllowed) failed |= allow(filter, name);
  // Opened to be read, nothing else.
  constexpr scmp_datum_t to_write = O_ACCMODE | O_CREAT | O_TRUNC | O_APPEND;
  failed |= allow(filter, "open", {is(1, to_write, O_RDONLY)});
  failed |= allow(filter, "openat", {is(2, to_write, O_RDONLY)});
  // Threads, no processes.  What clone3 is asked for cannot be seen: without it the C library takes clone.
  failed |= allow(filter, "clone", {is(0, CLONE_THREAD, CLONE_THREAD)});
  failed |= seccomp_rule_add(filter.get(), SCMP_ACT_ERRNO(ENOSYS), SCMP_SYS(clone3), 0);
  for (const int command : {F_DUPFD, F_DUPFD_CLOEXEC, F_GETFD, F_SETFD, F_GETFL})
    for (const char* const name : {"fcntl", "fcntl64"})
      failed |= allow(filter, name, {is(1, static_cast<scmp_datum_t>(command))});
  failed |= allow(filter, "prlimit64", {is(0, 0)});  // its own limits
  failed |= allow(filter, "prctl", {is(0, PR_SET_NAME)});
  failed |= allow(filter, "tgkill", {is(0, static_cast<scmp_datum_t>(getpid()))});  // abort()
  failed |= seccomp_attr_set(filter.get(), SCMP_FLTATR_CTL_TSYNC, 1);  // threads that run already, too
  return failed == 0 && seccomp_load(filter.get()) == 0;
}

}  // namespace flexura::mesh
