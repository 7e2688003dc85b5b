// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/solver/linear/mode_noise.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace flexura::mbs {

std::string lost_in_round_off(const std::vector<NaturalMode>& modes) {
  constexpr double kRight = 1e-3;
  constexpr double kHz = 1.0 / (2.0 * M_PI);
  const char* const remedy =
      "a beam keeps more digits with fidelity = \"beam\" or \"rod\" than with \"ancf\", and every body with "
      "fewer elements or modes";
  double least = 0.0, highest = 0.0, of_zeros = 0.0, worst = 0.0, worst_at = 0.0;
  for (const NaturalMode& mode : modes) {
    const double size = std::abs(mode.eigenvalue);
    highest = std::max(highest, size);
    if (size == 0.0) of_zeros = std::max(of_zeros, mode.noise);
    if (mode.eigenvalue.imag() == 0.0) continue;
    if (least == 0.0 || size < least) least = size;
    if (mode.noise > std::max(kRight, worst) * size) worst = mode.noise / size, worst_at = size;
  }
  if (worst > 0.0)
    return fmt::format(
        "the mode at {:.3g} Hz is right to {:.2g} of itself only: the round-off of modes of up to {:.3g} Hz "
        "lies on it; {}",
        worst_at * kHz, worst, highest * kHz, remedy);
  // Free motions are zero to far less than the first vibration.
  if (least > 0.0 && of_zeros > 0.1 * least)
    return fmt::format(
        "modes that are given as zero may be vibrations of up to {:.2g} Hz: the round-off of modes of up to "
        "{:.3g} Hz lies "
        "on them; {}",
        of_zeros * kHz, highest * kHz, remedy);
  return {};
}

}  // namespace flexura::mbs
