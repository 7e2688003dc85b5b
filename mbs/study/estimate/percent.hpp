// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/base/terminal/terminal.hpp"

namespace flexura::study {

/// "1.2 %" of 0.0123.
inline std::string percent(double fraction, int digits = 3) {
  return terminal::number(100.0 * fraction, digits) + " %";
}

}  // namespace flexura::study
