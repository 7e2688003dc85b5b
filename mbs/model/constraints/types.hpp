// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/model/constraint.hpp"
#include "mbs/model/forces/types.hpp"

/// The types of constraints beside the joints: listed here and in registry.cpp.
namespace flexura::mbs {

const std::vector<ConstraintType>& constraint_types();

ConstraintType point_on_line_constraint();
ConstraintType point_on_plane_constraint();
ConstraintType point_on_curve_constraint();
ConstraintType orientation_constraint();
ConstraintType parallel_constraint();
ConstraintType perpendicular_constraint();
ConstraintType distance_constraint();
ConstraintType coupler_constraint();
ConstraintType gear_constraint();
ConstraintType rack_and_pinion_constraint();
ConstraintType rolling_disc_constraint();

}  // namespace flexura::mbs
