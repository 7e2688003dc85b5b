// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "reduce/assembly/input/part.hpp"

/// Point masses and links on nodes of the mesh and on interface nodes.
///
/// A rigid piece with mass m, mass centre x_c and moments of inertia J has the same inertia integrals as
/// six points: with the second moments C = tr(J)/2 1 - J = sum_i c_i e_i e_i^T, two points of mass m/6 at
/// x_c +- sqrt(3 c_i / m) e_i for each i.  These points join the set of a rigid tie, so that mass matrix,
/// inertia integrals and shapes are exact without a special case anywhere.
namespace flexura::reduce {

/// Adds a node to the mesh that follows the interface's rigid tie; returns its number.
mesh::Index add_tied_node(Part& part, int interface, const Eigen::Vector3d& x);

/// A mass on an interface node (`mass.node` is not read).  Throws std::invalid_argument for ties that are not
/// rigid and for moments of inertia that no body has (the greatest exceeds the sum of the others).
void add_mass_to_interface(Part& part, int interface, const PointMass& mass);

/// A mass on the reference node of an average (RBE3), interface or not: its points follow the mean motion of the set.  Throws
/// std::invalid_argument for masses that are not above zero and moments of inertia that no body has.
void add_mass_to_average(Part& part, const InterfaceSpec& average, const PointMass& mass);

/// A mass on a node of solid elements.  These have no rotations: offset and inertia must be zero
/// (std::invalid_argument).
void add_mass_to_node(Part& part, const PointMass& mass);

}  // namespace flexura::reduce
