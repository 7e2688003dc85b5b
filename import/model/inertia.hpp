// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "import/model/mechanism.hpp"

/// Inertia tensors: whether a body can have one, the nearest that a body has, those of simple shapes.
namespace flexura::import {

/// A mass distribution has these moments about its centre of mass: none negative, none above the sum of the other two, by more
/// than rounding to three digits leaves (the rule of the mechanism file).
bool is_inertia(const Matrix3d& I);

/// The tensor of the same trace nearest to the symmetric `I` (in Frobenius' norm) that a body has.
///
/// With the trace 2 s the moments of a body are I_k = s - p_k, where p_k = integral of x_k^2 dm >= 0 and p_1 + p_2 + p_3 = s.  The
/// nearest tensor keeps the axes, and its p are the projection of s - I_k on that simplex (J. Duchi et al., ICML 2008, figure 1).
/// Throws std::invalid_argument where the trace is not positive: no such tensor is there.
Matrix3d nearest_inertia(const Matrix3d& I);

struct MassProperties {
  double mass = 0.0;
  Vector3d center = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();  ///< about the centre, axes of the frame

  /// Both together; masses must not be zero both.
  MassProperties operator+(const MassProperties& other) const;
  /// As seen from the frame in which this one's has the pose X.
  MassProperties in(const Pose& X) const;
};

/// Of solids of density 1 [kg, kg m^2], about their middle; cylinder and capsule along z.
MassProperties box_properties(const Vector3d& size);
MassProperties cylinder_properties(double radius, double length);
MassProperties sphere_properties(double radius);
/// `length` is that of the cylinder between the half spheres.
MassProperties capsule_properties(double radius, double length);
/// Of what a closed surface encloses, by tetrahedra over its triangles; turned inside out it has the same.
MassProperties surface_properties(const Surface& surface);

}  // namespace flexura::import
