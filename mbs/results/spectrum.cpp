// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/results/spectrum.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <unsupported/Eigen/FFT>

namespace flexura::results {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Of mean 1, at the place x = i / n of the window.
double weight(Window window, double x) {
  const double phi = 2.0 * std::numbers::pi * x;
  switch (window) {
    case Window::none:
      return 1.0;
    case Window::hann:
      return 1.0 - std::cos(phi);
    case Window::flat_top:
      return 1.0 - 1.90796 * std::cos(phi) + 1.07349 * std::cos(2.0 * phi) - 0.18199 * std::cos(3.0 * phi);
  }
  return 1.0;
}

Index half_width(Window window) {
  return window == Window::none ? 1 : window == Window::hann ? 2 : 4;
}

}  // namespace

Spectrum amplitude_spectrum(const VectorXd& time, const VectorXd& values, double from, double to,
                            Window window) {
  const double* const first = std::lower_bound(time.data(), time.data() + time.size(), from);
  const double* const last = std::upper_bound(first, time.data() + time.size(), to);
  const Index begin = first - time.data(), n = last - first;
  constexpr Index kFewest = 8;
  if (n < kFewest)
    throw std::invalid_argument(
        fmt::format("{} of its {} rows, {:.6g} to {:.6g} s, lie in the range; a spectrum takes {} at least",
                    n, time.size(), time.size() > 0 ? time(0) : 0.0,
                    time.size() > 0 ? time(time.size() - 1) : 0.0, kFewest));
  const double t_0 = time(begin), step = (time(begin + n - 1) - t_0) / static_cast<double>(n - 1);
  if (!(step > 0.0))
    throw std::invalid_argument(
        fmt::format("all rows from {:.6g} s on are of one time; name a range in which time goes on", from));
  Spectrum out;
  std::vector<double> x(static_cast<std::size_t>(n));
  for (Index i = 0, at = begin; i < n; ++i) {
    const double t = t_0 + step * static_cast<double>(i);
    if (std::abs(time(begin + i) - t) <= 1e-6 * step) {
      x[static_cast<std::size_t>(i)] = values(begin + i);
      continue;
    }
    out.resampled = true;
    while (at + 2 < begin + n && time(at + 1) <= t) ++at;
    const double length = time(at + 1) - time(at),
                 part = length > 0.0 ? std::clamp((t - time(at)) / length, 0.0, 1.0) : 1.0;
    x[static_cast<std::size_t>(i)] = values(at) + part * (values(at + 1) - values(at));
  }
  // The window's own mean: nothing of it is left on the first lines.
  const auto w = [&](Index i) { return weight(window, static_cast<double>(i) / static_cast<double>(n)); };
  for (Index i = 0; i < n; ++i) out.mean += w(i) * x[static_cast<std::size_t>(i)] / static_cast<double>(n);
  for (Index i = 0; i < n; ++i) {
    double& value = x[static_cast<std::size_t>(i)];
    value = (value - out.mean) * w(i);
  }
  std::vector<std::complex<double>> X;
  Eigen::FFT<double>().fwd(X, x);
  const Index lines = (n - 1) / 2;
  out.resolution = 1.0 / (step * static_cast<double>(n));
  out.frequency.resize(lines);
  out.amplitude.resize(lines);
  for (Index k = 1; k <= lines; ++k) {
    out.frequency(k - 1) = static_cast<double>(k) * out.resolution;
    out.amplitude(k - 1) = 2.0 * std::abs(X[static_cast<std::size_t>(k)]) / static_cast<double>(n);
  }
  return out;
}

std::vector<Index> peaks(const Spectrum& spectrum, Window window, int count) {
  const VectorXd& a = spectrum.amplitude;
  const Index reach = half_width(window);
  std::vector<Index> found;
  for (Index k = 0; k < a.size(); ++k) {
    bool is_peak = a(k) > 0.0;
    for (Index j = std::max<Index>(0, k - reach); is_peak && j <= std::min(a.size() - 1, k + reach); ++j)
      is_peak = a(j) < a(k) || j == k || (a(j) == a(k) && j > k);
    if (is_peak) found.push_back(k);
  }
  std::ranges::sort(found, [&](Index i, Index j) { return a(i) > a(j); });
  if (static_cast<int>(found.size()) > count) found.resize(static_cast<std::size_t>(std::max(0, count)));
  return found;
}

}  // namespace flexura::results
