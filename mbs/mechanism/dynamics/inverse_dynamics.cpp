// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/dynamics/inverse_dynamics.hpp"

#include <Eigen/LU>

namespace flexura::mbs {
namespace {

// Not so where a component is no number.
bool is_zero(const Spatial& x) {
  return (x.angular.array() == 0.0).all() && (x.linear.array() == 0.0).all();
}

}  // namespace

void InverseDynamics::size(Wrenches& wrenches) const {
  wrenches.bodies.resize(tree_.d.bodies.size());
  for (int b : tree_.order) {
    if (const FlexibleBody* flexible = tree_.flexible(b))
      wrenches.bodies[b].flexible = flexible->make_scratch();
    if (tree_.bodies[b].i_c >= 0) wrenches.bodies[b].no_acceleration.setZero(tree_.bodies[b].n_need);
  }
  wrenches.r.setZero(tree_.n_need);
  wrenches.on_marker.resize(tree_.d.markers.size());
}

// The inertia of deformed bodies, after forward(); what asks for positions and velocities alone does without.
void InverseDynamics::set_deformations(const Motion& motion, Wrenches& wrenches) const {
  for (int b : tree_.order)
    if (tree_.bodies[b].m > 0)
      tree_.d.bodies[b].flexible->set_position(motion.kin.p + tree_.bodies[b].i_p,
                                               *wrenches.bodies[b].flexible);
}

void InverseDynamics::clear_loads(Wrenches& wrenches) const {
  for (Wrenches::Body& body : wrenches.bodies) body.F = {};
  wrenches.r.setZero();
}

void InverseDynamics::body_forces(const Motion& motion, Wrenches& wrenches) const {
  const Vector3d& g = tree_.d.gravity;
  wrenches.r.setZero();
  wrenches.bodies[0].F = {};
  for (int b : tree_.order) {
    const Motion::Body& moves = motion.bodies[b];
    Wrenches::Body& body = wrenches.bodies[b];
    const BodyDescription& description = tree_.d.bodies[b];
    const Matrix3d& R = moves.X_WB.R;
    const Spatial V = R.transpose() * moves.V;
    const Spatial A = R.transpose() * Spatial{moves.A.angular, moves.A.linear - g};
    Spatial need;
    const TreeBody& t = tree_.bodies[b];
    if (t.m > 0) {
      if (description.flexible->moves_by_integrals())
        description.flexible->set_position(motion.kin.p + t.i_p, *body.flexible);
      need = description.flexible->inverse_dynamics(motion.kin.p + t.i_p, motion.kin.v + t.i_v,
                                                    motion.kin.v_dot + t.i_v, V, A, *body.flexible,
                                                    wrenches.r.data() + t.i_v);
    } else {
      const RigidInertia& I = description.inertia;
      const Vector3d &w = V.angular, &d = I.mass_center;
      need.linear = I.mass * A.linear + A.angular.cross(d) + w.cross(w.cross(d));
      need.angular = d.cross(A.linear) + I.inertia * A.angular + w.cross(I.inertia * w);
      if (t.i_c >= 0) following_need(b, V, A, motion, wrenches);
    }
    body.F = R * need;
  }
}

void InverseDynamics::backward(const Motion& motion, Wrenches& wrenches, double* r_out) const {
  Eigen::Map<Eigen::VectorXd> r(r_out, tree_.n_v);
  for (auto it = tree_.order.rbegin(); it != tree_.order.rend(); ++it) {
    const TreeBody& t = tree_.bodies[*it];
    const Motion::Body& moves = motion.bodies[*it];
    Wrenches::Body& body = wrenches.bodies[*it];
    // The loads of one row of constraints reach the bodies of its loop alone: with many loops that is what
    // ConstraintEquations::matrix() costs.
    if (is_zero(body.F)) {
      body.through_joint = {};
      continue;
    }
    const Pose& in = motion.kin.markers[t.marker_in].X_WP;
    const Pose& out = motion.kin.markers[t.marker_out].X_WP;
    body.through_joint = shift_wrench(body.F, moves.X_WB.p - out.p);
    if (tree_.on_node[t.marker_out]) {
      const Vector6d f = (moves.X_WB.R.transpose() * body.through_joint).vector();
      wrenches.r.segment(t.i_need, t.n_need).noalias() -= motion.local[t.marker_out].node.map.transpose() * f;
    }
    const Vector6d along = (in.R.transpose() * body.through_joint).vector();
    const int i_v = tree_.places[t.joint].i_v;
    for (int i = 0; i < moves.S.cols(); ++i) wrenches.r(i_v + i) += moves.S.col(i).dot(along);

    const Spatial at_in = shift_wrench(body.through_joint, out.p - in.p);
    const Pose& X_W_parent = motion.bodies[t.parent].X_WB;
    if (tree_.on_node[t.marker_in]) {
      const TreeBody& tp = tree_.bodies[t.parent];
      const Vector6d f = (X_W_parent.R.transpose() * at_in).vector();
      wrenches.r.segment(tp.i_need, tp.n_need).noalias() +=
          motion.local[t.marker_in].node.map.transpose() * f;
    }
    wrenches.bodies[t.parent].F += shift_wrench(at_in, in.p - X_W_parent.p);
  }
  r = wrenches.r.head(tree_.n_v);
}

void InverseDynamics::following_need(int b, const Spatial& V, const Spatial& A, const Motion& motion,
                                     Wrenches& wrenches) const {
  const FlexibleBody& flexible = *tree_.d.bodies[b].flexible;
  const TreeBody& t = tree_.bodies[b];
  Wrenches::Body& body = wrenches.bodies[b];
  const double* s = motion.kin.c + t.i_c;
  flexible.set_position(s, *body.flexible);
  flexible.inverse_dynamics(s, s + t.n_need, body.no_acceleration.data(), V, A, *body.flexible,
                            wrenches.r.data() + t.i_need);
}

void InverseDynamics::following_rates(const Motion& motion, const Wrenches& wrenches, double* c_rate) const {
  for (int b : tree_.order) {
    const TreeBody& t = tree_.bodies[b];
    if (t.i_c < 0) continue;
    const int m = t.n_need, i = t.i_c;
    for (int k = 0; k < m; ++k) {
      c_rate[i + k] = motion.kin.c[i + m + k];
      c_rate[i + m + k] = -wrenches.r(t.i_need + k);
    }
  }
}

void InverseDynamics::add_energies(const Motion& motion, const Wrenches& wrenches,
                                   EnergyReport& report) const {
  for (int b : tree_.order) {
    const BodyDescription& description = tree_.d.bodies[b];
    const Motion::Body& body = motion.bodies[b];
    const Spatial V = body.X_WB.R.transpose() * body.V;
    double mass;
    Vector3d first_moment;
    if (const TreeBody& t = tree_.bodies[b]; t.m > 0) {
      const FlexibleBody& flexible = *description.flexible;
      mass = flexible.mass();
      first_moment = wrenches.bodies[b].flexible->d;
      report.kinetic += flexible.kinetic_energy(motion.kin.v + t.i_v, V, *wrenches.bodies[b].flexible);
      report.strain += flexible.strain_energy(motion.kin.p + t.i_p);
      report.dissipated_power += flexible.dissipated_power(motion.kin.p + t.i_p, motion.kin.v + t.i_v);
    } else {
      const RigidInertia& I = description.inertia;
      mass = I.mass;
      first_moment = I.mass_center;
      report.kinetic += 0.5 * I.mass * V.linear.squaredNorm() + V.linear.dot(V.angular.cross(I.mass_center)) +
                        0.5 * V.angular.dot(I.inertia * V.angular);
    }
    report.potential -= tree_.d.gravity.dot(mass * body.X_WB.p + body.X_WB.R * first_moment);
  }
}

// A body's in its own frame are M_rr V + M_rf s', M the mass matrix of its floating frame.
Vector6d InverseDynamics::total_momentum(const Motion& motion, const Wrenches& wrenches) const {
  Spatial total;
  for (int b : tree_.order) {
    const BodyDescription& description = tree_.d.bodies[b];
    const Motion::Body& body = motion.bodies[b];
    const Spatial V = body.X_WB.R.transpose() * body.V;
    Spatial of_body;  // about Bo, in B
    if (tree_.bodies[b].m > 0) {
      const FlexibleBody::Scratch& f = *wrenches.bodies[b].flexible;
      const Eigen::Map<const Eigen::VectorXd> s_dot(motion.kin.v + tree_.bodies[b].i_v, tree_.bodies[b].m);
      of_body.linear = description.flexible->mass() * V.linear + V.angular.cross(f.d) + f.C_t * s_dot;
      of_body.angular = f.d.cross(V.linear) + f.J * V.angular + f.C_r * s_dot;
    } else {
      const RigidInertia& I = description.inertia;
      of_body.linear = I.mass * V.linear + V.angular.cross(I.mass_center);
      of_body.angular = I.mass_center.cross(V.linear) + I.inertia * V.angular;
    }
    const Spatial in_W = body.X_WB.R * of_body;
    total += {in_W.angular + body.X_WB.p.cross(in_W.linear), in_W.linear};
  }
  return total.vector();
}

void BodyLoads::apply(int marker, const Spatial& wrench_W) {
  const MarkerDescription& description = tree_.d.markers[marker];
  if (description.body == 0) return;
  const Pose& X_WB = motion_.bodies[description.body].X_WB;
  Spatial& F = wrenches_.bodies[description.body].F;
  const Spatial about_Bo = shift_wrench(wrench_W, motion_.kin.markers[marker].X_WP.p - X_WB.p);
  F.angular -= factor_ * about_Bo.angular;
  F.linear -= factor_ * about_Bo.linear;
  if (tree_.on_node[marker]) {
    const TreeBody& t = tree_.bodies[description.body];
    const Vector6d f = factor_ * (X_WB.R.transpose() * wrench_W).vector();
    wrenches_.r.segment(t.i_need, t.n_need).noalias() -= motion_.local[marker].node.map.transpose() * f;
    Spatial& load = wrenches_.on_marker[marker];
    load.angular += factor_ * wrench_W.angular;
    load.linear += factor_ * wrench_W.linear;
  }
}

void BodyLoads::apply(CoordinateRef c, double force) {
  const JointPlace& place = tree_.places[c.joint];
  if (place.in_tree()) {
    wrenches_.r(place.i_v + c.index) -= factor_ * force;
    return;
  }
  // The wrench in the span of S that works on this speed alone: S (S^T S)^-1 e.
  double q[7];
  place.joint->coordinates_of(motion_.kin.relative_pose(place.marker_F, place.marker_M), q);
  MotionMatrix S(6, place.joint->n_v());
  place.joint->motion(q, S);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> gram = S.transpose() * S;
  const Vector6d wrench = S * gram.inverse().col(c.index) * force;
  if (!wrenches_.on_closure.empty()) wrenches_.on_closure[c.joint] += factor_ * wrench;
  apply_between(motion_.kin, place.marker_F, place.marker_M, wrench);
}

void BodyLoads::apply_modal(int body, const Eigen::VectorXd& f, double factor) {
  const TreeBody& t = tree_.bodies[body];
  if (t.n_need == 0) return;  // made rigid
  wrenches_.r.segment(t.i_need, t.n_need).noalias() -= factor_ * factor * f;
}

}  // namespace flexura::mbs
