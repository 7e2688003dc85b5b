// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/residual.hpp"

namespace flexura::mbs {

/// The tangent matrices: inertia in closed form (inertia_tangents.cpp), then what elements add (element_tangents.cpp), then
/// differences of what does not differentiate itself.
class MechanismTangents {
 public:
  MechanismTangents(const MechanismParts& parts, const Residual& residual) : m_(parts), residual_(residual) {}

  /// As in Equations.
  void evaluate(const State& s, ConstVectorRef v_dot, TangentScope scope, MechanismScratch& work,
                TangentMatrices& out) const;

 private:
  void size(MechanismScratch& work) const;
  void difference_elements(const State& s, TangentScope scope, MechanismScratch& work,
                           TangentMatrices& out) const;
  void difference_following(const State& s, ConstVectorRef v_dot, MechanismScratch& work,
                            TangentMatrices& out) const;

  const MechanismParts& m_;
  const Residual& residual_;
};

}  // namespace flexura::mbs
