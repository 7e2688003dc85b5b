// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/constraint_equations.hpp"

namespace flexura::mbs {

void ConstraintEquations::move(double t, ConstVectorRef p, MechanismScratch& work) const {
  m_.kinematics.forward(Level::position, t, p.data(), nullptr, nullptr, work.motion);
}

void ConstraintEquations::position(double t, ConstVectorRef p, MechanismScratch& work, VectorRef g) const {
  move(t, p, work);
  m_.rows.position(work.motion, work.rows, g);
}

void ConstraintEquations::velocity(double t, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work,
                                   VectorRef g_dot) const {
  m_.kinematics.forward(Level::velocity, t, p.data(), v.data(), nullptr, work.motion);
  m_.rows.velocity(work.motion, work.rows, g_dot);
}

void ConstraintEquations::both(double t, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work,
                               VectorRef g, VectorRef g_dot) const {
  m_.kinematics.forward(Level::velocity, t, p.data(), v.data(), nullptr, work.motion);
  m_.rows.position(work.motion, work.rows, g);
  m_.rows.velocity(work.motion, work.rows, g_dot);
}

void ConstraintEquations::acceleration(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                       MechanismScratch& work, VectorRef g_ddot) const {
  m_.kinematics.forward(Level::acceleration, t, p.data(), v.data(), v_dot.data(), work.motion);
  m_.rows.acceleration(work.motion, work.rows, g_ddot);
}

void ConstraintEquations::apply_GT(double t, ConstVectorRef p, ConstVectorRef x, MechanismScratch& work,
                                   VectorRef f_c) const {
  move(t, p, work);
  m_.dynamics.clear_loads(work.wrenches);
  BodyLoads loads(m_.tree, work.motion, work.wrenches, -1.0);
  m_.rows.add_constraint_loads(x.data(), Which::all, work.motion, work.rows, loads);
  m_.dynamics.backward(work.motion, work.wrenches, f_c.data());
}

void ConstraintEquations::matrix(double t, ConstVectorRef p, MechanismScratch& work, MatrixRef G) const {
  move(t, p, work);
  const auto& constraints = m_.rows.constraints();
  const std::vector<int>& kept = m_.rows.kept();
  BodyLoads loads(m_.tree, work.motion, work.wrenches, -1.0);
  std::size_t i = 0;
  // Row by row: the loads of a unit multiplier, taken inwards.
  for (std::size_t k = 0; k < constraints.size(); ++k) {
    m_.rows.own_contact(k, work.motion, work.rows);
    const int first = m_.rows.first_row(k);
    for (; i < kept.size() && kept[i] < m_.rows.first_row(k + 1); ++i) {
      m_.dynamics.clear_loads(work.wrenches);
      work.rows.x.segment(first, constraints[k]->n_rows()).setZero();
      work.rows.x(kept[i]) = 1.0;
      constraints[k]->apply_GT(work.motion.kin, work.rows.x.data() + first, loads);
      m_.dynamics.backward(work.motion, work.wrenches, work.wrenches.r.data());
      G.row(static_cast<Eigen::Index>(i)) = work.wrenches.r.head(m_.tree.n_v).transpose();
    }
  }
}

ConstraintSizes ConstraintEquations::sizes(const std::vector<int>& rows, double t, ConstVectorRef p,
                                           MechanismScratch& work) const {
  move(t, p, work);
  return m_.rows.sizes(rows, m_.kinematics.extent(work.motion), work.motion, work.rows);
}

void ConstraintEquations::left_out(double t, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                   MechanismScratch& work, VectorRef g, VectorRef g_dot,
                                   VectorRef g_ddot) const {
  if (m_.rows.left_out().empty()) return;
  const bool to_acceleration = v_dot.size() > 0;
  m_.kinematics.forward(to_acceleration ? Level::acceleration : Level::velocity, t, p.data(), v.data(),
                        v_dot.data(), work.motion);
  m_.rows.left_out_constraints(to_acceleration, work.motion, work.rows, g, g_dot, g_ddot);
}

Redundancy ConstraintEquations::redundant(const Equations& whole, double t, ConstVectorRef p,
                                          MechanismScratch& work) const {
  if (m_.tree.n_v == 0) {
    Redundancy found;
    found.left_out = m_.rows.kept();
    found.follows_from.resize(found.left_out.size());
    return found;
  }
  move(t, p, work);
  std::vector<bool> of_positions, lasts;
  m_.rows.list_kinds(work.motion, work.rows, of_positions, lasts);
  return find_redundancy(whole, t, p, m_.coordinates.kinematic_scale(m_.kinematics.extent(work.motion)),
                         of_positions, lasts);
}

}  // namespace flexura::mbs
