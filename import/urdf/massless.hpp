// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/urdf/draw.hpp"

namespace flexura::import::urdf {

/// Gives links inertia, or joints a drive, or fixes those that move nothing apart from the joints before them, until none moves by itself what has no inertia (`choices.massless`): each is a repair, or a
/// fault where that is to be refused.
void treat_massless(Robot& robot, std::vector<double>& q, const Choices& choices, Drawer& drawer,
                    Findings& findings);

}  // namespace flexura::import::urdf
