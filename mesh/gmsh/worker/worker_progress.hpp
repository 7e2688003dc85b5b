// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <unistd.h>

#include <string>

#include "mesh/gmsh/job.hpp"

namespace flexura::mesh {

/// From the child to whoever started it: how far it is (0 to 1) and at what.
inline void say(double fraction, const std::string& stage) {
  const std::string line = std::to_string(fraction) + "\t" + stage + "\n";
  if (write(kProgressDescriptor, line.data(), line.size()) < 0) return;  // nobody listens: no matter
}

}  // namespace flexura::mesh
