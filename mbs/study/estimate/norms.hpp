// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

/// How far a signal y(t) is from a reference y*(t), relative to the reference in the same norm:
///
///     max        max |y - y*| / max |y*|
///     rms        rms (y - y*) / rms y*            (trapezoidal rule in t)
///     final      |y(T) - y*(T)| / max |y*|        (a final value may be zero, the signal is not)
///     mean       |mean y - mean y*| / max |y*|
///     peak       |max |y| - max |y*|| / max |y*|
///     frequency  |f - f*| / f*                    (the strongest line of the spectrum)
///     count      |n - n*| / n*                    (how often the signal rises above zero)
namespace flexura::study {

enum class Norm { max, rms, final, mean, peak, frequency, count };

const std::vector<std::string>& norm_names();  ///< in the order of the enumeration
Norm norm_of(const std::string& name);         ///< throws std::invalid_argument

struct Signal {
  Eigen::VectorXd time;  ///< [s], increasing
  Eigen::VectorXd value;
};

/// The part of a signal in from <= t <= to, with room for round-off of the rows' times.
Signal window(const Signal& signal, double from, double to);

/// The size of a reference in a norm: what differences are divided by.
double size_of(const Signal& reference, Norm norm);

/// What a signal comes to by itself: max and peak the largest |y|, final and mean with their sign.
double value_of(const Signal& signal, Norm norm);

/// The difference in a norm, not divided.  Throws std::invalid_argument when the signals do not stand at the
/// same times (1e-9 of the span).
double difference(const Signal& signal, const Signal& reference, Norm norm);

/// The frequency [Hz] of the strongest line of the spectrum above zero: the mean is taken out, a Hann window
/// laid over the signal, and the maximum of its Fourier integral sought beyond 1 / span.  With a single line
/// the error is far below the resolution 1 / span; two lines closer than 2 / span are not told apart.
/// Returns 0 for a signal that is constant.  Throws std::invalid_argument below 8 rows.
double dominant_frequency(const Signal& signal);

}  // namespace flexura::study
