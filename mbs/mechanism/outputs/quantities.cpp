// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/outputs/quantities.hpp"

#include <Eigen/Geometry>

#include "mbs/mechanism/outputs/joint_reaction.hpp"

/// The values of quantities at one state.
namespace flexura::mbs {

Quantities::Quantities(const Topology& tree, const ConstraintRows& rows, int n_algebraic)
    : tree_(tree), rows_(rows), all_(list_quantities(tree, rows, n_algebraic)) {}

std::vector<OutputInfo> Quantities::infos() const {
  std::vector<OutputInfo> infos;
  for (const Quantity& q : all_) infos.push_back(q.info);
  return infos;
}

std::vector<int> Quantities::usual() const {
  std::vector<int> which;
  for (std::size_t i = 0; i < all_.size(); ++i)
    if (all_[i].usual) which.push_back(static_cast<int>(i));
  return which;
}

Vector6d Quantities::joint_reaction(int joint, const Motion& motion, const Wrenches& wrenches,
                                    const RowValues& rows) const {
  return mbs::joint_reaction(tree_, rows_, joint, motion, wrenches, rows);
}

double Quantities::drive_force(int joint, int coordinate, const RowValues& rows) const {
  const int drive = rows_.drive_of({joint, coordinate});
  return drive < 0 ? 0.0 : -rows.x(rows_.first_row(static_cast<std::size_t>(drive)));
}

void Quantities::evaluate(const std::vector<int>& which, const Instant& at, VectorRef values) const {
  Motion& motion = at.motion;
  const Wrenches& wrenches = at.wrenches;
  RowValues& rows = at.rows;
  const EnergyReport& e = at.energies;
  const double of_energy[] = {e.kinetic,     e.strain,
                              e.potential,   e.kinetic + e.strain + e.potential,
                              e.input_power, e.dissipated_power};
  std::vector<double> outputs;
  // The element whose outputs these are: forces count from 0, constraints down from -2.
  int outputs_of = -1;
  const auto constraint_mark = [](int k) { return -2 - k; };
  Vector6d momentum;
  bool momentum_is_known = false;
  StressField::Largest largest;
  int largest_of = -1;
  std::vector<double> factors;
  int factors_of = -1;
  // Of a body's load cases, where its stresses or section forces follow them.
  const auto load_factors = [&](int body) -> const double* {
    const BodyDescription& b = tree_.d.bodies[body];
    if (!b.is_loaded_by_case ||
        !((b.stress && b.stress->has_loads()) || (b.sections && b.sections->has_loads())))
      return nullptr;
    if (factors_of == body) return factors.data();
    factors_of = body;
    factors.assign(b.loads.size(), 0.0);
    for (const auto& force : tree_.d.forces) {
      const auto [on, load] = force->load_case();
      if (on != body) continue;
      double factor = 0.0;
      force->evaluate_outputs(motion.kin, at.signals.values.data(), &factor);
      factors[static_cast<std::size_t>(load)] += factor;
    }
    return factors.data();
  };
  for (std::size_t i = 0; i < which.size(); ++i) {
    const Quantity& q = all_[which[i]];
    double value = 0.0;
    switch (q.kind) {
      case Kind::coordinate:
        value = motion.kin.coordinate({q.index, q.component});
        break;
      case Kind::speed:
        value = motion.kin.speed({q.index, q.component});
        break;
      case Kind::acceleration:
        value = motion.kin.acceleration({q.index, q.component});
        break;
      case Kind::reaction: {
        double wrench[8];
        put_wrench(joint_reaction(q.index, motion, wrenches, rows), true, true, wrench);
        value = wrench[q.component];
        break;
      }
      case Kind::drive:
        value = drive_force(q.index, q.component, rows);
        break;
      case Kind::body_position:
        value = motion.bodies[q.index].X_WB.p(q.component);
        break;
      case Kind::body_velocity: {
        const Spatial& V = motion.bodies[q.index].V;
        value = q.component < 3 ? V.linear(q.component) : V.angular(q.component - 3);
        break;
      }
      case Kind::body_acceleration:
        value = motion.bodies[q.index].A.linear(q.component);
        break;
      case Kind::mode:
        value = at.deformation(q.index)[q.component];
        break;
      case Kind::strain_energy:
        value = tree_.flexible(q.index)->strain_energy(at.deformation(q.index));
        break;
      case Kind::largest_stress: {
        const StressField& stress = *tree_.d.bodies[q.index].stress;
        if (largest_of != q.index) largest = stress.largest(at.deformation(q.index), load_factors(q.index));
        largest_of = q.index;
        value = q.component == 0 ? largest.von_mises : stress.position(largest.place)(q.component - 1);
        break;
      }
      case Kind::point_stress: {
        const StressField& stress = *tree_.d.bodies[q.index].stress;
        const int place = stress.points()[q.component / Quantity::kOfPoint].place,
                  what = q.component % Quantity::kOfPoint;
        const double *const modal = at.deformation(q.index), *const loads = load_factors(q.index);
        value = what < 6    ? stress.at(place, modal, loads)(what)
                : what == 6 ? von_mises(stress.at(place, modal, loads))
                            : stress.strain_at(place, modal, loads)(what - 7);
        break;
      }
      case Kind::section_force:
        value = tree_.d.bodies[q.index].sections->at(q.component / 6, at.deformation(q.index),
                                                     load_factors(q.index))(q.component % 6);
        break;
      case Kind::surface_point: {
        const SurfacePoints& surface = *tree_.d.bodies[q.index].surface_points;
        const std::size_t point = q.component / 7;
        const Vector3d u = surface.displacement(point, at.deformation(q.index));
        const int what = q.component % 7;
        value = what < 3    ? u(what)
                : what == 6 ? u.norm()
                            : (motion.bodies[q.index].X_WB * (surface.points()[point].x + u))(what - 3);
        break;
      }
      case Kind::measure:
        value = at.measured[q.index];
        break;
      case Kind::contact:
        value = at.signals.algebraic(q.index);
        break;
      case Kind::input:
        value = at.input(q.index);
        break;
      case Kind::control:
        value = at.controlled[q.index];
        break;
      case Kind::force:
        if (outputs_of != q.index) {
          outputs.assign(tree_.d.forces[q.index]->outputs().size(), 0.0);
          at.own_states(q.index);
          tree_.d.forces[q.index]->evaluate_outputs(motion.kin, at.signals.values.data(), outputs.data());
          outputs_of = q.index;
        }
        value = outputs[q.component];
        break;
      case Kind::constraint: {
        const Constraint& constraint = *rows_.constraints()[q.index];
        if (outputs_of != constraint_mark(q.index)) {
          outputs.assign(constraint.outputs().size(), 0.0);
          rows_.own_contact(q.index, motion, rows);
          constraint.evaluate_outputs(motion.kin, rows.x.data() + rows_.first_row(q.index), outputs.data());
          outputs_of = constraint_mark(q.index);
        }
        value = outputs[q.component];
        break;
      }
      case Kind::momentum:
        if (!momentum_is_known) momentum = at.momentum();
        momentum_is_known = true;
        value = momentum(q.component);
        break;
      case Kind::energy:
        value = of_energy[q.component];
        break;
    }
    values(i) = value;
  }
}

}  // namespace flexura::mbs
