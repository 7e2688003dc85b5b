// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Geometry>

#include "mbs/mechanism/work.hpp"

/// The values of quantities at one state.
namespace flexura::mbs {

Vector6d Mechanism::joint_reaction(int joint, Work& work) const {
  const JointPlace& place = places_[joint];
  const Pose &F = work.kin.markers[place.marker_F].X_WP, &M = work.kin.markers[place.marker_M].X_WP;
  if (!place.in_tree()) {
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
      const auto* closure = dynamic_cast<const RelativeConstraint*>(constraints_[k].get());
      if (closure && closure->name() == d_.joints[joint].name)
        return work.on_closure[joint] - closure->wrench_on_M(work.kin, work.rows_x.data() + first_row_[k]);
    }
    return work.on_closure[joint];
  }
  for (int b : order_) {
    if (bodies_[b].joint != joint) continue;
    const Spatial& through = work.bodies[b].through_joint;
    if (!bodies_[b].reversed) return (F.R.transpose() * through).vector();
    const Spatial on_M = shift_wrench(through, F.p - M.p);
    return -(F.R.transpose() * on_M).vector();
  }
  return Vector6d::Zero();
}

double Mechanism::drive_force(int joint, int coordinate, const Work& work) const {
  for (std::size_t k = 0; k < constraints_.size(); ++k) {
    const auto* drive = dynamic_cast<const DriveConstraint*>(constraints_[k].get());
    if (drive && drive->coordinate().joint == joint && drive->coordinate().index == coordinate)
      return -work.rows_x(first_row_[k]);
  }
  return 0.0;
}

