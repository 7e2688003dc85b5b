// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/parts.hpp"

namespace flexura::mbs {

/// The right-hand sides at one state: inverse dynamics less what elements and constraints apply, rates, energies.
class Residual {
 public:
  using Level = TreeMotion::Level;

  explicit Residual(const MechanismParts& parts) : m_(parts) {}

  /// forward() at the state's positions, and velocities from level velocity on; v_dot may be null below acceleration.
  void move(Level level, const State& s, const double* v_dot, MechanismScratch& work) const;
  /// After move(): states, and the signals that anything reads.
  void observe(const State& s, MechanismScratch& work) const;
  void take_states(const State& s, MechanismScratch& work) const;  ///< those alone
  /// To its velocities, states and signals.
  void move_and_observe(const State& s, MechanismScratch& work) const {
    move(Level::velocity, s, nullptr, work);
    observe(s, work);
  }

  // As in Equations.
  void momentum(const State& s, ConstVectorRef v_dot, MechanismScratch& work, VectorRef r, VectorRef c_rate,
                VectorRef b) const;
  void residuals(const State& s, ConstVectorRef v_dot, ConstVectorRef mu, MechanismScratch& work, VectorRef r,
                 VectorRef c_rate, VectorRef b, VectorRef g_dot, VectorRef g, VectorRef GT_mu) const;

  /// What forces, controls and constraints contribute, after observe().
  void element_loads(const State& s, Which which, VectorRef c_rate, VectorRef b,
                     MechanismScratch& work) const;
  /// After observe() and InverseDynamics::set_deformations().
  EnergyReport energies(const double* lambda, MechanismScratch& work) const;

 private:
  void finish(const State& s, MechanismScratch& work, VectorRef r, VectorRef c_rate, VectorRef b) const;
  void coupled_equations(MechanismScratch& work, VectorRef b) const;

  const MechanismParts& m_;
};

}  // namespace flexura::mbs
