/* Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later */
/* Preloaded by faults_test.cpp: lets calls of the C library fail, as a full disk, a broken one or a small
 * machine does.
 *
 * FLEXURA_FAULT = KIND:N       the N-th call of this kind (from 1) fails once
 *                 KIND:N+      and all that follow
 *                 KIND:0       none; the calls are counted
 * FLEXURA_FAULT_FROM = NAME    counted from when a file of this name is opened, so that neither the loader
 * nor the processes beside the program's own count FLEXURA_FAULT_COUNT = FILE   the number of calls goes
 * there at the end
 *
 * KIND: write (to regular files), create (open for writing), sync, rename, allocate (from 1 kB on: what a
 * machine refuses; not those that HDF5, MPI and the loader make for themselves: they do not survive them), map.  Thread-safe:
 * one atomic counter. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

extern void* __libc_malloc(size_t);
extern void* __libc_calloc(size_t, size_t);
extern void* __libc_realloc(void*, size_t);
extern void* __libc_memalign(size_t, size_t);

enum kind { none, writing, creating, syncing, renaming, allocating, mapping };
static enum kind wanted = none;
static long at = 0;
static int goes_on = 0;
static const char* from = NULL;
static atomic_int armed = 0;
static atomic_long calls = 0;

static void read_environment(void) {
  static const char* const names[] = {"", "write", "create", "sync", "rename", "allocate", "map"};
  const char* fault = getenv("FLEXURA_FAULT");
  if (fault == NULL) return;
  for (int k = 1; k < 7; ++k) {
    const size_t n = strlen(names[k]);
    if (strncmp(fault, names[k], n) == 0 && fault[n] == ':') {
      wanted = (enum kind)k;
      at = strtol(fault + n + 1, NULL, 10);
      goes_on = strchr(fault, '+') != NULL;
    }
  }
  from = getenv("FLEXURA_FAULT_FROM");
  if (from == NULL) armed = 1;
}

__attribute__((constructor)) static void start(void) {
  read_environment();
}

__attribute__((destructor)) static void end(void) {
  const char* name = getenv("FLEXURA_FAULT_COUNT");
  if (name == NULL || !armed) return;
  wanted = none;
  FILE* file = fopen(name, "w");
  if (file == NULL) return;
  fprintf(file, "%ld\n", (long)calls);
  fclose(file);
}

static int fails(enum kind kind) {
  if (kind != wanted || !armed) return 0;
  const long n = ++calls;
  return at > 0 && (n == at || (goes_on && n > at));
}

static void see(const char* path) {
  if (armed || from == NULL || path == NULL) return;
  const size_t n = strlen(path), m = strlen(from);
  if (n >= m && strcmp(path + n - m, from) == 0) armed = 1;
}

static int is_file(int fd) {
  struct stat info;
  return fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
}

#define REAL(name)               \
  static __typeof__(&name) real; \
  if (real == NULL) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)

#define WRITER(name, parameters, arguments)                   \
  ssize_t name parameters {                                   \
    REAL(name);                                               \
    if (wanted == writing && is_file(fd) && fails(writing)) { \
      errno = ENOSPC;                                         \
      return -1;                                              \
    }                                                         \
    return real arguments;                                    \
  }
WRITER(write, (int fd, const void* data, size_t size), (fd, data, size))
WRITER(pwrite, (int fd, const void* data, size_t size, off_t place), (fd, data, size, place))
WRITER(pwrite64, (int fd, const void* data, size_t size, off64_t place), (fd, data, size, place))
WRITER(writev, (int fd, const struct iovec* data, int n), (fd, data, n))

/* Devices are no files; /dev/shm is a folder in memory, where the tests' files lie. */
static int is_no_place(const char* path) {
  return (strncmp(path, "/dev/", 5) == 0 && strncmp(path, "/dev/shm/", 9) != 0) ||
         strncmp(path, "/proc/", 6) == 0;
}

