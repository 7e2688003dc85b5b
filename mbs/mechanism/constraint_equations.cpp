// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/constraint_equations.hpp"

#include "mbs/mechanism/motion/start_values.hpp"

namespace flexura::mbs {

void ConstraintEquations::move(When when, ConstVectorRef p, MechanismScratch& work) const {
  m_.kinematics.forward(Level::position, when.t, p.data(), nullptr, nullptr, work.motion);
  follow(Level::position, when, work);
}

void ConstraintEquations::follow(Level level, When when, MechanismScratch& work) const {
  if (!m_.followed.any()) return;
  if (!when.s) throw std::logic_error("rows that follow states are asked for without them");
  m_.states.take_states(*when.s, work.motion, work.signals);
  if (level != Level::position) m_.states.evaluate_signals(work.motion, work.signals);
  m_.followed.evaluate(level, work.motion, work.signals, work.rows);
}

void ConstraintEquations::start_followed(State& s, const std::vector<bool>& given_v,
                                         MechanismScratch& work) const {
  // Where its drive wants it, with its speed; false of a follower that is no rotation.
  const auto puts_rotation = [&](const FollowedSignals::Follower& follower, const JointPlace& place) {
    const auto* rotation =
        dynamic_cast<const RotationDrive*>(m_.rows.constraints()[follower.constraint].get());
    if (!rotation) return false;
    m_.rows.own_contact(follower.constraint, work.motion, work.rows);
    put_rotation(rotation->wanted(work.motion.kin), place, s.p, s.v);
    return true;
  };
  move(s, s.p, work);
  for (const FollowedSignals::Follower& follower : m_.followed.followers()) {
    const RowPlace row = m_.rows.place_of_row(m_.rows.first_row(follower.constraint));
    if (row.driven < 0 || follower.what.level != DriveLevel::position) continue;
    const JointDescription& joint = m_.tree.d.joints[static_cast<std::size_t>(row.joint)];
    const JointPlace& place = m_.tree.places[static_cast<std::size_t>(row.joint)];
    if (!place.in_tree() || puts_rotation(follower, place)) continue;
    s.p(place.i_p + joint.coordinate_of_speed(row.driven)) =
        work.rows.followed.of_constraints[follower.place].value;
  }
  // Its speed, too, as of drives by time: left at rest it would set off by a blow that the rest of the mechanism feels.
  m_.kinematics.forward(Level::velocity, s.t, s.p.data(), s.v.data(), nullptr, work.motion);
  follow(Level::velocity, s, work);
  for (const FollowedSignals::Follower& follower : m_.followed.followers()) {
    const RowPlace row = m_.rows.place_of_row(m_.rows.first_row(follower.constraint));
    if (row.driven < 0 || follower.what.level == DriveLevel::acceleration) continue;
    const JointPlace& place = m_.tree.places[static_cast<std::size_t>(row.joint)];
    if (!place.in_tree() || puts_rotation(follower, place)) continue;
    const int speed = place.i_v + row.driven;
    if (given_v[static_cast<std::size_t>(speed)]) continue;
    const Jet& y = work.rows.followed.of_constraints[follower.place];
    s.v(speed) = follower.what.level == DriveLevel::position ? y.first : y.value;
  }
}

void ConstraintEquations::position(When when, ConstVectorRef p, MechanismScratch& work, VectorRef g) const {
  move(when, p, work);
  m_.rows.position(work.motion, work.rows, g);
}

void ConstraintEquations::velocity(When when, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work,
                                   VectorRef g_dot) const {
  m_.kinematics.forward(Level::velocity, when.t, p.data(), v.data(), nullptr, work.motion);
  follow(Level::velocity, when, work);
  m_.rows.velocity(work.motion, work.rows, g_dot);
}

void ConstraintEquations::both(When when, ConstVectorRef p, ConstVectorRef v, MechanismScratch& work,
                               VectorRef g, VectorRef g_dot) const {
  m_.kinematics.forward(Level::velocity, when.t, p.data(), v.data(), nullptr, work.motion);
  follow(Level::velocity, when, work);
  m_.rows.position(work.motion, work.rows, g);
  m_.rows.velocity(work.motion, work.rows, g_dot);
}

void ConstraintEquations::acceleration(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                       MechanismScratch& work, VectorRef g_ddot) const {
  m_.kinematics.forward(Level::acceleration, when.t, p.data(), v.data(), v_dot.data(), work.motion);
  follow(Level::acceleration, when, work);
  m_.rows.acceleration(work.motion, work.rows, g_ddot);
}

void ConstraintEquations::apply_GT(When when, ConstVectorRef p, ConstVectorRef x, MechanismScratch& work,
                                   VectorRef f_c) const {
  move(when, p, work);
  m_.dynamics.clear_loads(work.wrenches);
  BodyLoads loads(m_.tree, work.motion, work.wrenches, -1.0);
  m_.rows.add_constraint_loads(x.data(), Which::all, work.motion, work.rows, loads);
  m_.dynamics.backward(work.motion, work.wrenches, f_c.data());
}

void ConstraintEquations::matrix(When when, ConstVectorRef p, MechanismScratch& work, MatrixRef G) const {
  move(when, p, work);
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

ConstraintSizes ConstraintEquations::sizes(const std::vector<int>& rows, When when, ConstVectorRef p,
                                           MechanismScratch& work) const {
  move(when, p, work);
  return m_.rows.sizes(rows, m_.kinematics.extent(work.motion), work.motion, work.rows);
}

void ConstraintEquations::left_out(When when, ConstVectorRef p, ConstVectorRef v, ConstVectorRef v_dot,
                                   MechanismScratch& work, VectorRef g, VectorRef g_dot,
                                   VectorRef g_ddot) const {
  if (m_.rows.left_out().empty()) return;
  const bool to_acceleration = v_dot.size() > 0;
  const Level level = to_acceleration ? Level::acceleration : Level::velocity;
  m_.kinematics.forward(level, when.t, p.data(), v.data(), v_dot.data(), work.motion);
  follow(level, when, work);
  m_.rows.left_out_constraints(to_acceleration, work.motion, work.rows, g, g_dot, g_ddot);
}

Redundancy ConstraintEquations::redundant(const Equations& whole, When when, ConstVectorRef p,
                                          MechanismScratch& work) const {
  if (m_.tree.n_v == 0) {
    Redundancy found;
    found.left_out = m_.rows.kept();
    found.follows_from.resize(found.left_out.size());
    return found;
  }
  move(when, p, work);
  std::vector<bool> of_positions, lasts, is_modal(static_cast<std::size_t>(m_.tree.n_v), false);
  for (const int b : m_.tree.order)
    if (const FlexibleBody* const body = m_.tree.flexible(b); body && body->modal())
      std::fill_n(is_modal.begin() + m_.tree.bodies[b].i_v, m_.tree.bodies[b].m, true);
  m_.rows.list_kinds(work.motion, work.rows, of_positions, lasts);
  return find_redundancy(whole, when, p, m_.coordinates.kinematic_scale(m_.kinematics.extent(work.motion)),
                         is_modal, of_positions, lasts);
}

}  // namespace flexura::mbs
