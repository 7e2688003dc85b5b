// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/solver/position/assemble.hpp"

/// Initial values of the elastic coordinates s from which no vibration starts: the deformation that follows
/// the loads of the motion as if without inertia of its own,
///
///     0 = (M v' - f + G^T lambda)_s   at s'' = 0,      s' = ds/dt along the motion,
///
/// with v' of the other coordinates and lambda those of the motion at s'' = 0.  What is left is of second
/// order in the ratio of the motion's rates to the natural frequencies.
///
/// Combinations N^T g of constraint rows that the rigid motion meets whatever it does (out of the plane of a
/// planar loop; all of them where a body is held at both ends) are met by deformation: with C = N^T G_s,
///
///     K ds + C^T dnu = -r_s,      C ds = -N^T g,      lambda += N dnu,
///
/// and the motion itself is found with the other combinations alone.  K is the bodies' own stiffness; where
/// that does not converge (a beam that spins fast, a tight wire, a cable: the loads change with the deformation by more
/// than the body resists), dr_s/ds by differences, with steps that lead downhill (algebra/downhill.hpp).
namespace flexura::mbs {

/// Moves the elastic coordinates (Equations::elastic_coordinate) of the assembled state s and their rates
/// there, closes the loops by the other coordinates, and gives consistent v_dot, lambda.  `keep` as for
/// assemble(). Returns the number of iterations.  Throws AssemblyError where the iteration does not
/// converge.
int start_quasi_static(const Equations& eq, State& s, Eigen::VectorXd& v_dot,
                       const AssembleOptions& keep = {});

}  // namespace flexura::mbs