// Angular momentum about the world's origin and linear momentum, in W: after body_forces().  A body's in its own
// frame are M_rr V + M_rf s', M the mass matrix of its floating frame.
Vector6d Mechanism::total_momentum(const Work& work) const {
  Spatial total;
  for (int b : order_) {
    const BodyDescription& description = d_.bodies[b];
    const Work::Body& body = work.bodies[b];
    const Spatial V = body.X_WB.R.transpose() * body.V;
    Spatial of_body;  // about Bo, in B
    if (bodies_[b].m > 0) {
      const FlexibleBody::Scratch& f = *body.flexible;
      const Eigen::Map<const Eigen::VectorXd> s_dot(work.kin.v + bodies_[b].i_v, bodies_[b].m);
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

void Mechanism::evaluate(const std::vector<int>& which, const State& s, ConstVectorRef v_dot,
                         Scratch& scratch, VectorRef values) const {
  Work& work = work_of(scratch);
  forward(Level::acceleration, s.t, s.p.data(), s.v.data(), v_dot.data(), work);
  take_states(s, work);
  body_forces(true, work);
  // Measures that only the output asks for may read signals that no force needs: all of them, in their order.
  work.signals(0) = s.t;
  std::vector<double> measured(d_.measures.size()), controlled(d_.controls.size());
  for (std::size_t k = 1; k < sources_.size(); ++k) {
    const SignalSource& source = sources_[k];
    if (source.kind == SignalSource::Kind::coordinate)
      work.signals(k) = work.kin.coordinate(source.coordinate);
    if (source.kind == SignalSource::Kind::input) work.signals(k) = input_now(source.element, work);
    if (source.kind == SignalSource::Kind::speed) work.signals(k) = work.kin.speed(source.coordinate);
  }
  const auto evaluate_controls = [&](bool feed_through) {
    for (std::size_t i = 0; i < d_.controls.size(); ++i) {
      if (d_.controls[i]->feeds_through() != feed_through) continue;
      controlled[i] = control_output(static_cast<int>(i), work);
      if (const int k = d_.signals.find(d_.controls[i]->name()); k >= 0) work.signals(k) = controlled[i];
    }
  };
  evaluate_controls(false);
  for (std::size_t i = 0; i < d_.measures.size(); ++i) {
    measured[i] = d_.measures[i]->value(work.kin, work.signals.data());
    if (const int k = d_.signals.find(d_.measures[i]->name()); k >= 0) work.signals(k) = measured[i];
  }
  evaluate_controls(true);
  BodyLoads loads(*this, work, 1.0);
  work.on_closure.assign(places_.size(), Vector6d::Zero());
  for (std::size_t i = 0; i < d_.forces.size(); ++i) {
    own_states(i, work);
    d_.forces[i]->apply(work.kin, work.signals.data(), loads);
  }
  work.rows_x.setZero();
  add_constraint_loads(s.lambda.data(), -1.0, work);
  backward(work, work.r.data());
  const EnergyReport e = energies(s.lambda.data(), work);
  const double of_energy[] = {e.kinetic,     e.strain,
                              e.potential,   e.kinetic + e.strain + e.potential,
                              e.input_power, e.dissipated_power};

  if (n_dyn_ > first_force_state_.back()) {
    // What is measured on a body shows its deformation where the forces above did not see it, too.
    const std::vector<MarkerState> rigid = work.kin.markers;
    deform_following_markers(work);
    for (std::size_t i = 0; i < d_.measures.size(); ++i) {
      measured[i] = d_.measures[i]->value(work.kin, work.signals.data());
      if (const int k = d_.signals.find(d_.measures[i]->name()); k >= 0) work.signals(k) = measured[i];
    }
    work.kin.markers = rigid;
  }

  std::vector<double> outputs;
  // The element whose outputs these are: forces count from 0, constraints down from -2.
  int outputs_of = -1;
  const auto constraint_mark = [](int k) { return -2 - k; };
  Vector6d momentum;
  bool momentum_is_known = false;
  StressField::Largest largest;
  int largest_of = -1;
  for (std::size_t i = 0; i < which.size(); ++i) {
    const QuantityPlace& q = quantities_[which[i]];
    double value = 0.0;
    switch (q.kind) {
      case QuantityKind::coordinate:
        value = work.kin.coordinate({q.index, q.component});
        break;
      case QuantityKind::speed:
        value = work.kin.speed({q.index, q.component});
        break;
      case QuantityKind::acceleration:
        value = work.kin.acceleration({q.index, q.component});
        break;
      case QuantityKind::reaction: {
        double wrench[8];
        put_wrench(joint_reaction(q.index, work), true, true, wrench);
        value = wrench[q.component];
        break;
      }
      case QuantityKind::drive:
        value = drive_force(q.index, q.component, work);
        break;
      case QuantityKind::body_position:
        value = work.bodies[q.index].X_WB.p(q.component);
        break;
      case QuantityKind::body_velocity: {
        const Spatial& V = work.bodies[q.index].V;
        value = q.component < 3 ? V.linear(q.component) : V.angular(q.component - 3);
        break;
      }
      case QuantityKind::body_acceleration:
        value = work.bodies[q.index].A.linear(q.component);
        break;
      case QuantityKind::mode:
        value = modal_coordinates(q.index, s)[q.component];
        break;
      case QuantityKind::strain_energy:
        value = deforming(q.index)->strain_energy(modal_coordinates(q.index, s));
        break;
      case QuantityKind::largest_stress: {
        const StressField& stress = *d_.bodies[q.index].stress;
        if (largest_of != q.index) largest = stress.largest(modal_coordinates(q.index, s));
        largest_of = q.index;
        value = q.component == 0 ? largest.von_mises : stress.position(largest.place)(q.component - 1);
        break;
      }
      case QuantityKind::point_stress: {
        const StressField& stress = *d_.bodies[q.index].stress;
        const int place = stress.points()[q.component / kOfPoint].place, what = q.component % kOfPoint;
        const double* const modal = modal_coordinates(q.index, s);
        value = what < 6    ? stress.at(place, modal)(what)
                : what == 6 ? von_mises(stress.at(place, modal))
                            : stress.strain_at(place, modal)(what - 7);
        break;
      }
      case QuantityKind::section_force:
        value =
            d_.bodies[q.index].sections->at(q.component / 6, modal_coordinates(q.index, s))(q.component % 6);
        break;
      case QuantityKind::surface_point: {
        const SurfacePoints& surface = *d_.bodies[q.index].surface_points;
        const std::size_t point = q.component / 7;
        const Vector3d u = surface.displacement(point, modal_coordinates(q.index, s));
        const int what = q.component % 7;
        value = what < 3    ? u(what)
                : what == 6 ? u.norm()
                            : (work.bodies[q.index].X_WB * (surface.points()[point].x + u))(what - 3);
        break;
      }
      case QuantityKind::measure:
        value = measured[q.index];
        break;
      case QuantityKind::contact:
        value = work.algebraic(q.index);
        break;
      case QuantityKind::input:
        value = input_now(q.index, work);
        break;
      case QuantityKind::control:
        value = controlled[q.index];
        break;
      case QuantityKind::force:
        if (outputs_of != q.index) {
          outputs.assign(d_.forces[q.index]->outputs().size(), 0.0);
          own_states(q.index, work);
          d_.forces[q.index]->evaluate_outputs(work.kin, work.signals.data(), outputs.data());
          outputs_of = q.index;
        }
        value = outputs[q.component];
        break;
      case QuantityKind::constraint: {
        const Constraint& constraint = *constraints_[q.index];
        if (outputs_of != constraint_mark(q.index)) {
          outputs.assign(constraint.outputs().size(), 0.0);
          own_contact(q.index, work);
          constraint.evaluate_outputs(work.kin, work.rows_x.data() + first_row_[q.index], outputs.data());
          outputs_of = constraint_mark(q.index);
        }
        value = outputs[q.component];
        break;
      }
      case QuantityKind::momentum:
        if (!momentum_is_known) momentum = total_momentum(work);
        momentum_is_known = true;
        value = momentum(q.component);
        break;
      case QuantityKind::energy:
        value = of_energy[q.component];
        break;
    }
    values(i) = value;
  }
}

}  // namespace flexura::mbs
