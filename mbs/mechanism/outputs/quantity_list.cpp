// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/outputs/quantity_list.hpp"

#include <fmt/format.h>

#include <map>
#include <stdexcept>

#include "mbs/measures/relative_measure.hpp"

namespace flexura::mbs {
namespace {

namespace dim = input::dim;

constexpr const char* axis_names[] = {"x", "y", "z"};

constexpr input::Dimension linear_momentum{{1, 1, -1, 0}}, angular_momentum{{2, 1, -1, 0}};

OutputRole role_of(Quantity::Kind kind, int component) {
  switch (kind) {
    case Quantity::Kind::energy:
    case Quantity::Kind::strain_energy:
      return OutputRole::energy;
    case Quantity::Kind::mode:
      return OutputRole::mode;
    case Quantity::Kind::largest_displacement:
      return component == 0 ? OutputRole::deformation : OutputRole::place_of_stress;
    case Quantity::Kind::largest_stress:
    case Quantity::Kind::largest_strain:
      return component == 0 ? OutputRole::value : OutputRole::place_of_stress;
    default:
      return OutputRole::value;
  }
}

// The joint that a body without one gets bears its name: its coordinates are the body's own place and motion.
bool is_joint_of_free_body(const MechanismDescription& d, const JointDescription& joint, int body) {
  const auto is_frame = [&](int marker, int of) {
    const MarkerDescription& m = d.markers[static_cast<std::size_t>(marker)];
    return m.body == of && m.X_BP.p.isZero(0.0) && m.X_BP.R.isIdentity(0.0);
  };
  return joint.name == d.bodies[static_cast<std::size_t>(body)].name && is_frame(joint.marker_F, 0) &&
         is_frame(joint.marker_M, body);
}

/// Names under which a run stores its own balance of energy (mbs/solver/run/energy.hpp).
constexpr const char* names_of_run[] = {"energy.input", "energy.dissipated", "energy.balance"};

input::Dimension unit_of(const MechanismDescription& d, const std::string& signal) {
  const auto given = d.units.find(signal);
  return given == d.units.end() ? dim::none : given->second;
}

}  // namespace

std::vector<Quantity> list_quantities(const Topology& tree, const ConstraintRows& rows, int n_algebraic) {
  std::vector<Quantity> all;
  struct Owner {
    std::string what;
    Quantity::Kind kind;
    int index;
    bool is_of_element;  ///< a measure that an element made of itself: "pull.length" of the force "pull"
  };
  std::map<std::string, Owner> taken;
  for (const char* name : names_of_run) taken[name] = {"the run", Quantity::Kind::energy, -1, false};
  const auto owner = [&](Quantity::Kind kind, int index) -> Owner {
    using K = Quantity::Kind;
    const auto k = static_cast<std::size_t>(index);
    const auto named = [&](const char* what, const std::string& name) {
      return Owner{fmt::format("{} \"{}\"", what, name), kind, index, false};
    };
    switch (kind) {
      case K::measure: {
        Owner of = named("measure", tree.d.measures[k]->name());
        of.is_of_element = dynamic_cast<const MeasureOfElement*>(tree.d.measures[k].get()) != nullptr;
        return of;
      }
      case K::contact:
        return named("constraint",
                     rows.constraints()[rows.contacts()[k - static_cast<std::size_t>(n_algebraic)]]->name());
      case K::constraint:
        return named("constraint", rows.constraints()[k]->name());
      case K::input:
        return named("input", tree.d.inputs[k].name);
      case K::control:
        return named("control", tree.d.controls[k]->name());
      case K::force:
        return named("force", tree.d.forces[k]->name());
      case K::coordinate:
      case K::speed:
      case K::acceleration:
      case K::reaction:
      case K::drive:
        return named("joint", tree.d.joints[k].name);
      case K::momentum:
      case K::energy:
        return {"the whole mechanism", kind, index, false};
      default:
        return named("body", tree.d.bodies[k].name);
    }
  };
  const auto is_one_thing = [&](const Owner& first, const Owner& second) {
    if (first.what == second.what && first.index == second.index) return true;
    if (first.is_of_element || second.is_of_element) return true;
    return first.what.starts_with("joint ") && second.what.starts_with("body ") &&
           is_joint_of_free_body(tree.d, tree.d.joints[static_cast<std::size_t>(first.index)], second.index);
  };
  const auto add = [&](std::string name, input::Dimension dimension, std::string doc, Quantity::Kind kind,
                       int index, int component = 0, bool usual = false) {
    Owner own = owner(kind, index);
    if (const auto [other, is_new] = taken.emplace(name, own); !is_new) {
      if (is_one_thing(other->second, own)) return;
      throw std::invalid_argument(
          fmt::format("\"{}\" is a quantity of {} and of {}: results would tell of one only; give one of "
                      "them another name",
                      name, other->second.what, own.what));
    }
    all.push_back({{std::move(name), dimension, std::move(doc), role_of(kind, component)},
                   kind,
                   index,
                   component,
                   usual});
  };
  using K = Quantity::Kind;
  // Sizes and forces on coordinates are usual, components are not.
  const auto add_outputs = [&](const std::string& name, const std::vector<OutputInfo>& outputs, K kind,
                               int index) {
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      const std::string& own = outputs[i].name;
      const bool is_component = own.size() > 2 && own[own.size() - 2] == '_' && own.back() >= 'x';
      add(name + "." + own, outputs[i].dimension, outputs[i].doc, kind, index, static_cast<int>(i),
          !is_component);
    }
  };
  for (std::size_t j = 0; j < tree.d.joints.size(); ++j) {
    const JointDescription& joint = tree.d.joints[j];
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
    if (joint.joint->n_rows() > 0) add_outputs(joint.name, wrench_outputs(true, true), K::reaction, k);
    for (const int index : joint.driven()) {
      const bool is_angle = speeds[index].dimension == dim::angular_velocity;
      add(joint.name + "." + joint.drive_force_name(index), is_angle ? dim::torque : dim::force,
          "force or torque of the drive along the coordinate", K::drive, k, index, true);
    }
  }
  for (std::size_t b = 1; b < tree.d.bodies.size(); ++b) {
    const std::string& name = tree.d.bodies[b].name;
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
    const FlexibleBody* deforms = tree.flexible(k);
    for (int i = 0; deforms && i < deforms->m(); ++i)
      add(fmt::format("{}.mode_{}", name, i + 1), dim::none, "modal coordinate", K::mode, k, i);
    if (deforms)
      add(name + ".strain_energy", dim::energy, "elastic energy of the body", K::strain_energy, k, 0, true);
    if (const StressField* stress = tree.d.bodies[b].stress.get()) {
      add(name + ".von_mises", dim::pressure, "largest von Mises stress on the body's surface",
          K::largest_stress, k, 0, true);
      for (int i = 0; i < 3; ++i)
        add(fmt::format("{}.von_mises_{}", name, axis_names[i]), dim::length,
            "where it is, in the undeformed body", K::largest_stress, k, 1 + i, true);
      if (stress->has_strain()) {
        add(name + ".strain", dim::none,
            "principal strain of the largest size on the body's surface, with its sign", K::largest_strain, k,
            0);
        for (int i = 0; i < 3; ++i)
          add(fmt::format("{}.strain_at_{}", name, axis_names[i]), dim::length,
              "where it is, in the undeformed body", K::largest_strain, k, 1 + i);
      }
      const char* components[] = {"xx", "yy", "zz", "xy", "yz", "zx"};
      for (std::size_t p = 0; p < stress->points().size(); ++p) {
        const std::string point = name + "." + stress->points()[p].name;
        const int first = Quantity::kOfPoint * static_cast<int>(p);
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
    if (const SurfacePoints* surface = tree.d.bodies[b].surface_points.get();
        surface && surface->has_everywhere()) {
      add(name + ".displacement", dim::length,
          "largest displacement by deformation on the body's surface, from where its floating frame takes it",
          K::largest_displacement, k, 0, true);
      for (int i = 0; i < 3; ++i)
        add(fmt::format("{}.displacement_at_{}", name, axis_names[i]), dim::length,
            "where it is, in the undeformed body", K::largest_displacement, k, 1 + i, true);
    }
    if (const SurfacePoints* surface = tree.d.bodies[b].surface_points.get())
      for (std::size_t p = 0; p < surface->points().size(); ++p) {
        const std::string point = name + "." + surface->points()[p].name;
        const int first = 7 * static_cast<int>(p);
        add(point + ".displacement", dim::length, "size of the displacement by deformation", K::surface_point,
            k, first + 6, true);
        for (int i = 0; i < 3; ++i)
          add(fmt::format("{}.displacement_{}", point, axis_names[i]), dim::length,
              "of the node by deformation, from where the body's floating frame takes it, in the body's axes",
              K::surface_point, k, first + i);
        for (int i = 0; i < 3; ++i)
          add(fmt::format("{}.position_{}", point, axis_names[i]), dim::length, "of the node, in the world",
              K::surface_point, k, first + 3 + i);
      }
    if (const SectionPoints* sections = tree.d.bodies[b].sections.get()) {
      const char* components[] = {"N", "V_y", "V_z", "T", "M_y", "M_z"};
      for (std::size_t p = 0; p < sections->points().size(); ++p)
        for (int i = 0; i < 6; ++i)
          add(fmt::format("{}.{}.{}", name, sections->points()[p].wanted.name, components[i]),
              i < 3 ? dim::force : dim::torque, sections->describe(static_cast<int>(p)), K::section_force, k,
              6 * static_cast<int>(p) + i, true);
    }
  }
  for (std::size_t i = 0; i < tree.d.measures.size(); ++i)
    add(tree.d.measures[i]->name(), tree.d.measures[i]->dimension(), "measure", K::measure,
        static_cast<int>(i), 0, true);
  for (std::size_t k = 0; k < rows.contacts().size(); ++k)
    add(rows.constraints()[rows.contacts()[k]]->name() + ".contact", dim::length,
        "where along its curve the point stands", K::contact, n_algebraic + static_cast<int>(k), 0, true);
  for (std::size_t i = 0; i < tree.d.inputs.size(); ++i)
    add(tree.d.inputs[i].name, unit_of(tree.d, tree.d.inputs[i].name), "input", K::input, static_cast<int>(i),
        0, true);
  for (std::size_t i = 0; i < tree.d.controls.size(); ++i)
    add(tree.d.controls[i]->name(), unit_of(tree.d, tree.d.controls[i]->name()), "output of the control",
        K::control, static_cast<int>(i), 0, true);
  for (std::size_t f = 0; f < tree.d.forces.size(); ++f) {
    const auto outputs = tree.d.forces[f]->outputs();
    for (std::size_t i = 0; i < outputs.size(); ++i)
      add(tree.d.forces[f]->name() + "." + outputs[i].name, outputs[i].dimension, outputs[i].doc, K::force,
          static_cast<int>(f), static_cast<int>(i), true);
  }
  for (std::size_t k = rows.first_own(); k < rows.constraints().size(); ++k)
    add_outputs(rows.constraints()[k]->name(), rows.constraints()[k]->outputs(), K::constraint,
                static_cast<int>(k));
  for (int i = 0; i < 3; ++i)
    add(fmt::format("momentum.linear_{}", axis_names[i]), linear_momentum,
        "of all bodies, in the world's axes", K::momentum, 0, 3 + i);
  for (int i = 0; i < 3; ++i)
    add(fmt::format("momentum.angular_{}", axis_names[i]), angular_momentum,
        "of all bodies, about the world's origin in its axes", K::momentum, 0, i);
  const char* energies[] = {"energy.kinetic", "energy.strain", "energy.potential", "energy.total"};
  const char* docs[] = {"kinetic energy", "elastic energy of flexible bodies",
                        "energy of gravity and springs", "kinetic + strain + potential"};
  for (int i = 0; i < 4; ++i) add(energies[i], dim::energy, docs[i], K::energy, 0, i, true);
  add("power.input", dim::power, "power of applied forces and drives", K::energy, 0, 4, true);
  add("power.dissipated", dim::power, "power taken out by dampers", K::energy, 0, 5, true);
  return all;
}

}  // namespace flexura::mbs
