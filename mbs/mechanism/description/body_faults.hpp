// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>

#include "mbs/base/math/spatial.hpp"

/// What no body has, whether a file or a program in C++ gives it.
namespace flexura::mbs {

struct BodyFault {
  std::string key;  ///< mass, center or inertia
  std::string rule, remedy;
};

/// Of a mass [kg], its centre [m] and the inertia tensor about it [kg m^2].
std::optional<BodyFault> body_fault(double mass, const Vector3d& center, const Matrix3d& inertia);

/// Of a place: numbers that are finite, and a rotation; empty where it is one.
std::string pose_fault(const Pose& X);

}  // namespace flexura::mbs
