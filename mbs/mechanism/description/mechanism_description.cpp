// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/description/mechanism_description.hpp"

namespace flexura::mbs {

int MechanismDescription::add_body(BodyDescription body) {
  bodies.push_back(std::move(body));
  return static_cast<int>(bodies.size()) - 1;
}

int MechanismDescription::add_marker(int body, const std::string& marker_name, const Pose& X_BP, int node) {
  markers.push_back({bodies.at(body).name + "." + marker_name, body, X_BP, node});
  return static_cast<int>(markers.size()) - 1;
}

std::vector<int> JointDescription::driven() const {
  std::vector<int> all;
  if (rotation_drive) all = {0, 1, 2};
  for (const auto* one : {&drives, &speed_drives, &acceleration_drives})
    for (const auto& [coordinate, motion] : *one) all.push_back(coordinate);
  return all;
}

std::string JointDescription::driven_name(int speed) const {
  if (joint->n_p() > joint->n_v() && speed < 3) return joint->speeds()[static_cast<std::size_t>(speed)].name;
  return joint->coordinates()[static_cast<std::size_t>(coordinate_of_speed(speed))].name;
}

std::string JointDescription::drive_force_name(int speed) const {
  return driven().size() == 1 ? "drive_force" : "drive_force_" + driven_name(speed);
}

int MechanismDescription::add_joint(const std::string& joint_name, const std::string& type, int marker_F,
                                    int marker_M) {
  JointDescription joint;
  joint.name = joint_name;
  joint.joint = make_joint(type);
  joint.marker_F = marker_F;
  joint.marker_M = marker_M;
  joints.push_back(std::move(joint));
  return static_cast<int>(joints.size()) - 1;
}

Pose MechanismDescription::undeformed(int marker) const {
  const MarkerDescription& m = markers[static_cast<std::size_t>(marker)];
  const FlexibleBody* const flexible = bodies[static_cast<std::size_t>(m.body)].flexible.get();
  if (m.node < 0 || !flexible) return m.X_BP;
  return {m.X_BP.R, flexible->nodes()[static_cast<std::size_t>(m.node)].p_BoN_B + m.X_BP.p};
}

void MechanismDescription::make_rigid(int body) {
  BodyDescription& b = bodies[static_cast<std::size_t>(body)];
  if (!b.flexible) return;
  for (std::size_t i = 0; i < markers.size(); ++i)
    if (markers[i].body == body) {
      markers[i].X_BP = undeformed(static_cast<int>(i));
      markers[i].node = -1;
    }
  b.inertia = b.flexible->undeformed_inertia();
  b.flexible = nullptr;
  b.stress = nullptr;
  b.sections = nullptr;
}

}  // namespace flexura::mbs
