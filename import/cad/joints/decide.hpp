// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/cad/joints/propose.hpp"

namespace flexura::import::cad {

/// Degrees of freedom of the joints as they are now, and of each how many of its rows follow from those before it.
void count_again(const Assembly& assembly, Proposal& proposal);

/// Makes it a joint of that type by hand.  A fixed one has no axis: it gets that of the first bore or shaft that it sits on, or else
/// the normal of its first plane.
void change_type(const Assembly& assembly, ProposedJoint& joint, JointForm::Type type);

}  // namespace flexura::import::cad
