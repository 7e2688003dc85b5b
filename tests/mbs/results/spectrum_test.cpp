// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/results/spectrum.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/mbs/random/chance.hpp"

namespace flexura::results {
namespace {

using Eigen::VectorXd;
using mbs::chance::Chance;
using std::numbers::pi;

// A sum of up to 4 sines far from each other, beside a mean.
struct Signal {
  double mean = 0.0;
  std::vector<double> frequency, amplitude, phase;
  double at(double t) const {
    double x = mean;
    for (std::size_t i = 0; i < frequency.size(); ++i)
      x += amplitude[i] * std::sin(2.0 * pi * frequency[i] * t + phase[i]);
    return x;
  }
};

TEST(Spectrum, ShowsSinesByTheirAmplitudes) {
  for (int seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    Chance chance(static_cast<std::uint64_t>(seed));
    const int n = 400 + chance.below(800);
    const double step = std::pow(10.0, chance.between(-4, 0)), start = chance.between(-2, 2),
                 line = 1.0 / (n * step);
    const bool on_lines = chance.flip(0.5);
    Signal signal;
    signal.mean = chance.between(-5, 5);
    const int count = 1 + chance.below(4);
    for (int i = 0; i < count; ++i) {
      signal.frequency.push_back(
          line * (20 + 40 * i + chance.below(20) + (on_lines ? 0.0 : chance.between(-0.5, 0.5))));
      signal.amplitude.push_back(std::pow(10.0, chance.between(-2, 1)));
      signal.phase.push_back(chance.between(-3, 3));
    }
    VectorXd time(n), values(n);
    for (int i = 0; i < n; ++i) {
      time(i) = start + step * i;
      values(i) = signal.at(time(i));
    }
    const Window window = !on_lines ? Window::flat_top : chance.flip(0.5) ? Window::none : Window::hann;
    const Spectrum s = amplitude_spectrum(time, values, -1e9, 1e9, window);
    EXPECT_FALSE(s.resampled);
    EXPECT_NEAR(s.resolution, line, 1e-9 * line);
    const std::vector<Eigen::Index> found = peaks(s, window, count);
    ASSERT_EQ(static_cast<int>(found.size()), count);
    for (const Eigen::Index k : found) {
      std::size_t nearest = 0;
      for (std::size_t i = 0; i < signal.frequency.size(); ++i)
        if (std::abs(signal.frequency[i] - s.frequency(k)) <
            std::abs(signal.frequency[nearest] - s.frequency(k)))
          nearest = i;
      // On a line exactly; between two the flat top is 1 % low at most, and leaks 1e-3 of the largest, 10, at the others.
      EXPECT_NEAR(s.frequency(k), signal.frequency[nearest], on_lines ? 1e-9 : 2.0 * line);
      EXPECT_NEAR(s.amplitude(k), signal.amplitude[nearest],
                  on_lines ? 1e-9 : 0.011 * signal.amplitude[nearest] + 0.01);
    }
  }
}

TEST(Spectrum, TakesARangeAndRowsThatAreNotEquidistant) {
  Chance chance(5);
  constexpr int n = 4000;
  VectorXd time(n), values(n);
  for (int i = 0; i < n; ++i) {
    time(i) = 1e-3 * (i + chance.between(-0.3, 0.3));
    values(i) = time(i) < 1.0 ? 0.0 : 3.0 * std::sin(2.0 * pi * 20.0 * time(i));
  }
  const Spectrum s = amplitude_spectrum(time, values, 1.5, 3.5, Window::hann);
  EXPECT_TRUE(s.resampled);
  EXPECT_NEAR(s.resolution, 0.5, 1e-3);
  const std::vector<Eigen::Index> found = peaks(s, Window::hann, 1);
  // Linear between rows of up to 1.6 ms: (2 pi f h)^2 / 8.
  EXPECT_NEAR(s.amplitude(found[0]), 3.0, 3.0 * 0.01);
  EXPECT_NEAR(s.frequency(found[0]), 20.0, 0.25);
  EXPECT_THROW(amplitude_spectrum(time, values, 1.5, 1.505), std::invalid_argument);
}

}  // namespace
}  // namespace flexura::results
