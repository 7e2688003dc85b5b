// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/constraint_equations.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "mbs/mechanism/mechanism_outputs.hpp"
#include "mbs/mechanism/mechanism_tangents.hpp"
#include "mbs/mechanism/motion/start_values.hpp"

/// Private to the sources of Mechanism.
namespace flexura::mbs {

struct Mechanism::Joined : MechanismParts {
  explicit Joined(MechanismDescription description)
      : MechanismParts(std::move(description)),
        residual(*this),
        tangents(*this, residual),
        outputs(*this, residual),
        constraints(*this),
        start(tree, kinematics, coordinates) {}

  Residual residual;
  MechanismTangents tangents;
  MechanismOutputs outputs;
  ConstraintEquations constraints;
  StartValues start;
};

}  // namespace flexura::mbs
