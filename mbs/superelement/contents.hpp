// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>

#include "mbs/superelement/superelement.hpp"

namespace flexura::superelement {

/// What the parts of a superelement file take once they are read, as doubles [B].
struct PartSizes {
  double matrices = 0.0, inertia = 0.0, stiffening = 0.0, surface = 0.0, shapes = 0.0, stress = 0.0;
};

/// The header (sizes, interfaces, report) as read() gives it without parts, and the parts' sizes.
struct Contents {
  Superelement header;
  PartSizes bytes;
  bool stiffening_of_loads = false;  ///< its stiffening terms have those of the load cases
};

/// Throws what read() throws.  Read once as long as the file stays as it is (its size and the time it was written): scenes
/// of twenty equal bodies ask sixty times.
Contents contents(const std::filesystem::path& path);

}  // namespace flexura::superelement
