// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura::linalg {

/// Gives large arrays back to the system as soon as they are freed.
void give_back_freed_memory();

/// As long as one lives, freed memory is kept for the next array instead: an eigensolver makes the same few blocks of
/// vectors again and again, and pages that the system hands out anew are cleared first, which took a quarter of its
/// processor time.  Afterwards give_back_freed_memory() counts again, for what was kept too.
class KeepFreedMemory {
 public:
  KeepFreedMemory();
  ~KeepFreedMemory();
  KeepFreedMemory(const KeepFreedMemory&) = delete;
  KeepFreedMemory& operator=(const KeepFreedMemory&) = delete;
};

}  // namespace flexura::linalg
