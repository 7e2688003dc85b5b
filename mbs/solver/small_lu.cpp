// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/small_lu.hpp"

#include <Eigen/LU>
#include <cmath>
#include <cstring>
#include <utility>

namespace flexura::mbs {

namespace {

// Vectors wider than the registers of every x86-64 are passed inlined here, by no calling convention.
#pragma GCC diagnostic ignored "-Wpsabi"

constexpr int kLargest = 128;  // from here on blocks pay
constexpr int kLanes = 4;

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));

inline Lanes load(const double* x) {
  Lanes out;
  std::memcpy(&out, x, sizeof(out));
  return out;
}
inline void store(double* x, const Lanes& value) {
  std::memcpy(x, &value, sizeof(value));
}

// The processor chooses where it has wider registers than the 16 bytes that every x86-64 has.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define FLEXURA_WIDEST __attribute__((target_clones("arch=haswell", "default")))
#else
#define FLEXURA_WIDEST
#endif

// y <- y - f x over [from, to), multiples of kLanes.
FLEXURA_WIDEST void subtract(double f, const double* x, double* y, int from, int to) {
  for (int j = from; j < to; j += kLanes) store(y + j, load(y + j) - f * load(x + j));
}

FLEXURA_WIDEST void subtract(double f_re, double f_im, const double* x_re, const double* x_im, double* y_re,
                             double* y_im, int from, int to) {
  for (int j = from; j < to; j += kLanes) {
    const Lanes re = load(x_re + j), im = load(x_im + j);
    store(y_re + j, load(y_re + j) - f_re * re + f_im * im);
    store(y_im + j, load(y_im + j) - f_re * im - f_im * re);
  }
}

FLEXURA_WIDEST double dot(const double* x, const double* y, int from, int to) {
  Lanes sum{};
  for (int j = from; j < to; j += kLanes) sum += load(x + j) * load(y + j);
  return sum[0] + sum[1] + sum[2] + sum[3];
}

FLEXURA_WIDEST void dot(const double* x_re, const double* x_im, const double* y_re, const double* y_im,
                        int from, int to, double& re, double& im) {
  Lanes sum_re{}, sum_im{};
  for (int j = from; j < to; j += kLanes) {
    const Lanes a = load(x_re + j), b = load(x_im + j), c = load(y_re + j), d = load(y_im + j);
    sum_re += a * c - b * d;
    sum_im += a * d + b * c;
  }
  re = sum_re[0] + sum_re[1] + sum_re[2] + sum_re[3];
  im = sum_im[0] + sum_im[1] + sum_im[2] + sum_im[3];
}

}  // namespace

template <class Scalar>
struct SmallLu<Scalar>::Large {
  Eigen::PartialPivLU<Matrix> lu;
};

template <class Scalar>
SmallLu<Scalar>::SmallLu() = default;
template <class Scalar>
SmallLu<Scalar>::~SmallLu() = default;

