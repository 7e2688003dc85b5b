// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/mechanism.hpp"
#include "mbs/mechanism/mechanism_tangents.hpp"
#include "mbs/mechanism/motion/start_values.hpp"
#include "mbs/mechanism/outputs/quantities.hpp"

/// Private to the sources of Mechanism.
namespace flexura::mbs {

struct Mechanism::Joined : MechanismParts {
  explicit Joined(MechanismDescription description)
      : MechanismParts(std::move(description)),
        residual(*this),
        tangents(*this, residual),
        quantities(tree, rows, static_cast<int>(states.algebraic().size())),
        start(tree, kinematics, coordinates) {}

  Residual residual;
  MechanismTangents tangents;
  Quantities quantities;
  StartValues start;
};

}  // namespace flexura::mbs
