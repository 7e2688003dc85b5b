// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/outputs/quantities.hpp"
#include "mbs/mechanism/residual.hpp"

namespace flexura::mbs {

/// What a mechanism shows of one state: the signals, measures, loads and energies that its quantities are made of.
class MechanismOutputs {
 public:
  MechanismOutputs(const MechanismParts& parts, const Residual& residual)
      : m_(parts), residual_(residual), quantities_(parts.tree, parts.rows, parts.states.n_algebraic()) {}

  const Quantities& quantities() const { return quantities_; }
  /// As in Mechanism.
  void evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot, MechanismScratch& work,
                VectorRef values) const;

 private:
  /// Coordinates, speeds and inputs; `controlled` and their signals of the controls that (do not) feed through.
  void take_signals(const State& s, MechanismScratch& work) const;
  void take_controls(bool feed_through, MechanismScratch& work, std::vector<double>& controlled) const;
  /// The measures for which `wanted` is `now`.
  void take_measures(const std::vector<bool>& wanted, bool now, MechanismScratch& work,
                     std::vector<double>& measured) const;
  /// Measures of reactions, and formulas that read them: they come last.
  std::vector<bool> late_measures() const;

  const MechanismParts& m_;
  const Residual& residual_;
  Quantities quantities_;
};

}  // namespace flexura::mbs
