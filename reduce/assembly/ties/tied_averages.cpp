// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/ties/tied_averages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "reduce/assembly/input/average.hpp"
#include "reduce/assembly/ties/tied_codes.hpp"

namespace flexura::reduce {

TiedAverages::TiedAverages(const Part& part, const TiedNumbering& numbering)
    : maps_(static_cast<std::size_t>(numbering.n_interfaces())) {
  std::vector<Eigen::Triplet<double>> A;
  for (int k = 0; k < numbering.n_interfaces(); ++k) {
    const InterfaceDofs& interface = numbering.interfaces()[k];
    if (interface.tie != Tie::average) continue;
    InterfaceSpec used = part.interfaces[k];
    if (!used.weights.empty()) {  // of the nodes that belong to cells
      std::vector<double> weights;
      for (std::size_t a = 0; a < used.set.nodes.size(); ++a)
        if (std::binary_search(interface.nodes.begin(), interface.nodes.end(), used.set.nodes[a]))
          weights.push_back(used.weights[a]);
      used.weights = std::move(weights);
    }
    used.set.nodes = interface.nodes;
    Map& average = maps_[k];
    average = averaging_map(part.mesh, used);
    for (int direction : interface.directions) {
      const int row = static_cast<int>(dofs_.size());
      dofs_.push_back(boundary_of(interface.code[direction]));
      for (std::size_t a = 0; a < interface.nodes.size(); ++a)
        numbering.each_dof(interface.nodes[a], [&](int code, const Eigen::Vector3d& C) {
          if (code < 0)
            throw std::invalid_argument(fmt::format(
                "interface '{}' is the mean of nodes of which node {} is bound to another interface: choose "
                "interfaces that "
                "constraints do not join",
                used.name, numbering.label_of(interface.nodes[a])));
          A.emplace_back(row, code,
                         average.row(direction).segment<3>(3 * static_cast<Eigen::Index>(a)).dot(C));
        });
    }
  }
  A_.resize(static_cast<Eigen::Index>(dofs_.size()), numbering.n_i());
  A_.setFromTriplets(A.begin(), A.end());
}

}  // namespace flexura::reduce
