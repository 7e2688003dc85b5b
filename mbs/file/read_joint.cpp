// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_joint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/user_library.hpp"

namespace flexura::mbs {

using input::Section;

namespace {

bool can_be_driven(const JointDescription& joint) {
  return !joint.is_connection && joint.joint->n_p() == joint.joint->n_v();
}

std::string drive_key(const std::vector<CoordinateInfo>& coordinates, std::size_t i) {
  return coordinates.size() == 1 ? "drive" : "drive_" + coordinates[i].name;
}

/// A quaternion of zeros, as far as it is given; without that it is (1, 0, 0, 0).
void refuse_no_rotation(const Section& s, const std::vector<CoordinateInfo>& coordinates) {
  if (coordinates.size() < 4 || coordinates[0].name != "qw" || !s.has("qw") || s.quantity("qw") != 0.0)
    return;
  for (const char* key : {"qx", "qy", "qz"})
    if (s.has(key) && s.quantity(key) != 0.0) return;
  s.refuse("qw", "qw, qx, qy and qz are all zero, which is no rotation", "qw = 1 is that of no turn");
}

void refuse_contradicting_drives(const Section& s, const JointDescription& joint) {
  if (!can_be_driven(joint)) return;
  const auto coordinates = joint.joint->coordinates(), speeds = joint.joint->speeds(),
             accelerations = joint.joint->accelerations();
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const std::string drive = drive_key(coordinates, i), by_speed = "drive_" + speeds[i].name,
                      by_acceleration = "drive_" + accelerations[i].name;
    if (s.has(drive))
      for (const std::string& key : {coordinates[i].name, speeds[i].name})
        if (s.has(key)) s.refuse(key, "the coordinate is driven", "take this key away");
    if (s.has(drive) + s.has(by_speed) + s.has(by_acceleration) > 1)
      s.refuse(s.has(by_acceleration) ? by_acceleration : by_speed, "the coordinate is driven twice",
               "keep one of the drives");
    if (s.has(by_speed) && s.has(speeds[i].name))
      s.refuse(speeds[i].name, "the speed is driven", "take this key away");
  }
}

/// Formulas of a user's joint, whose coordinates the schema does not know, by their places in `infos`.
std::map<int, std::string> by_name(const Section& s, const char* key,
                                   const std::vector<CoordinateInfo>& infos) {
  std::map<int, std::string> formulas;
  for (const auto& [name, formula] : s.formulas(key)) {
    std::vector<std::string> known;
    int index = -1;
    for (std::size_t i = 0; i < infos.size(); ++i) {
      known.push_back(infos[i].name);
      if (infos[i].name == name) index = static_cast<int>(i);
    }
    if (index < 0)
      s.refuse(key, fmt::format("the joint has no \"{}\"{}", name, input::suggestion(name, known)));
    formulas[index] = formula;
  }
  return formulas;
}

void read_user_joint(const Section& s, const ReadContext& context, JointDescription& joint) {
  const Joint& type = *joint.joint;
  const auto coordinates = type.coordinates(), speeds = type.speeds(), accelerations = type.accelerations();
  for (const auto& [k, formula] : by_name(s, "start", coordinates))
    joint.initial_coordinates[k] = context.number_of(s, "start", formula);
  for (const auto& [k, formula] : by_name(s, "start_speed", speeds))
    joint.initial_speeds[k] = context.number_of(s, "start_speed", formula);
  std::set<int> driven;
  for (const auto& [key, infos] : {std::pair("drive", &coordinates), std::pair("drive_speed", &speeds),
                                   std::pair("drive_acceleration", &accelerations)})
    for (const auto& [k, formula] : by_name(s, key, *infos)) {
      if (type.n_p() != type.n_v())
        s.refuse(key, "the joint has more coordinates than speeds", "drive it by a force or a constraint");
      if (!driven.insert(k).second) s.refuse(key, "the coordinate is driven twice", "keep one of the drives");
      const bool of_position = std::string_view(key) == "drive";
      if (joint.initial_coordinates.contains(k) && of_position)
        s.refuse("start", "the coordinate is driven", "take it away");
      if (joint.initial_speeds.contains(k) && std::string_view(key) != "drive_acceleration")
        s.refuse("start_speed", "the speed is driven", "take it away");
    }
}

/// The speed that an acceleration of signals makes: a state of its own, "JOINT.driven_SPEED" in formulas.
std::shared_ptr<const Expression> speed_by_state(const Section& s, const std::string& key,
                                                 const ReadContext& context, const JointDescription& joint,
                                                 int k, std::shared_ptr<const Expression> acceleration) {
  const auto given = joint.initial_speeds.find(k);
  return context.state_expression(
      s, key, joint.name + ".driven_" + joint.joint->speeds()[static_cast<std::size_t>(k)].name,
      std::move(acceleration), given == joint.initial_speeds.end() ? 0.0 : given->second);
}

}  // namespace

