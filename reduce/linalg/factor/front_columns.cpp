// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/linalg/factor/front_columns.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "reduce/linalg/dense/blas.hpp"
#include "reduce/linalg/dense/parallel.hpp"

namespace flexura::linalg {
namespace {

constexpr std::ptrdiff_t kNarrow = 24;  // columns that are factorised one by one
constexpr std::ptrdiff_t kTile = 960;   // rows of a product that one core takes at a time

// Calls work(first, count) for shares of n rows: one share, or several on all cores where the work of `flops`
// pays for threads.
template <class Work>
void share_rows(std::ptrdiff_t n, double flops, bool on_all_cores, const Work& work) {
  const int shares = on_all_cores && flops > 2e6 ? 2 * n_cores() : 1;
  if (shares == 1) return work(std::ptrdiff_t{0}, n);
  parallel_for(shares, [&](int k) {
    const std::ptrdiff_t first = n * k / shares;
    work(first, n * (k + 1) / shares - first);
  });
}

// The routines of BLAS for both precisions.
template <class Real>
struct Blas;
template <>
struct Blas<double> {
  static constexpr auto gemm = dgemm_;
  static constexpr auto trsm = dtrsm_;
};
template <>
struct Blas<float> {
  static constexpr auto gemm = sgemm_;
  static constexpr auto trsm = strsm_;
};

// C -= A B^T with A m x k, B n x k.
template <class Real>
void subtract_product(std::ptrdiff_t m, std::ptrdiff_t n, std::ptrdiff_t k, const Real* A, std::ptrdiff_t lda,
                      const Real* B, std::ptrdiff_t ldb, Real* C, std::ptrdiff_t ldc) {
  if (m == 0 || n == 0 || k == 0) return;
  const int size[] = {static_cast<int>(m), static_cast<int>(n), static_cast<int>(k)};
  const int strides[] = {static_cast<int>(lda), static_cast<int>(ldb), static_cast<int>(ldc)};
  const Real minus = -1, one = 1;
  Blas<Real>::gemm("N", "T", &size[0], &size[1], &size[2], &minus, A, &strides[0], B, &strides[1], &one, C,
                   &strides[2]);
}

// B S, n x k with the signs of the columns; B itself where all are positive.
template <class Real>
const Real* with_signs(const Real* B, std::ptrdiff_t& ldb, std::ptrdiff_t n, std::ptrdiff_t k,
                       const double* signs, std::vector<Real>& copy) {
  if (std::all_of(signs, signs + k, [](double s) { return s > 0.0; })) return B;
  copy.resize(static_cast<std::size_t>(n * k));
  for (std::ptrdiff_t c = 0; c < k; ++c)
    for (std::ptrdiff_t i = 0; i < n; ++i)
      copy[c * n + i] = signs[c] > 0.0 ? B[c * ldb + i] : -B[c * ldb + i];
  ldb = n;
  return copy.data();
}

// One block of columns: `width` columns of `height` rows, ld apart.
template <class Real>
class Columns {
 public:
  Columns(std::ptrdiff_t ld, bool must_be_definite, bool on_all_cores)
      : ld_(ld), must_be_definite_(must_be_definite), on_all_cores_(on_all_cores) {}

  // By halves.  -1, or the column that failed.
  std::ptrdiff_t factorise(Real* F, std::ptrdiff_t height, std::ptrdiff_t width, double* signs) const {
    if (width <= kNarrow) return factorise_narrow(F, height, width, signs);
    const std::ptrdiff_t left = (width / 2 + kNarrow - 1) / kNarrow * kNarrow, right = width - left;
    if (const std::ptrdiff_t failed = factorise(F, height, left, signs); failed >= 0) return failed;
    std::vector<Real> copy;
    std::ptrdiff_t ldb = ld_;
    const Real* B = with_signs(F + left, ldb, right, left, signs, copy);
    const std::ptrdiff_t rows = height - left;
    share_rows(rows, 2.0 * static_cast<double>(rows * right * left), on_all_cores_,
               [&](std::ptrdiff_t first, std::ptrdiff_t count) {
                 subtract_product(count, right, left, F + left + first, ld_, B, ldb,
                                  F + left * ld_ + left + first, ld_);
               });
    const std::ptrdiff_t failed = factorise(F + left * ld_ + left, rows, right, signs + left);
    return failed < 0 ? failed : left + failed;
  }

