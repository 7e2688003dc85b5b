// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/types.hpp"
#include "mbs/model/user_library.hpp"

namespace flexura::mbs {

const std::vector<ForceType>& force_types() {
  static const std::vector<ForceType> types = {
      spring_damper_force(),       expression_force(),     expression_torque(), joint_force(),
      joint_spring_damper_force(), joint_friction_force(), bushing_force(),     contact_force(),
      bump_stop_force(),           gear_mesh_force(),      stick_slip_force(),  actuator_force(),
      distributed_load_force(),    user_force(),
  };
  return types;
}

const std::vector<MeasureType>& measure_types() {
  static const std::vector<MeasureType> types = {
      distance_measure(), distance_rate_measure(), position_measure(),         axis_measure(),
      velocity_measure(), angle_measure(),         angular_velocity_measure(), expression_measure(),
  };
  return types;
}

}  // namespace flexura::mbs
