// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "reduce/beams/numbering.hpp"

namespace flexura::reduce {

/// Loads that act together.
struct LoadCase {
  std::string name;
  std::vector<std::pair<int, beam::Vector6d>>
      nodal;  ///< node of the beam model; force and moment in B [N, N m]
  std::vector<beam::MemberLoad> members;
  std::vector<std::pair<int, double>> preloads;  ///< member, and its tension with both ends held [N]
};

/// The tension that the case's preloads give a member with its ends held [N].
double preload_of(const LoadCase& loads, int member);

/// Nodal loads (n_dofs) of a case: with those of line loads the nodal displacements of any mesh are exact.
Eigen::VectorXd load_vector(const Structure& structure, const LoadCase& loads);

/// K u = p with the interfaces held in the directions they keep: n_dofs x cases.  Needs a linalg::Session.
/// Throws like reduce_beams.
Eigen::MatrixXd static_displacements(const Structure& structure, const std::vector<BeamInterface>& held,
                                     const std::vector<LoadCase>& cases);

}  // namespace flexura::reduce
