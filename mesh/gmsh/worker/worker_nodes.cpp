// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/worker_nodes.hpp"

#include <gmsh.h>

namespace flexura::mesh {

NodeNumbers::NodeNumbers() {
  std::vector<std::size_t> tags;
  std::vector<double> parameters;
  gmsh::model::mesh::getNodes(tags, coordinates_, parameters, -1, -1, false, false);
  for (std::size_t k = 0; k < tags.size(); ++k) place_[tags[k]] = k;
}

}  // namespace flexura::mesh