JointDescription read_joint(const std::string& name, const Section& s, const ReadContext& context,
                            bool is_connection) {
  JointDescription joint;
  joint.is_connection = is_connection;
  joint.name = name;
  const std::string type = s.text("type");
  for (const JointType& t : joint_types())
    if (t.name == type || std::ranges::find(t.synonyms, type) != t.synonyms.end()) joint.joint = t.make(&s);
  if (type == "user") joint.joint = make_user_joint(name, s, context);
  joint.marker_F = context.marker(s, "from");
  joint.marker_M = context.marker(s, "to");
  const auto& markers = context.description().markers;
  if (markers[joint.marker_F].body == markers[joint.marker_M].body)
    s.refuse("to", fmt::format("\"{}\" is a marker of the same body as \"{}\"", s.text("to"), s.text("from")),
             "a joint joins two bodies");
  if (!is_connection && s.has("cut")) {
    joint.cut = s.flag("cut");
    joint.keep_in_tree = !joint.cut;
  }
  const auto coordinates = joint.joint->coordinates(), speeds = joint.joint->speeds();
  if (type == "user") {
    read_user_joint(s, context, joint);
    return joint;
  }
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const int k = static_cast<int>(i);
    if (s.has(coordinates[i].name)) joint.initial_coordinates[k] = s.quantity(coordinates[i].name);
  }
  refuse_no_rotation(s, coordinates);
  refuse_contradicting_drives(s, joint);
  for (std::size_t i = 0; i < speeds.size(); ++i)
    if (s.has(speeds[i].name)) joint.initial_speeds[static_cast<int>(i)] = s.quantity(speeds[i].name);
  return joint;
}

void read_drives(const Section& s, const ReadContext& context, JointDescription& joint) {
  const auto coordinates = joint.joint->coordinates(), speeds = joint.joint->speeds(),
             accelerations = joint.joint->accelerations();
  const auto by_acceleration = [&](int k, const std::string& key, const std::string& formula) {
    auto f = context.motion_expression_of(s, key, formula);
    if (f->reads().empty())
      joint.acceleration_drives[k] = std::move(f);
    else
      joint.speed_drives[k] = speed_by_state(s, key, context, joint, k, std::move(f));
  };
  if (s.text("type") == "user") {
    for (const auto& [k, formula] : by_name(s, "drive", coordinates))
      joint.drives[k] = context.motion_expression_of(s, "drive", formula);
    for (const auto& [k, formula] : by_name(s, "drive_speed", speeds))
      joint.speed_drives[k] = context.motion_expression_of(s, "drive_speed", formula);
    for (const auto& [k, formula] : by_name(s, "drive_acceleration", accelerations))
      by_acceleration(k, "drive_acceleration", formula);
    return;
  }
  if (!can_be_driven(joint)) return;
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    const int k = static_cast<int>(i);
    if (const std::string key = drive_key(coordinates, i); s.has(key))
      joint.drives[k] = context.motion_expression(s, key);
    if (const std::string key = "drive_" + speeds[i].name; s.has(key))
      joint.speed_drives[k] = context.motion_expression(s, key);
    if (const std::string key = "drive_" + accelerations[i].name; s.has(key))
      by_acceleration(k, key, s.text(key));
  }
}

}  // namespace flexura::mbs
