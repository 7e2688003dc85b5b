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

  void position(double t, ConstVectorRef p, MechanismScratch& work, VectorRef g) const;
  void velocity(double t, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work, VectorRef g_dot) const;
  void both(double t, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work, VectorRef g,
            VectorRef g_dot) const;
  void acceleration(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                    MechanismScratch& work, VectorRef g_ddot) const;
  void apply_GT(double t, ConstVectorRef p, ConstVectorRef x, MechanismScratch& work, VectorRef f_c) const;
  void matrix(double t, ConstVectorRef p, MechanismScratch& work, MatrixRef G) const;
  ConstraintSizes sizes(const std::vector<int>& rows, double t, ConstVectorRef p,
                        MechanismScratch& work) const;
  void left_out(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot, MechanismScratch& work,
                VectorRef g, VectorRef g_dot, VectorRef g_ddot) const;
  /// What says nothing new, among all rows, none of which is left out now; `whole` is the mechanism.
  Redundancy redundant(const Equations& whole, double t, ConstVectorRef p, MechanismScratch& work) const;

 private:
  void move(double t, ConstVectorRef p, MechanismScratch& work) const;

  const MechanismParts& m_;
};

}  // namespace flexura::mbs
