// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

/// Amplitude spectra of stored quantities.
namespace flexura::results {

/// Windows, scaled so that a sine of amplitude a on a line shows as a (G. Heinzel, A. Rüdiger, R. Schilling, Spectrum and
/// spectral density estimation by the DFT, 2002): `none` for whole periods; `hann`, lines 2 wide; `flat_top` (HFT70), lines 4
/// wide, amplitudes between lines within 1 %.
enum class Window { none, hann, flat_top };

struct Spectrum {
  Eigen::VectorXd frequency;  ///< k / T, k = 1 ... (n - 1) / 2 [Hz]
  Eigen::VectorXd amplitude;  ///< in the unit of the values, one-sided, without the mean
  double resolution = 0.0;    ///< 1 / T [Hz]
  double mean = 0.0;          ///< of the values, weighted by the window
  bool resampled = false;     ///< rows were not equidistant: linear between them
};

/// Of the rows with from <= time <= to; n of them, h apart, make up T = n h.  Throws std::invalid_argument for fewer than 8 rows.
Spectrum amplitude_spectrum(const Eigen::VectorXd& time, const Eigen::VectorXd& values, double from,
                            double to, Window window = Window::hann);

/// Indices of local maxima, the largest first, at most `count`; of lines nearer to each other than the window is wide the larger.
std::vector<Eigen::Index> peaks(const Spectrum& spectrum, Window window, int count);

}  // namespace flexura::results
