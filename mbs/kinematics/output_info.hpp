// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/base/documents/units.hpp"

namespace flexura::mbs {

/// A named output of an element: "spring.force".
/// What a quantity is to those who judge runs by it, beside its dimension.
enum class OutputRole {
  value,
  energy,           ///< of the energy balance, or the power of it
  mode,             ///< a coordinate of a deformation, which says nothing without its shapes
  place_of_stress,  ///< where the largest stress, strain or displacement is, which leaps
  deformation,      ///< a length by deformation: small beside where its body is, and asked for all the same
};

struct OutputInfo {
  std::string name;  ///< completes "name of the element . "; empty: the element's own name
  input::Dimension dimension;
  std::string doc;
  OutputRole role = OutputRole::value;
};

}  // namespace flexura::mbs
