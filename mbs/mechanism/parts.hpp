// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/dynamics/inverse_dynamics.hpp"
#include "mbs/mechanism/dynamics/mass_matrix.hpp"
#include "mbs/mechanism/elements/constraint_rows.hpp"
#include "mbs/mechanism/elements/element_states.hpp"
#include "mbs/mechanism/elements/followed_signals.hpp"
#include "mbs/mechanism/motion/tree_motion.hpp"
#include "mbs/mechanism/tangents/element_tangents.hpp"
#include "mbs/mechanism/tangents/inertia_tangents.hpp"
#include "mbs/mechanism/tangents/mode_tangents.hpp"
#include "mbs/mechanism/topology/coordinates.hpp"
#include "mbs/mechanism/topology/topology.hpp"

/// What a mechanism is joined of, and the scratch of them all.
namespace flexura::mbs {

struct MechanismParts {
  explicit MechanismParts(MechanismDescription description)
      : tree(std::move(description)),
        coordinates(tree),
        kinematics(tree),
        dynamics(tree),
        mass(tree),
        states(tree),
        rows(tree),
        followed(tree, states, rows),
        inertia(tree),
        modes(tree) {}

  Topology tree;
  Coordinates coordinates;
  TreeMotion kinematics;
  InverseDynamics dynamics;
  MassMatrix mass;
  ElementStates states;
  ConstraintRows rows;
  FollowedSignals followed;
  InertiaTangents inertia;
  ModeTangents modes;

  int n_algebraic() const { return states.n_algebraic() + static_cast<int>(rows.contacts().size()); }
};

struct MechanismScratch final : Equations::Scratch {
  explicit MechanismScratch(const MechanismParts& parts) {
    parts.kinematics.size(motion);
    parts.dynamics.size(wrenches);
    parts.mass.size(inertias);
    parts.states.size(static_cast<int>(parts.rows.contacts().size()), signals);
    parts.rows.size(rows);
    parts.followed.size(rows.followed);
  }

  Motion motion;
  Wrenches wrenches;
  Inertias inertias;
  Signals signals;
  RowValues rows;
  /// At the first tangents(): most scratches never see one.
  struct Tangents {
    InertiaVariations inertia;
    ElementVariations elements;
    State moved;
    Eigen::VectorXd z, z_plus, h, h_plus, step;  ///< z as in TangentMatrices
  };
  std::unique_ptr<Tangents> tangents;
};

}  // namespace flexura::mbs
