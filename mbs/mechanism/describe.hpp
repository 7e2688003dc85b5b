// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

/// A mechanism's quantities by pattern, and its connections for pictures.
namespace flexura::mbs {

/// What a run's own account adds to Mechanism::quantities(): energy.input, energy.dissipated, energy.balance.
/// They are stored with every run, whatever is asked for.
const std::vector<OutputInfo>& run_quantities();

/// The SI unit of a quantity: joules of an energy, which has the dimension of a torque; "" of a plain number.
std::string unit_of(const OutputInfo& quantity);

/// Indices of the wanted quantities, in the order of the patterns; the usual ones for no patterns.
/// Patterns may also fit run_quantities(), which are not among them.
/// Throws std::invalid_argument for a pattern that fits nothing ("did you mean ...?").
std::vector<int> select_quantities(const Mechanism& mechanism, const std::vector<std::string>& patterns);

/// Joints and forces with the bodies they join, as JSON for pictures: [{"name", "kind", "body_1", "p_1",
/// "body_2", "p_2", "axis_1"}, ...]; points in the bodies' frames, undeformed.
std::string connections_json(const Mechanism& mechanism);

}  // namespace flexura::mbs
