// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/work.hpp"

/// The recursions over the tree: outwards the motion, inwards the forces.
namespace flexura::mbs {

using Eigen::VectorXd;

std::unique_ptr<Equations::Scratch> Mechanism::make_scratch() const {
  auto work = std::make_unique<Work>();
  work->bodies.resize(d_.bodies.size());
  work->local.resize(d_.markers.size());
  work->kin.markers.resize(d_.markers.size());
  work->kin.joints = &places_;
  work->kin.bodies.resize(d_.bodies.size());
  for (std::size_t b = 0; b < d_.bodies.size(); ++b) work->kin.bodies[b].loads = &d_.bodies[b].loads;
  int widest = 0;
  work->K.resize(d_.bodies.size());
  for (std::size_t b = 1; b < d_.bodies.size(); ++b) {
    Work::Body& body = work->bodies[b];
    const TreeBody& t = bodies_[b];
    const int n_v = places_[t.joint].joint->n_v();
    body.S.setZero(6, n_v);
    if (const auto& flexible = d_.bodies[b].flexible) body.flexible = flexible->make_scratch();
    if (t.i_c >= 0) body.no_acceleration.setZero(t.n_need);
    body.C_c.setZero(6, t.m);
    body.M_c.setZero(t.m, t.m);
    work->K[b].setZero(6, n_v + t.m);
    widest = std::max(widest, n_v + t.m);
  }
  work->H.setZero(6, widest);
  work->articulated.resize(d_.bodies.size());
  for (int b : order_) {
    const TreeBody& t = bodies_[b];
    const int n_b = static_cast<int>(work->K[b].cols());
    Work::Articulated& a = work->articulated[b];
    a.K.setZero(6, n_b);
    a.U.setZero(6, n_b);
    a.L.setZero(n_b, n_b);
    a.N.setZero(6, bodies_[t.parent].m);
    a.q.setZero(t.m);
  }
  for (std::size_t i = 0; i < d_.markers.size(); ++i) {
    const MarkerDescription& marker = d_.markers[i];
    work->local[i].X_BP = marker.X_BP;
    if (on_node_[i]) work->local[i].motion = d_.bodies[marker.body].flexible->make_node_motion();
    // Where the deformation does not act back the marker stays, and loads see the undeformed body.
    if (on_node_[i] && !is_carried_[i])
      place_on_node(static_cast<int>(i), work->bodies[marker.body].no_acceleration.data(), nullptr, nullptr, *work);
    if (marker.body == 0) work->kin.markers[i].X_WP = marker.X_BP;
  }
  work->r.setZero(n_need_);
  work->zero_v.setZero(n_v_);
  work->rows_x.setZero(first_row_.back());
  work->rows_g.setZero(first_row_.back());
  work->signals.setZero(d_.signals.size());
  work->switches.assign(n_switches(), 0);
  work->algebraic.setZero(sizes().n_alg);
  work->inputs.setZero(n_inputs());
  work->contacts.assign(constraints_.size(), std::numeric_limits<double>::quiet_NaN());
  return work;
}

Mechanism::Work& Mechanism::work_of(Scratch& scratch) const {
  return static_cast<Work&>(scratch);
}

void Mechanism::forward(Level level, double t, const double* p, const double* v, const double* v_dot,
                        Work& work) const {
  work.kin.t = t;
  work.kin.p = p;
  work.kin.v = v;
  work.kin.v_dot = v_dot;
  for (int b : order_) {
    const TreeBody& body = bodies_[b];
    if (body.m > 0) {
      work.kin.bodies[b].s = p + body.i_p;
      work.kin.bodies[b].s_dot = v ? v + body.i_v : nullptr;
    }
    for (int i : markers_of_body_[b])
      if (is_carried_[i])
        place_on_node(i, p + body.i_p, level == Level::position ? nullptr : v + body.i_v,
                      level == Level::acceleration ? v_dot + body.i_v : nullptr, work);
    move_through_joint(b, level, work);
    place_markers(b, level, work);
  }
}

// The inertia of deformed bodies, after forward(); what asks for positions and velocities alone does without.
void Mechanism::deform_inertia(Work& work) const {
  for (int b : order_)
    if (bodies_[b].m > 0)
      d_.bodies[b].flexible->set_position(work.kin.p + bodies_[b].i_p, *work.bodies[b].flexible);
}

void Mechanism::place_on_node(int marker, const double* s, const double* s_dot, const double* s_ddot,
                              Work& work) const {
  const MarkerDescription& description = d_.markers[marker];
  Work::LocalMarker& local = work.local[marker];
  NodeMotion& motion = local.motion;
  d_.bodies[description.body].flexible->node_motion(description.node, s, s_dot, s_ddot, motion);
  // The marker stands r from the node: v += w x r, a += alpha x r + w x (w x r).
  const Vector3d r = motion.X_BN.R * description.X_BP.p;
  local.X_BP = {motion.X_BN.R * description.X_BP.R, motion.X_BN.p + r};
  if (r.isZero(0.0)) return;
  motion.map.bottomRows<3>().noalias() -= skew(r) * motion.map.topRows<3>();
  if (!s_dot) return;
  const Vector3d w_x_r = motion.V.angular.cross(r);
  motion.V.linear += w_x_r;
  if (s_ddot)
    motion.A.linear += motion.A.angular.cross(r) + motion.V.angular.cross(w_x_r);
}

void Mechanism::move_through_joint(int b, Level level, Work& work) const {
  const TreeBody& body = bodies_[b];
  const JointPlace& place = places_[body.joint];
  const Joint& joint = *place.joint;
  Work::Body& out = work.bodies[b];
  const MarkerState& in = work.kin.markers[body.marker_in];
  const Work::LocalMarker& local = work.local[body.marker_out];
  const bool deforms = is_carried_[body.marker_out];

  const double* q = work.kin.p + place.i_p;
  out.X_in_out = joint.pose(q);
  joint.motion(q, out.S);
  const Pose X_FM = out.X_in_out;
  if (body.reversed) {
    // F moves relative to M: w_MF_M = -R_MF w_FM_F,  d/dt p_MoFo_M = R_MF (w x p - p'), p = p_FoMo_F.
    out.X_in_out = X_FM.inverse();
    for (int i = 0; i < out.S.cols(); ++i) {
      const Vector3d w = out.S.col(i).head<3>(), u = out.S.col(i).tail<3>();
      out.S.col(i).head<3>() = -(out.X_in_out.R * w);
      out.S.col(i).tail<3>() = out.X_in_out.R * (w.cross(X_FM.p) - u);
    }
  }
  const Pose X_W_out = in.X_WP * out.X_in_out;
  out.X_WB = X_W_out * local.X_BP.inverse();
  if (level == Level::position) return;

  // Twist of the outer marker's frame, then of the body: what the marker moves relative to the body comes
  // off.
  const double* v = work.kin.v + place.i_v;
  Vector6d V_rel = Vector6d::Zero();
  for (int i = 0; i < out.S.cols(); ++i) V_rel += out.S.col(i) * v[i];
  const Spatial rel = in.X_WP.R * Spatial::from(V_rel);
  const Vector3d r = X_W_out.p - in.X_WP.p;
  const Vector3d& w_in = in.V.angular;
  const Spatial V_out{w_in + rel.angular, in.V.linear + w_in.cross(r) + rel.linear};
  const Vector3d to_body = out.X_WB.p - X_W_out.p;
  Spatial own;  // of the outer marker in its body
  if (deforms) own = out.X_WB.R * local.motion.V;
  out.V.angular = V_out.angular - own.angular;
  out.V.linear = V_out.linear - own.linear + out.V.angular.cross(to_body);
  if (level == Level::velocity) return;

  out.bias = joint.bias(q, v);
  if (body.reversed) {
    // The derivative of the two lines above at v' = 0.
    Vector6d V_FM = Vector6d::Zero();
    MotionMatrix S(6, joint.n_v());
    joint.motion(q, S);
    for (int i = 0; i < S.cols(); ++i) V_FM += S.col(i) * v[i];
    const Vector3d w = V_FM.head<3>(), u = V_FM.tail<3>(), b_w = out.bias.head<3>(), b_u = out.bias.tail<3>();
    out.bias.head<3>() = -(out.X_in_out.R * b_w);
    out.bias.tail<3>() =
        out.X_in_out.R * (2.0 * w.cross(u) - w.cross(w.cross(X_FM.p)) - b_u + b_w.cross(X_FM.p));
  }
  const double* v_dot = work.kin.v_dot + place.i_v;
  Vector6d A_rel = out.bias;
  for (int i = 0; i < out.S.cols(); ++i) A_rel += out.S.col(i) * v_dot[i];
  const Spatial rel_dot = in.X_WP.R * Spatial::from(A_rel);
  const Spatial A_out{in.A.angular + w_in.cross(rel.angular) + rel_dot.angular,
                      in.A.linear + in.A.angular.cross(r) + w_in.cross(w_in.cross(r)) +
                          2.0 * w_in.cross(rel.linear) + rel_dot.linear};
  const Vector3d& w = out.V.angular;
  out.A = A_out;
  if (deforms) {
    const Spatial own_dot = out.X_WB.R * local.motion.A;
    out.A.angular -= w.cross(own.angular) + own_dot.angular;
    out.A.linear -= 2.0 * w.cross(own.linear) + own_dot.linear;
  }
  out.A.linear += out.A.angular.cross(to_body) + w.cross(w.cross(to_body));
}

void Mechanism::place_markers(int b, Level level, Work& work) const {
  const Work::Body& body = work.bodies[b];
  const Vector3d& w = body.V.angular;
  for (int i : markers_of_body_[b]) {
    const Work::LocalMarker& local = work.local[i];
    MarkerState& marker = work.kin.markers[i];
    marker.X_WP = body.X_WB * local.X_BP;
    if (level == Level::position) continue;
    const Vector3d r = marker.X_WP.p - body.X_WB.p;
    marker.V = {w, body.V.linear + w.cross(r)};
    if (level == Level::acceleration)
      marker.A = {body.A.angular, body.A.linear + body.A.angular.cross(r) + w.cross(w.cross(r))};
    if (!is_carried_[i]) continue;
    const Spatial rel = body.X_WB.R * local.motion.V;
    marker.V += rel;
    if (level == Level::acceleration) {
      const Spatial rel_dot = body.X_WB.R * local.motion.A;
      marker.A.angular += w.cross(rel.angular) + rel_dot.angular;
      marker.A.linear += 2.0 * w.cross(rel.linear) + rel_dot.linear;
    }
  }
}

void Mechanism::clear_loads(Work& work) const {
  for (Work::Body& body : work.bodies) body.F = {};
  work.r.setZero();
}

void Mechanism::body_forces(bool with_gravity, Work& work) const {
  const Vector3d g = with_gravity ? d_.gravity : Vector3d::Zero();
  deform_inertia(work);
  work.r.setZero();
  work.bodies[0].F = {};
  for (int b : order_) {
    Work::Body& body = work.bodies[b];
    const BodyDescription& description = d_.bodies[b];
    const Matrix3d& R = body.X_WB.R;
    const Spatial V = R.transpose() * body.V;
    const Spatial A = R.transpose() * Spatial{body.A.angular, body.A.linear - g};
    Spatial need;
    const TreeBody& t = bodies_[b];
    if (t.m > 0) {
      need = description.flexible->inverse_dynamics(work.kin.p + t.i_p, work.kin.v + t.i_v,
                                                    work.kin.v_dot + t.i_v, V, A, *body.flexible,
                                                    work.r.data() + t.i_v);
    } else {
      const RigidInertia& I = description.inertia;
      const Vector3d &w = V.angular, &d = I.mass_center;
      need.linear = I.mass * A.linear + A.angular.cross(d) + w.cross(w.cross(d));
      need.angular = d.cross(A.linear) + I.inertia * A.angular + w.cross(I.inertia * w);
      if (t.i_c >= 0) following_need(b, V, A, work);
    }
    body.F = R * need;
  }
}

void Mechanism::backward(Work& work, double* r_out) const {
  Eigen::Map<VectorXd> r(r_out, n_v_);
  for (auto it = order_.rbegin(); it != order_.rend(); ++it) {
    const TreeBody& t = bodies_[*it];
    Work::Body& body = work.bodies[*it];
    const Pose& in = work.kin.markers[t.marker_in].X_WP;
    const Pose& out = work.kin.markers[t.marker_out].X_WP;
    body.through_joint = shift_wrench(body.F, body.X_WB.p - out.p);
    if (on_node_[t.marker_out]) {
      const Vector6d f = (body.X_WB.R.transpose() * body.through_joint).vector();
      work.r.segment(t.i_need, t.n_need).noalias() -= work.local[t.marker_out].motion.map.transpose() * f;
    }
    const Vector6d along = (in.R.transpose() * body.through_joint).vector();
    const int i_v = places_[t.joint].i_v;
    for (int i = 0; i < body.S.cols(); ++i) work.r(i_v + i) += body.S.col(i).dot(along);

    const Spatial at_in = shift_wrench(body.through_joint, out.p - in.p);
    Work::Body& parent = work.bodies[t.parent];
    if (on_node_[t.marker_in]) {
      const TreeBody& tp = bodies_[t.parent];
      const Vector6d f = (parent.X_WB.R.transpose() * at_in).vector();
      work.r.segment(tp.i_need, tp.n_need).noalias() += work.local[t.marker_in].motion.map.transpose() * f;
    }
    parent.F += shift_wrench(at_in, in.p - parent.X_WB.p);
  }
  r = work.r.head(n_v_);
}

void Mechanism::BodyLoads::apply(int marker, const Spatial& wrench_W) {
  const MarkerDescription& description = mechanism_.d_.markers[marker];
  if (description.body == 0) return;
  Work::Body& body = work_.bodies[description.body];
  const Spatial about_Bo = shift_wrench(wrench_W, work_.kin.markers[marker].X_WP.p - body.X_WB.p);
  body.F.angular -= factor_ * about_Bo.angular;
  body.F.linear -= factor_ * about_Bo.linear;
  if (mechanism_.on_node_[marker]) {
    const TreeBody& t = mechanism_.bodies_[description.body];
    const Vector6d f = factor_ * (body.X_WB.R.transpose() * wrench_W).vector();
    work_.r.segment(t.i_need, t.n_need).noalias() -= work_.local[marker].motion.map.transpose() * f;
    Spatial& load = work_.local[marker].load;
    load.angular += factor_ * wrench_W.angular;
    load.linear += factor_ * wrench_W.linear;
  }
}

void Mechanism::BodyLoads::apply(CoordinateRef c, double force) {
  const JointPlace& place = mechanism_.places_[c.joint];
  if (place.in_tree()) {
    work_.r(place.i_v + c.index) -= factor_ * force;
    return;
  }
  // The wrench in the span of S that works on this speed alone: S (S^T S)^-1 e.
  double q[7];
  place.joint->coordinates_of(work_.kin.relative_pose(place.marker_F, place.marker_M), q);
  MotionMatrix S(6, place.joint->n_v());
  place.joint->motion(q, S);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> gram = S.transpose() * S;
  const Vector6d wrench = S * gram.inverse().col(c.index) * force;
  if (!work_.on_closure.empty()) work_.on_closure[c.joint] += factor_ * wrench;
  apply_between(work_.kin, place.marker_F, place.marker_M, wrench);
}

void Mechanism::BodyLoads::apply_modal(int body, const VectorXd& f, double factor) {
  const TreeBody& t = mechanism_.bodies_[body];
  work_.r.segment(t.i_need, t.n_need).noalias() -= factor_ * factor * f;
}

void Mechanism::evaluate_signals(Work& work) const {
  work.signals(0) = work.kin.t;
  for (int k : used_signals_) {
    const SignalSource& source = sources_[k];
    switch (source.kind) {
      case SignalSource::Kind::time:
        break;
      case SignalSource::Kind::coordinate:
        work.signals(k) = work.kin.coordinate(source.coordinate);
        break;
      case SignalSource::Kind::speed:
        work.signals(k) = work.kin.speed(source.coordinate);
        break;
      case SignalSource::Kind::input:
        work.signals(k) = input_now(source.element, work);
        break;
      case SignalSource::Kind::control:
        work.signals(k) = control_output(source.element, work);
        break;
      case SignalSource::Kind::measure:
        work.signals(k) = d_.measures[source.element]->value(work.kin, work.signals.data());
        break;
    }
  }
}

void Mechanism::add_constraint_loads(const double* lambda, double factor, Work& work, Which which) const {
  if (kept_rows_.empty()) return;
  work.rows_x.setZero();
  for (std::size_t i = 0; i < kept_rows_.size(); ++i) work.rows_x(kept_rows_[i]) = lambda[i];
  BodyLoads loads(*this, work, factor);
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    if (which != Which::all && constraints_[k]->has_derivatives() != (which == Which::with_derivatives))
      continue;
    own_contact(k, work);
    constraints_[k]->apply_GT(work.kin, work.rows_x.data() + first_row_[k], loads);
  }
}

}  // namespace flexura::mbs
