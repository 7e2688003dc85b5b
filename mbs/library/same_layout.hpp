// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// A program lays objects of Eigen's and of the standard library's out as the archives of the library do, or they destroy
/// each other's memory.  Compiled with -march=native or -mavx, Eigen aligns to 32 or 64 bytes and allocates in another way,
/// unless it is told not to: the package of CMake (Flexura::mbs) tells it by EIGEN_MAX_ALIGN_BYTES and
/// EIGEN_MALLOC_ALREADY_ALIGNED.  A program that is not compiled alike is not linked: the linker misses the function below, with the
/// program's numbers in its name, and builder.cpp has it for those of the archives.
namespace flexura::mbs {

template <int alignment, bool malloc_is_aligned, bool debugs_containers>
bool is_compiled_as_the_library();

namespace same_layout {
#ifdef _GLIBCXX_DEBUG
constexpr bool kDebugs = true;
#else
constexpr bool kDebugs = false;
#endif
inline const bool kIsChecked =
    is_compiled_as_the_library<EIGEN_MAX_ALIGN_BYTES, EIGEN_MALLOC_ALREADY_ALIGNED != 0, kDebugs>();
}  // namespace same_layout

}  // namespace flexura::mbs
