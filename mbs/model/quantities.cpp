// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include <set>

#include "mbs/model/work.hpp"

/// Everything that can be stored by name.
namespace flexura::mbs {
namespace {

namespace dim = input::dim;

constexpr const char* axis_names[] = {"x", "y", "z"};

// Six stresses, von Mises', six strains.
constexpr int kOfPoint = 13;

}  // namespace

void Mechanism::list_quantities() {
  std::set<std::string> taken;
  const auto add = [&](std::string name, input::Dimension dimension, std::string doc, QuantityKind kind,
                       int index, int component = 0, bool usual = false) {
    if (!taken.insert(name).second) return;  // a free body's joint bears its name: "stone.x" is one thing
    quantities_.push_back({{std::move(name), dimension, std::move(doc)}, kind, index, component, usual});
  };
  using K = QuantityKind;
  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    const JointDescription& joint = d_.joints[j];
    const int k = static_cast<int>(j);
    const bool narrow =
        joint.joint->n_v() <= 2;  // coordinates of interest; not the quaternion of a free body
    const auto coordinates = joint.joint->coordinates(), speeds = joint.joint->speeds(),
               accelerations = joint.joint->accelerations();
    for (std::size_t i = 0; i < coordinates.size(); ++i)
      add(joint.name + "." + coordinates[i].name, coordinates[i].dimension, "coordinate of the joint",
          K::coordinate, k, static_cast<int>(i), narrow);
    for (std::size_t i = 0; i < speeds.size(); ++i)
      add(joint.name + "." + speeds[i].name, speeds[i].dimension, "speed of the joint", K::speed, k,
          static_cast<int>(i), narrow);
    for (std::size_t i = 0; i < accelerations.size(); ++i)
      add(joint.name + "." + accelerations[i].name, accelerations[i].dimension, "acceleration of the joint",
          K::acceleration, k, static_cast<int>(i));
    if (joint.joint->n_rows() > 0) {
      add(joint.name + ".force", dim::force, "size of the force between the bodies", K::reaction, k, 6, true);
      add(joint.name + ".torque", dim::torque, "size of the torque between the bodies", K::reaction, k, 7,
          true);
      for (int i = 0; i < 3; ++i)
        add(fmt::format("{}.force_{}", joint.name, axis_names[i]), dim::force,
            "force on the body of `to`, in the axes of `from`", K::reaction, k, 3 + i);
      for (int i = 0; i < 3; ++i)
        add(fmt::format("{}.torque_{}", joint.name, axis_names[i]), dim::torque,
            "torque on the body of `to` about its marker, in the axes of `from`", K::reaction, k, i);
    }
    const auto all_drives = {&joint.drives, &joint.speed_drives, &joint.acceleration_drives};
    std::vector<int> driven;
    for (const auto* drives : all_drives)
      for (const auto& [index, motion] : *drives) driven.push_back(index);
    for (const int index : driven) {
      const bool is_angle = coordinates[index].dimension == dim::angle;
      add(joint.name + (driven.size() > 1 ? ".drive_force_" + coordinates[index].name : ".drive_force"),
          is_angle ? dim::torque : dim::force, "force or torque of the drive along the coordinate", K::drive,
          k, index, true);
    }
  }
  for (std::size_t b = 1; b < d_.bodies.size(); ++b) {
    const std::string& name = d_.bodies[b].name;
    const int k = static_cast<int>(b);
    for (int i = 0; i < 3; ++i) {
      const std::string axis = axis_names[i];
      add(name + ".position_" + axis, dim::length, "of the body's origin in the world", K::body_position, k,
          i);
      add(name + ".velocity_" + axis, dim::velocity, "of the body's origin", K::body_velocity, k, i);
      add(name + ".angular_velocity_" + axis, dim::angular_velocity, "of the body, in the world's axes",
          K::body_velocity, k, 3 + i);
      add(name + ".acceleration_" + axis, dim::acceleration, "of the body's origin", K::body_acceleration, k,
          i);
    }
    const FlexibleBody* deforms = deforming(k);
    for (int i = 0; deforms && i < deforms->m(); ++i)
      add(fmt::format("{}.mode_{}", name, i + 1), dim::none, "modal coordinate", K::mode, k, i);
    if (deforms)
      add(name + ".strain_energy", dim::energy, "elastic energy of the body", K::strain_energy, k, 0, true);
    if (const StressField* stress = d_.bodies[b].stress.get()) {
      add(name + ".von_mises", dim::pressure, "largest von Mises stress on the body's surface",
          K::largest_stress, k, 0, true);
      for (int i = 0; i < 3; ++i)
        add(fmt::format("{}.von_mises_{}", name, axis_names[i]), dim::length,
            "where it is, in the undeformed body", K::largest_stress, k, 1 + i, true);
      const char* components[] = {"xx", "yy", "zz", "xy", "yz", "zx"};
      for (std::size_t p = 0; p < stress->points().size(); ++p) {
        const std::string point = name + "." + stress->points()[p].name;
        const int first = kOfPoint * static_cast<int>(p);
        add(point + ".von_mises", dim::pressure, "von Mises stress at the point", K::point_stress, k,
            first + 6, true);
        for (int i = 0; i < 6; ++i)
          add(fmt::format("{}.stress_{}", point, components[i]), dim::pressure,
              "stress at the point, in the body's axes", K::point_stress, k, first + i);
        for (int i = 0; stress->has_strain() && i < 6; ++i)
          add(fmt::format("{}.strain_{}", point, components[i]), dim::none,
              i < 3 ? "strain at the point, in the body's axes"
                    : "shear strain at the point (an angle), in the body's axes",
              K::point_stress, k, first + 7 + i);
      }
    }
    if (const SectionPoints* sections = d_.bodies[b].sections.get()) {
      const char* components[] = {"N", "V_y", "V_z", "T", "M_y", "M_z"};
      for (std::size_t p = 0; p < sections->points().size(); ++p)
        for (int i = 0; i < 6; ++i)
          add(fmt::format("{}.{}.{}", name, sections->points()[p].name, components[i]),
              i < 3 ? dim::force : dim::torque, "section force at the point, in the member's axes",
              K::section_force, k, 6 * static_cast<int>(p) + i, true);
    }
  }
  for (std::size_t i = 0; i < d_.measures.size(); ++i)
    add(d_.measures[i]->name(), d_.measures[i]->dimension(), "measure", K::measure, static_cast<int>(i), 0,
        true);
  for (std::size_t k = 0; k < contacts_.size(); ++k)
    add(constraints_[contacts_[k]]->name() + ".contact", dim::length,
        "where along its curve the point stands", K::contact, static_cast<int>(algebraic_.size() + k), 0,
        true);
  for (std::size_t i = 0; i < d_.inputs.size(); ++i)
    add(d_.inputs[i].name, dim::none, "input", K::input, static_cast<int>(i), 0, true);
  for (std::size_t i = 0; i < d_.controls.size(); ++i)
    add(d_.controls[i]->name(), dim::none, "output of the control", K::control, static_cast<int>(i), 0, true);
  for (std::size_t f = 0; f < d_.forces.size(); ++f) {
    const auto outputs = d_.forces[f]->outputs();
    for (std::size_t i = 0; i < outputs.size(); ++i)
      add(d_.forces[f]->name() + "." + outputs[i].name, outputs[i].dimension, outputs[i].doc, K::force,
          static_cast<int>(f), static_cast<int>(i), true);
  }
  const char* energies[] = {"energy.kinetic", "energy.strain", "energy.potential", "energy.total"};
  const char* docs[] = {"kinetic energy", "elastic energy of flexible bodies",
                        "energy of gravity and springs", "kinetic + strain + potential"};
  for (int i = 0; i < 4; ++i) add(energies[i], dim::energy, docs[i], K::energy, 0, i, true);
  add("power.input", dim::power, "power of applied forces and drives", K::energy, 0, 4, true);
  add("power.dissipated", dim::power, "power taken out by dampers", K::energy, 0, 5, true);
}

