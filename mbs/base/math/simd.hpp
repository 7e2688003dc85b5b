// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#define FLEXURA_INLINE inline __attribute__((always_inline))

namespace flexura {

/// W numbers that lie together in an array of doubles, added and multiplied at once; the compiler takes the
/// widest registers it may.
template <int W>
struct Lanes {
  typedef double Row __attribute__((vector_size(8 * W), aligned(8), may_alias));
};
template <>
struct Lanes<1> {
  using Row = double;
};

#ifdef __x86_64__
template <class Work>
__attribute__((target("avx2,fma"))) void run_with_avx2(const Work& work) {
  work();
}
template <class Work>
__attribute__((target("avx512f,avx512vl,avx512dq,avx2,fma"))) void run_with_avx512(const Work& work) {
  work();
}
#endif

/// Calls work() compiled for the machine at hand: programs are built for any x86-64, whose registers hold two
/// numbers; where there are registers for four and fused multiply-add, they are used.  `work` and all it
/// calls must be marked always_inline (FLEXURA_INLINE).
template <class Work>
void on_this_machine(const Work& work) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return run_with_avx2(work);
#endif
  work();
}

/// Likewise for long loops, with registers for eight numbers where there are any.
template <class Work>
void on_wide_registers(const Work& work) {
#ifdef __x86_64__
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq"))
    return run_with_avx512(work);
#endif
  on_this_machine(work);
}

}  // namespace flexura
