// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace flexura {

/// Relative step of central differences: with h = eps^(1/3) truncation and round-off are both about eps^(2/3)
/// = 4e-11 of the scale.
constexpr double kCentralStep = 6e-6;

}  // namespace flexura