template <class Scalar>
void SmallLu<Scalar>::compute(const Matrix& A) {
  n_ = static_cast<int>(A.rows());
  if (n_ > kLargest) {
    if (!large_) large_ = std::make_unique<Large>();
    large_->lu.compute(A);
    return;
  }
  const int n = n_, stride = stride_ = (n + kLanes - 1) / kLanes * kLanes;
  const auto size = static_cast<std::size_t>(n) * stride;
  for (int part = 0; part < kParts; ++part) {
    U_[part].assign(size, 0.0);
    L_[part].assign(size, 0.0);
    x_[part].assign(stride, 0.0);
  }
  pivot_inverse_.resize(n);
  row_.resize(n);
  for (int i = 0; i < n; ++i) row_[i] = i;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::size_t at = static_cast<std::size_t>(i) * stride + j;
      if constexpr (kComplex) {
        U_[0][at] = A(i, j).real();
        U_[1][at] = A(i, j).imag();
      } else {
        U_[0][at] = A(i, j);
      }
    }
  const auto entry = [&](int i, int j) {
    const std::size_t at = static_cast<std::size_t>(i) * stride + j;
    if constexpr (kComplex)
      return Scalar(U_[0][at], U_[1][at]);
    else
      return U_[0][at];
  };
  for (int k = 0; k < n; ++k) {
    int best = k;
    double largest = -1.0;
    for (int i = k; i < n; ++i) {
      const std::size_t at = static_cast<std::size_t>(i) * stride + k;
      double size_i = std::abs(U_[0][at]);
      if constexpr (kComplex) size_i += std::abs(U_[1][at]);
      if (size_i > largest) {
        largest = size_i;
        best = i;
      }
    }
    if (best != k) {
      std::swap(row_[best], row_[k]);
      for (int part = 0; part < kParts; ++part) {
        double *a = U_[part].data() + static_cast<std::size_t>(k) * stride,
               *b = U_[part].data() + static_cast<std::size_t>(best) * stride;
        for (int j = 0; j < stride; ++j) std::swap(a[j], b[j]);
        for (int j = 0; j < k; ++j) {
          double* column = L_[part].data() + static_cast<std::size_t>(j) * stride;
          std::swap(column[k], column[best]);
        }
      }
    }
    const Scalar inverse = 1.0 / entry(k, k);
    pivot_inverse_[k] = inverse;
    const std::size_t at_k = static_cast<std::size_t>(k) * stride;
    // Columns to the left hold zeros in row k: a block that begins there changes nothing.
    const int from = (k + 1) / kLanes * kLanes;
    for (int part = 0; part < kParts; ++part) U_[part][at_k + k] = 0.0;
    for (int i = k + 1; i < n; ++i) {
      const std::size_t at_i = static_cast<std::size_t>(i) * stride;
      if constexpr (kComplex) {
        const double a_re = U_[0][at_i + k], a_im = U_[1][at_i + k];
        if (a_re == 0.0 && a_im == 0.0) continue;
        const double re = a_re * inverse.real() - a_im * inverse.imag(),
                     im = a_re * inverse.imag() + a_im * inverse.real();
        L_[0][at_k + i] = re;
        L_[1][at_k + i] = im;
        U_[0][at_i + k] = U_[1][at_i + k] = 0.0;
        subtract(re, im, &U_[0][at_k], &U_[1][at_k], &U_[0][at_i], &U_[1][at_i], from, stride);
      } else {
        if (U_[0][at_i + k] == 0.0) continue;
        const double l = U_[0][at_i + k] * inverse;
        L_[0][at_k + i] = l;
        U_[0][at_i + k] = 0.0;
        subtract(l, &U_[0][at_k], &U_[0][at_i], from, stride);
      }
    }
  }
}

template <class Scalar>
void SmallLu<Scalar>::solve_in_place(Vector& x) {
  if (n_ > kLargest) {
    x = large_->lu.solve(x).eval();
    return;
  }
  const int n = n_, stride = stride_;
  if constexpr (kComplex) {
    double *re = x_[0].data(), *im = x_[1].data();
    for (int i = 0; i < n; ++i) {
      re[i] = x(row_[i]).real();
      im[i] = x(row_[i]).imag();
    }
    for (int k = 0; k < n; ++k) {
      const std::size_t at = static_cast<std::size_t>(k) * stride;
      subtract(re[k], im[k], &L_[0][at], &L_[1][at], re, im, (k + 1) / kLanes * kLanes, stride);
    }
    for (int k = n - 1; k >= 0; --k) {
      const std::size_t at = static_cast<std::size_t>(k) * stride;
      double sum_re, sum_im;
      dot(&U_[0][at], &U_[1][at], re, im, (k + 1) / kLanes * kLanes, stride, sum_re, sum_im);
      const double a = re[k] - sum_re, b = im[k] - sum_im;
      const double p = pivot_inverse_[k].real(), q = pivot_inverse_[k].imag();
      re[k] = a * p - b * q;
      im[k] = a * q + b * p;
    }
    for (int i = 0; i < n; ++i) x(i) = Scalar(re[i], im[i]);
  } else {
    double* y = x_[0].data();
    for (int i = 0; i < n; ++i) y[i] = x(row_[i]);
    for (int k = 0; k < n; ++k)
      subtract(y[k], &L_[0][static_cast<std::size_t>(k) * stride], y, (k + 1) / kLanes * kLanes, stride);
    for (int k = n - 1; k >= 0; --k)
      y[k] =
          (y[k] - dot(&U_[0][static_cast<std::size_t>(k) * stride], y, (k + 1) / kLanes * kLanes, stride)) *
          pivot_inverse_[k];
    for (int i = 0; i < n; ++i) x(i) = y[i];
  }
}

template class SmallLu<double>;
template class SmallLu<std::complex<double>>;

}  // namespace flexura::mbs
