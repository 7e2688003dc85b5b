// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <utility>

#include "mbs/bodies/flexible_body.hpp"

namespace flexura::mbs {

/// What a flexible body that is not modal may know beside FlexibleBody: its derivatives in closed form.  Of others
/// they are central differences.
class OwnTangents {
 public:
  virtual ~OwnTangents() = default;
  /// FlexibleBody::deformation_tangents().
  virtual void own_deformation_tangents(const double* s, const double* s_dot, const double* s_ddot,
                                        const Spatial& V, const Spatial& A, FlexibleBody::Work& work,
                                        DeformationTangents& out) const = 0;
  /// The coordinates that move a node: [first, end) of s.
  virtual std::pair<int, int> coordinates_of(int node) const = 0;
};

}  // namespace flexura::mbs
