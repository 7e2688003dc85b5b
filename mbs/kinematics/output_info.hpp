// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/base/documents/units.hpp"

namespace flexura::mbs {

/// A named output of an element: "spring.force".
struct OutputInfo {
  std::string name;  ///< completes "name of the element . "; empty: the element's own name
  input::Dimension dimension;
  std::string doc;
};

}  // namespace flexura::mbs
