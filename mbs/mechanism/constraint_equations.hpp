// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/mechanism/parts.hpp"
#include "mbs/mechanism/redundancy.hpp"

namespace flexura::mbs {

/// The constraint rows of a mechanism at a time and a configuration, as in Equations: a sweep outwards to the level that is
/// needed, then the rows.
class ConstraintEquations {
 public:
  using Level = TreeMotion::Level;

  explicit ConstraintEquations(const MechanismParts& parts) : m_(parts) {}

  /// What all of them do first: positions and what rows follow.
  void move(When when, ConstVectorRef p, MechanismScratch& work) const;
  /// Coordinates in the tree where drives by states want them: where the assembly begins.
  void start_followed(State& s, const std::vector<bool>& given_v, MechanismScratch& work) const;
  void position(When when, ConstVectorRef p, MechanismScratch& work, VectorRef g) const;
  void velocity(When when, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work, VectorRef g_dot) const;
  void both(When when, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work, VectorRef g,
            VectorRef g_dot) const;
  void acceleration(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                    MechanismScratch& work, VectorRef g_ddot) const;
  void apply_GT(When when, ConstVectorRef p, ConstVectorRef x, MechanismScratch& work, VectorRef f_c) const;
  void matrix(When when, ConstVectorRef p, MechanismScratch& work, MatrixRef G) const;
  ConstraintSizes sizes(const std::vector<int>& rows, When when, ConstVectorRef p,
                        MechanismScratch& work) const;
  void left_out(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot, MechanismScratch& work,
                VectorRef g, VectorRef g_dot, VectorRef g_ddot) const;
  /// What says nothing new, among all rows, none of which is left out now; `whole` is the mechanism.
  Redundancy redundant(const Equations& whole, When when, ConstVectorRef p, MechanismScratch& work) const;

 private:
  /// After forward() on this level: what rows follow.
  void follow(Level level, When when, MechanismScratch& work) const;

  const MechanismParts& m_;
};

}  // namespace flexura::mbs
