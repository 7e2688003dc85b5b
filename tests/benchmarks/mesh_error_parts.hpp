// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/benchmarks/mesh_truth.hpp"

/// The parts by which the estimate of the mesh's error is measured.
namespace flexura::reduce {

struct Subject {
  std::string name;
  std::function<Part()> coarse;
  Sequence fine;
  bool held_out = false;  ///< not seen when the estimate was made
};

std::vector<Subject> subjects();

/// In ten-node tetrahedra of a size [m].
Part crank_arm(double size);

}  // namespace flexura::reduce
