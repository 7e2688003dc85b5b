// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

/// Which of its kernels OpenBLAS works with. A version that is older than the processor does not know it and takes the kernels of
/// a common ancestor: Debian 12's 0.3.21 those of Prescott (SSE3) on processors of 2023, 3.6 times slower.
namespace flexura::linalg {

/// What a processor and its operating system offer.
struct VectorUnits {
  bool avx2 = false;    ///< AVX2 and FMA3
  bool avx512 = false;  ///< AVX-512 F, CD, BW, DQ, VL
};
VectorUnits vector_units();

/// The value of OPENBLAS_CORETYPE for the best kernels of these units where those `chosen` (openblas_get_corename()) use less
/// than AVX2, else "".
std::string better_kernels(const std::string& chosen, const VectorUnits& units);

/// Products and triangular solves against plain loops, to round-off.
bool kernels_are_right();

/// Starts the program anew (exec) with better kernels where there are some, those of AVX2 where those of AVX-512 are not right on this
/// machine. Leaves what the user set in OPENBLAS_CORETYPE alone. Call it first in main(): nothing of the process is kept but its
/// environment.
void choose_kernels(char** argv);

/// "OpenBLAS SkylakeX (its own choice is Prescott)"; "" of another library.
std::string kernels_in_use();

}  // namespace flexura::linalg