std::vector<OutputInfo> Mechanism::quantities() const {
  std::vector<OutputInfo> infos;
  for (const QuantityPlace& q : quantities_) infos.push_back(q.info);
  return infos;
}

std::vector<int> Mechanism::usual_quantities() const {
  std::vector<int> which;
  for (std::size_t i = 0; i < quantities_.size(); ++i)
    if (quantities_[i].usual) which.push_back(static_cast<int>(i));
  return which;
}

Vector6d Mechanism::joint_reaction(int joint, Work& work) const {
  const JointPlace& place = places_[joint];
  const Pose &F = work.kin.markers[place.marker_F].X_WP, &M = work.kin.markers[place.marker_M].X_WP;
  if (!place.in_tree()) {
    for (std::size_t k = 0; k < constraints_.size(); ++k) {
      const auto* closure = dynamic_cast<const RelativeConstraint*>(constraints_[k].get());
      if (closure && closure->name() == d_.joints[joint].name)
        return -closure->wrench_on_M(work.kin, work.rows_x.data() + first_row_[k]);
    }
    return Vector6d::Zero();
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
    // What is measured on a one-way body shows its deformation; the forces above did not see it.
    const std::vector<MarkerState> rigid = work.kin.markers;
    deform_one_way_markers(work);
    for (std::size_t i = 0; i < d_.measures.size(); ++i) {
      measured[i] = d_.measures[i]->value(work.kin, work.signals.data());
      if (const int k = d_.signals.find(d_.measures[i]->name()); k >= 0) work.signals(k) = measured[i];
    }
    work.kin.markers = rigid;
  }

  std::vector<double> outputs;
  int outputs_of = -1;
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
        const Vector6d w = joint_reaction(q.index, work);
        value = q.component == 6   ? w.tail<3>().norm()
                : q.component == 7 ? w.head<3>().norm()
                                   : w(q.component);
        break;
      }
      case QuantityKind::drive:
        for (std::size_t k = 0; k < constraints_.size(); ++k) {
          const auto* drive = dynamic_cast<const DriveConstraint*>(constraints_[k].get());
          if (drive && drive->coordinate().joint == q.index && drive->coordinate().index == q.component)
            value = -work.rows_x(first_row_[k]);
        }
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
      case QuantityKind::energy:
        value = of_energy[q.component];
        break;
    }
    values(i) = value;
  }
}

}  // namespace flexura::mbs
