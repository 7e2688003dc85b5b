// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/blas_threads.hpp"

#include <dlfcn.h>

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

}  // namespace flexura::linalg