static int opens(const char* path, int flags) {
  see(path);
  if ((flags & (O_WRONLY | O_RDWR)) == 0 || is_no_place(path)) return 0;
  return fails(creating);
}

#define OPENER(name)                                                                       \
  int name(const char* path, int flags, ...) {                                             \
    REAL(name);                                                                            \
    va_list list;                                                                          \
    va_start(list, flags);                                                                 \
    const mode_t mode = (flags & (O_CREAT | __O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0; \
    va_end(list);                                                                          \
    if (opens(path, flags)) {                                                              \
      errno = ENOSPC;                                                                      \
      return -1;                                                                           \
    }                                                                                      \
    return real(path, flags, mode);                                                        \
  }
OPENER(open)
OPENER(open64)

#define FOPENER(name)                                                      \
  FILE* name(const char* path, const char* mode) {                         \
    REAL(name);                                                            \
    if (opens(path, strpbrk(mode, "wa+") != NULL ? O_WRONLY : O_RDONLY)) { \
      errno = ENOSPC;                                                      \
      return NULL;                                                         \
    }                                                                      \
    return real(path, mode);                                               \
  }
FOPENER(fopen)
FOPENER(fopen64)

#define FAILING(name, kind, code, parameters, arguments) \
  int name parameters {                                  \
    REAL(name);                                          \
    if (fails(kind)) {                                   \
      errno = code;                                      \
      return -1;                                         \
    }                                                    \
    return real arguments;                               \
  }
FAILING(fsync, syncing, EIO, (int fd), (fd))
FAILING(fdatasync, syncing, EIO, (int fd), (fd))
FAILING(rename, renaming, EACCES, (const char* a, const char* b), (a, b))
FAILING(renameat, renaming, EACCES, (int p, const char* a, int q, const char* b), (p, a, q, b))
FAILING(link, renaming, EACCES, (const char* a, const char* b), (a, b))

#define MAPPER(name, offset)                                                              \
  void* name(void* place, size_t size, int protection, int flags, int fd, offset from_) { \
    REAL(name);                                                                           \
    if (fails(mapping)) {                                                                 \
      errno = ENOMEM;                                                                     \
      return MAP_FAILED;                                                                  \
    }                                                                                     \
    return real(place, size, protection, flags, fd, from_);                               \
  }
MAPPER(mmap, off_t)
MAPPER(mmap64, off64_t)

static int refused(size_t size, void* caller) {
  if (size < 1024 || wanted != allocating || !armed) return 0;
  static const char* const delicate[] = {"libhdf5", "libmpi", "libopen-", "ld-linux",
                                         "libpmix", "mca_",   "libevent", "libhwloc"};
  Dl_info from_;
  if (dladdr(caller, &from_) != 0 && from_.dli_fname != NULL)
    for (size_t k = 0; k < sizeof delicate / sizeof *delicate; ++k)
      if (strstr(from_.dli_fname, delicate[k]) != NULL) return 0;
  if (!fails(allocating)) return 0;
  errno = ENOMEM;
  return 1;
}
#define CALLER __builtin_return_address(0)
void* malloc(size_t size) {
  return refused(size, CALLER) ? NULL : __libc_malloc(size);
}
void* calloc(size_t n, size_t size) {
  return refused(n * size, CALLER) ? NULL : __libc_calloc(n, size);
}
void* realloc(void* old, size_t size) {
  return refused(size, CALLER) ? NULL : __libc_realloc(old, size);
}
void* memalign(size_t alignment, size_t size) {
  return refused(size, CALLER) ? NULL : __libc_memalign(alignment, size);
}
void* aligned_alloc(size_t alignment, size_t size) {
  return refused(size, CALLER) ? NULL : __libc_memalign(alignment, size);
}
int posix_memalign(void** out, size_t alignment, size_t size) {
  if (refused(size, CALLER)) return ENOMEM;
  *out = __libc_memalign(alignment, size);
  return *out == NULL ? ENOMEM : 0;
}
