// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/elements/read_curve.hpp"

#include <stdexcept>

namespace flexura::mbs {

std::vector<input::Key> space_curve_keys() {
  using namespace input;
  return {
      vectors3("points", dim::length, "the curve's points in F; a cubic spline runs through them").required(),
      flag("closed", "the curve runs from the last point back to the first").or_default("false")};
}

SpaceCurve read_space_curve(const input::Section& s) {
  try {
    return SpaceCurve(s.vectors3("points"), s.flag("closed"));
  } catch (const std::invalid_argument& error) {
    throw input::InputError(s.where("points") + ": " + error.what());
  }
}

}  // namespace flexura::mbs
