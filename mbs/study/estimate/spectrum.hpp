// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

namespace flexura::study {

/// The frequency [Hz] below which the share of the power of all columns of y lies, y sampled every h [s]. The
/// mean is taken away and a Hann window laid over, so the resolution is 2 / (n h).
double reach(const Eigen::MatrixXd& y, double h, double share);

}  // namespace flexura::study
