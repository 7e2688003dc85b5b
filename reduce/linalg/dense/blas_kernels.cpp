// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/dense/blas_kernels.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <vector>

#include "reduce/linalg/dense/blas.hpp"

namespace flexura::linalg {
namespace {

constexpr const char* kCore = "OPENBLAS_CORETYPE";
// What OpenBLAS took by itself, handed on to the program that is started anew.
constexpr const char* kOwnChoice = "FLEXURA_OPENBLAS_CHOICE";
constexpr const char* kAvx2 = "Haswell";
constexpr const char* kAvx512 = "SkylakeX";

std::string core_name() {
  const auto name = reinterpret_cast<char* (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_corename"));
  return name ? name() : "";
}

// Numbers of size 1 that repeat nothing within a test.
double number(int i) {
  return std::sin(1.7 * i + 0.3 * (i % 7));
}

// n x n, column by column.
using Matrix = std::vector<double>;

// |a - b| by round-off of sums of n products of size 1.
bool agree(const Matrix& a, const Matrix& b, int n, double growth = 1.0) {
  const double allowed = 16.0 * n * growth * std::numeric_limits<double>::epsilon();
  for (std::size_t i = 0; i < a.size(); ++i)
    if (!(std::abs(a[i] - b[i]) <= allowed)) return false;
  return true;
}

bool product_is_right(int n, char of_a, char of_b) {
  const std::size_t size = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  Matrix a(size), b(size), c(size), plain(size);
  for (std::size_t i = 0; i < size; ++i) {
    a[i] = number(static_cast<int>(i));
    b[i] = number(static_cast<int>(i) + 11);
    c[i] = plain[i] = number(static_cast<int>(i) + 5);
  }
  const double minus = -1.0, one = 1.0;
  dgemm_(&of_a, &of_b, &n, &n, &n, &minus, a.data(), &n, b.data(), &n, &one, c.data(), &n);
  const auto at = [n](const Matrix& m, char how, int i, int j) {
    return how == 'N' ? m[static_cast<std::size_t>(i + n * j)] : m[static_cast<std::size_t>(j + n * i)];
  };
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < n; ++i)
        plain[static_cast<std::size_t>(i + n * j)] -= at(a, of_a, i, k) * at(b, of_b, k, j);
  return agree(c, plain, n);
}

// L x = b with a unit diagonal and small entries, so that nothing grows.
bool solve_is_right(int n, char side, char how) {
  const std::size_t size = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  Matrix l(size, 0.0), x(size), back(size, 0.0);
  for (int j = 0; j < n; ++j)
    for (int i = j; i < n; ++i) l[static_cast<std::size_t>(i + n * j)] = i == j ? 2.0 : number(i + 3 * j) / n;
  for (std::size_t i = 0; i < size; ++i) x[i] = number(static_cast<int>(i));
  const Matrix b = x;
  const double one = 1.0;
  dtrsm_(&side, "L", &how, "N", &n, &n, &one, l.data(), &n, x.data(), &n);
  const auto at = [&](int i, int j) {
    return how == 'N' ? l[static_cast<std::size_t>(i + n * j)] : l[static_cast<std::size_t>(j + n * i)];
  };
  for (int j = 0; j < n; ++j)
    for (int k = 0; k < n; ++k)
      for (int i = 0; i < n; ++i)
        back[static_cast<std::size_t>(i + n * j)] += side == 'L'
                                                         ? at(i, k) * x[static_cast<std::size_t>(k + n * j)]
                                                         : x[static_cast<std::size_t>(i + n * k)] * at(k, j);
  return agree(back, b, n);
}

[[noreturn]] void start_anew(char** argv, const char* kernels) {
  if (kernels)
    setenv(kCore, kernels, 1);
  else
    unsetenv(kCore);
  execv("/proc/self/exe", argv);
  std::_Exit(127);  // what has started this program is gone
}

}  // namespace

VectorUnits vector_units() {
  VectorUnits units;
#if defined(__x86_64__)
  __builtin_cpu_init();
  units.avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  units.avx512 = units.avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                 __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                 __builtin_cpu_supports("avx512vl");
#endif
  return units;
}

std::string better_kernels(const std::string& chosen, const VectorUnits& units) {
  // Of OpenBLAS' x86 cores (driver/others/dynamic.c), those below AVX2.
  constexpr std::array kSlow = {"Katmai", "Coppermine",  "Northwood",    "Prescott",   "Banias",
                                "Atom",   "Core2",       "Penryn",       "Dunnington", "Nehalem",
                                "Athlon", "Opteron",     "Opteron_SSE3", "Barcelona",  "Nano",
                                "Bobcat", "Sandybridge", "Bulldozer",    "Piledriver", "Steamroller"};
  if (std::ranges::find(kSlow, chosen) == kSlow.end() || !units.avx2) return "";
  return units.avx512 ? kAvx512 : kAvx2;
}

bool kernels_are_right() {
  // Below, at and beyond the widths of registers and blocks.
  for (const int n : {1, 3, 8, 17, 48, 97, 130}) {
    for (const char of_a : {'N', 'T'})
      for (const char of_b : {'N', 'T'})
        if (!product_is_right(n, of_a, of_b)) return false;
    for (const char side : {'L', 'R'})
      for (const char how : {'N', 'T'})
        if (!solve_is_right(n, side, how)) return false;
  }
  return true;
}

void choose_kernels(char** argv) {
  const char* const given = std::getenv(kCore);
  if (std::getenv(kOwnChoice)) {  // this is the program started anew
    if (!given || kernels_are_right()) return;
    start_anew(argv, std::string(given) == kAvx512 ? kAvx2 : nullptr);
  }
  if (given) return;
  const std::string chosen = core_name(), better = better_kernels(chosen, vector_units());
  if (better.empty()) return;
  setenv(kOwnChoice, chosen.c_str(), 1);
  start_anew(argv, better.c_str());
}

std::string kernels_in_use() {
  const std::string name = core_name();
  if (name.empty()) return "";
  const char* const own = std::getenv(kOwnChoice);
  return own && name != own ? fmt::format("OpenBLAS {} (its own choice is {})", name, own)
                            : "OpenBLAS " + name;
}

}  // namespace flexura::linalg
