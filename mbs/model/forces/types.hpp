// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/input/schema.hpp"
#include "mbs/model/force.hpp"
#include "mbs/model/read_context.hpp"

/// The types of force elements and measures: one file each, listed here and in registry.cpp.
namespace flexura::mbs {

/// How a type stands in the file; `keys` beside type.
template <class Element>
struct ElementType {
  std::string name;
  std::string doc;
  std::vector<input::Key> keys;
  std::shared_ptr<const Element> (*read)(const std::string& name, const input::Section&, const ReadContext&);
};
using ForceType = ElementType<ForceElement>;
using MeasureType = ElementType<Measure>;
using ConstraintType = ElementType<Constraint>;

const std::vector<ForceType>& force_types();
const std::vector<MeasureType>& measure_types();

ForceType spring_damper_force();
ForceType expression_force();
ForceType expression_torque();
ForceType joint_force();
ForceType joint_spring_damper_force();
ForceType joint_friction_force();
ForceType bushing_force();
ForceType contact_force();
ForceType bump_stop_force();
ForceType gear_mesh_force();
ForceType stick_slip_force();
ForceType actuator_force();
ForceType distributed_load_force();
/// K and D as in its file: translations first, in the axes of marker F.
std::shared_ptr<const ForceElement> make_bushing(const std::string& name, int marker_F, int marker_M,
                                                 const Matrix6d& K, const Matrix6d& D);

MeasureType distance_measure();
MeasureType distance_rate_measure();
MeasureType position_measure();
MeasureType axis_measure();
MeasureType velocity_measure();
MeasureType angle_measure();
MeasureType angular_velocity_measure();
MeasureType expression_measure();

}  // namespace flexura::mbs
