// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "import/cad/joints/propose.hpp"

/// What proposed joints leave of the freedom of a whole assembly.
namespace flexura::import::cad {

/// Twists (w, v) that the form allows, about `centre` with lengths in units of `size`: 6 x k, none for forms that no joint has.
Eigen::MatrixXd twists_of(const JointForm& form, const Vector3d& centre, double size);

/// Degrees of freedom of all groups but `ground` under the joints, in this position: 6 for each less the rank of all joints'
/// rows; sets `redundant` of each joint to its rows that follow from those before it.  `group`: of each instance. Nothing
/// where the groups are too many to be counted.
std::optional<int> count_freedom(std::vector<ProposedJoint>& joints, const std::vector<int>& group,
                                 int ground, const Vector3d& centre, double size);

}  // namespace flexura::import::cad
