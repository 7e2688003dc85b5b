// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <vector>

#include "mbs/mechanism/dynamics/inverse_dynamics.hpp"
#include "mbs/mechanism/elements/constraint_rows.hpp"
#include "mbs/mechanism/elements/element_states.hpp"
#include "mbs/mechanism/outputs/quantity_list.hpp"

namespace flexura::mbs {

/// Everything of a mechanism that can be stored by name, and its values.
class Quantities {
 public:
  Quantities(const Topology& tree, const ConstraintRows& rows, int n_algebraic);

  std::vector<OutputInfo> infos() const;
  /// Those that are stored when the user does not say which.
  std::vector<int> usual() const;

  /// One state, with all loads taken inwards.
  struct Instant {
    Motion& motion;
    const Wrenches& wrenches;
    RowValues& rows;
    const Signals& signals;
    const std::vector<double>&measured, &controlled;  ///< of all measures and controls
    const EnergyReport& energies;
    // What only the mechanism as a whole knows.
    std::function<const double*(int body)> deformation;
    std::function<double(int input)> input;
    std::function<void(int force)> own_states;
    std::function<Vector6d()> momentum;
  };
  void evaluate(const std::vector<int>& which, const Instant& at, VectorRef values) const;

  /// Which of them redundant constraints leave open; see uniqueness.cpp.  After forward() on level position.
  std::vector<bool> not_unique(const InverseDynamics& dynamics, Motion& motion, Wrenches& wrenches,
                               RowValues& rows) const;
  /// What goes through a joint, on the body of M about Mo, in F.  After all loads are taken inwards.
  Vector6d joint_reaction(int joint, const Motion& motion, const Wrenches& wrenches,
                          const RowValues& rows) const;

 private:
  using Kind = Quantity::Kind;

  double drive_force(int joint, int coordinate, const RowValues& rows) const;

  const Topology& tree_;
  const ConstraintRows& rows_;
  std::vector<Quantity> all_;
};

}  // namespace flexura::mbs
