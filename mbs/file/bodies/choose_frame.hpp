// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/base/documents/document.hpp"
#include "mbs/bodies/body_node.hpp"
#include "mbs/bodies/modal_basis.hpp"
#include "mbs/mechanism/acting_loads.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/superelement/superelement.hpp"

namespace flexura::mbs {

/// The body's frame and the boundary condition of its eigenmodes, by the keys `frame` and `boundary` and by the joints on
/// it: sets `held`, `frame` and `fixed_interface` of the options.  What was asked for is told in `notes`; returns the
/// sentence on a boundary condition that nobody asked for, for where it counts.  Throws InputError.
std::string choose_frame(const input::Section& s, const superelement::Superelement& se,
                         const BodyNodes& nodes, const std::vector<BodyNode>& linked,
                         const MechanismDescription& d, int body, BasisOptions& options,
                         std::vector<std::string>& notes);

}  // namespace flexura::mbs