 private:
  std::ptrdiff_t factorise_narrow(Real* F, std::ptrdiff_t height, std::ptrdiff_t width, double* signs) const {
    for (std::ptrdiff_t c = 0; c < width; ++c) {
      Real* l = F + c * ld_;
      const Real d = l[c];
      if (!std::isfinite(d) || (must_be_definite_ ? !(d > 0) : d == 0)) return c;
      const Real sign = d > 0 ? 1 : -1;
      signs[c] = sign;
      l[c] = std::sqrt(std::abs(d));
      for (std::ptrdiff_t i = c + 1; i < width; ++i) l[i] *= sign / l[c];
      for (std::ptrdiff_t j = c + 1; j < width; ++j)
        for (std::ptrdiff_t i = j; i < width; ++i) F[j * ld_ + i] -= sign * l[j] * l[i];
    }
    // L_21 = A_21 L_11^-T S.
    const std::ptrdiff_t below = height - width;
    if (below == 0) return -1;
    share_rows(below, static_cast<double>(below * width * width), on_all_cores_,
               [&](std::ptrdiff_t first, std::ptrdiff_t count) {
                 const int m = static_cast<int>(count), n = static_cast<int>(width),
                           stride = static_cast<int>(ld_);
                 const Real one = 1;
                 Real* B = F + width + first;
                 Blas<Real>::trsm("R", "L", "T", "N", &m, &n, &one, F, &stride, B, &stride);
                 for (std::ptrdiff_t c = 0; c < width; ++c)
                   if (signs[c] < 0.0)
                     for (std::ptrdiff_t i = 0; i < count; ++i) B[c * ld_ + i] = -B[c * ld_ + i];
               });
    return -1;
  }

  std::ptrdiff_t ld_;
  bool must_be_definite_, on_all_cores_;
};

}  // namespace

template <class Real>
std::ptrdiff_t factorise_front(const Trapezoid& shape, Real* F, Real* U, double* signs, bool must_be_definite,
                               bool on_all_cores) {
  const Trapezoid rest{shape.height - shape.width, shape.height - shape.width};
  // A piece of the blocks to the right: C, `height` rows from `row` of the front on, `width` columns from
  // `column` on.
  struct Tile {
    Real* C;
    std::ptrdiff_t ld, row, height, column, width;
  };
  std::vector<Tile> tiles;
  std::vector<Real> copy;
  for (int b = 0; b < shape.n_blocks(); ++b) {
    Real* D = F + shape.offset(b);
    const std::ptrdiff_t ld = shape.stride(b), count = shape.count(b), start = shape.first(b);
    const std::ptrdiff_t failed =
        Columns<Real>(ld, must_be_definite, on_all_cores).factorise(D, ld, count, signs + start);
    if (failed >= 0) return start + failed;
    std::ptrdiff_t ldb = ld;
    const Real* B = with_signs(D + count, ldb, ld - count, count, signs + start, copy);
    tiles.clear();
    const auto cut = [&](const Trapezoid& target, int k, std::ptrdiff_t column, Real* C) {
      for (std::ptrdiff_t r = 0; r < target.stride(k); r += kTile)
        tiles.push_back({C + r, target.stride(k), column + r, std::min(kTile, target.stride(k) - r), column,
                         target.count(k)});
    };
    for (int k = b + 1; k < shape.n_blocks(); ++k) cut(shape, k, shape.first(k), F + shape.offset(k));
    for (int k = 0; k < rest.n_blocks(); ++k) cut(rest, k, shape.width + rest.first(k), U + rest.offset(k));
    const auto subtract = [&](int t) {
      const Tile& tile = tiles[t];
      subtract_product(tile.height, tile.width, count, D + (tile.row - start), ld,
                       B + (tile.column - start - count), ldb, tile.C, tile.ld);
    };
    const int n_tiles = static_cast<int>(tiles.size());
    if (on_all_cores)
      parallel_for(n_tiles, subtract);
    else
      for (int t = 0; t < n_tiles; ++t) subtract(t);
  }
  return -1;
}

template std::ptrdiff_t factorise_front(const Trapezoid&, double*, double*, double*, bool, bool);
template std::ptrdiff_t factorise_front(const Trapezoid&, float*, float*, double*, bool, bool);

}  // namespace flexura::linalg
