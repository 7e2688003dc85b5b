// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/session/freed_memory.hpp"

#include <malloc.h>

#include <limits>

namespace flexura::linalg {

// Arrays from 4 MB on are mapped one by one: a fifth of the memory of large parts was holes between others.
void give_back_freed_memory() {
  mallopt(M_MMAP_MAX, 65536);
  mallopt(M_MMAP_THRESHOLD, 4 << 20);
  mallopt(M_TRIM_THRESHOLD, 4 << 20);
}

KeepFreedMemory::KeepFreedMemory() {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
}

KeepFreedMemory::~KeepFreedMemory() {
  give_back_freed_memory();
  malloc_trim(0);
}

}  // namespace flexura::linalg
