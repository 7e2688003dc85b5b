// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/outputs/quantities.hpp"

#include <Eigen/Geometry>

#include "mbs/mechanism/outputs/joint_reaction.hpp"

/// The values of quantities at one state.
namespace flexura::mbs {

namespace {

// Force and moment on each node of a flexible body about the node, in B; after all loads are taken inwards.
Eigen::VectorXd loads_on_nodes(const Topology& tree, int b, const Motion& motion, const Wrenches& wrenches) {
  const Pose& X_WB = motion.bodies[b].X_WB;
  const TreeBody& t = tree.bodies[b];
  Eigen::VectorXd out =
      Eigen::VectorXd::Zero(6 * static_cast<Eigen::Index>(tree.d.bodies[b].flexible->nodes().size()));
  for (const int i : tree.markers_of_body[b]) {
    if (!tree.on_node[i]) continue;
    const MarkerDescription& marker = tree.d.markers[i];
    Spatial F = wrenches.on_marker[i];
    const Vector3d& p = motion.kin.markers[i].X_WP.p;
    const auto add = [&](const Spatial& more, double sign) {
      F.angular += sign * more.angular;
      F.linear += sign * more.linear;
    };
    if (t.marker_out == i) add(wrenches.bodies[b].through_joint, 1.0);
    for (const int c : tree.order)
      if (tree.bodies[c].marker_in == i)
        add(shift_wrench(wrenches.bodies[c].through_joint,
                         motion.kin.markers[tree.bodies[c].marker_out].X_WP.p - p),
            -1.0);
    const Spatial at_node = X_WB.R.transpose() * F;
    const Eigen::Index k = 6 * static_cast<Eigen::Index>(marker.node);
    out.segment<3>(k) += at_node.linear;
    out.segment<3>(k + 3) += at_node.angular + marker.X_BP.p.cross(at_node.linear);
  }
  return out;
}

}  // namespace

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
  return drive < 0 ? 0.0 : -rows.x(drive);
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
  int largest_of = -1, strain_of = -1, displacement_of = -1;
  StressField::LargestStrain strain;
  SurfacePoints::Greatest displacement;
  std::vector<double> factors;
  int factors_of = -1;
  // Of a body's load cases, where its stresses or section forces follow them.
  const auto load_factors = [&](int body) -> const double* {
    const BodyDescription& b = tree_.d.bodies[body];
    if (!b.is_loaded_by_case || !(b.stress || b.sections)) return nullptr;
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
  BodyMotion body_motion;
  Eigen::VectorXd s_ddot;
  int motion_of = -1;
  const auto motion_in_body = [&](int b) -> const BodyMotion& {
    if (motion_of == b) return body_motion;
    motion_of = b;
    const Motion::Body& moves = motion.bodies[b];
    const Matrix3d R_BW = moves.X_WB.R.transpose();
    body_motion.w = R_BW * moves.V.angular;
    body_motion.alpha = R_BW * moves.A.angular;
    body_motion.a = R_BW * (moves.A.linear - tree_.d.gravity);
    body_motion.s = at.deformation(b);
    const TreeBody& t = tree_.bodies[b];
    if (t.m > 0) {
      body_motion.s_dot = motion.kin.v + t.i_v;
      body_motion.s_ddot = motion.kin.v_dot + t.i_v;
    } else {  // the deformation follows
      s_ddot = -wrenches.r.segment(t.i_need, t.n_need);
      body_motion.s_dot = motion.kin.c + t.i_c + t.n_need;
      body_motion.s_ddot = s_ddot.data();
    }
    const BodyDescription& of = tree_.d.bodies[b];
    body_motion.on_nodes.resize(0);
    if ((of.sections && of.sections->takes_node_loads()) || (of.stress && of.stress->takes_node_loads()))
      body_motion.on_nodes = loads_on_nodes(tree_, b, motion, wrenches);
    return body_motion;
  };
  Eigen::VectorXd beyond;
  int beyond_of = -1;
  const auto stress_beyond = [&](int b) -> const Eigen::VectorXd* {
    if (beyond_of != b) beyond = tree_.d.bodies[b].stress->beyond(motion_in_body(b), load_factors(b));
    beyond_of = b;
    return &beyond;
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
        if (largest_of != q.index)
          largest = stress.largest(at.deformation(q.index), load_factors(q.index), stress_beyond(q.index));
        largest_of = q.index;
        value = q.component == 0 ? largest.von_mises : stress.position(largest.place)(q.component - 1);
        break;
      }
      case Kind::largest_strain: {
        const StressField& stress = *tree_.d.bodies[q.index].stress;
        if (strain_of != q.index)
          strain =
              stress.largest_strain(at.deformation(q.index), load_factors(q.index), stress_beyond(q.index));
        strain_of = q.index;
        value = q.component == 0 ? strain.strain : stress.position(strain.place)(q.component - 1);
        break;
      }
      case Kind::largest_displacement: {
        const SurfacePoints& surface = *tree_.d.bodies[q.index].surface_points;
        if (displacement_of != q.index) displacement = surface.greatest(at.deformation(q.index));
        displacement_of = q.index;
        value =
            q.component == 0 ? displacement.displacement : surface.node(displacement.node)(q.component - 1);
        break;
      }
      case Kind::point_stress: {
        const StressField& stress = *tree_.d.bodies[q.index].stress;
        const int place = stress.points()[q.component / Quantity::kOfPoint].place,
                  what = q.component % Quantity::kOfPoint;
        const double *const modal = at.deformation(q.index), *const loads = load_factors(q.index);
        const Eigen::VectorXd* more = stress_beyond(q.index);
        value = what < 6    ? stress.at(place, modal, loads, more)(what)
                : what == 6 ? von_mises(stress.at(place, modal, loads, more))
                            : stress.strain_at(place, modal, loads, more)(what - 7);
        break;
      }
      case Kind::section_force:
        value = tree_.d.bodies[q.index].sections->at(q.component / 6, motion_in_body(q.index),
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
