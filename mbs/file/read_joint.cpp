// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/file/read_joint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

#include "mbs/base/math/rotation_sequences.hpp"
#include "mbs/file/elements/element_types.hpp"
#include "mbs/file/elements/user_library.hpp"

namespace flexura::mbs {

using input::Section;

namespace {

constexpr std::array kRotationVector = {"drive_rotation_x", "drive_rotation_y", "drive_rotation_z"};
constexpr std::array kAngles = {"drive_angle_1", "drive_angle_2", "drive_angle_3"};

bool has_any(const Section& s, const std::array<const char*, 3>& keys) {
  return std::ranges::any_of(keys, [&](const char* key) { return s.has(key); });
}

/// The coordinate whose rate the speed i is; a ball's angular velocity is that of none.
const CoordinateInfo* coordinate_of(const Joint& joint, const std::vector<CoordinateInfo>& coordinates,
                                    int i) {
  const int extra = joint.n_p() - joint.n_v();
  return extra > 0 && i < 3 ? nullptr : &coordinates[static_cast<std::size_t>(i + extra)];
}

std::string drive_key(const std::vector<CoordinateInfo>& coordinates, const CoordinateInfo& driven) {
  return coordinates.size() == 1 ? "drive" : "drive_" + driven.name;
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
  const auto coordinates = joint.joint->coordinates(), speeds = joint.joint->speeds(),
             accelerations = joint.joint->accelerations();
  const bool turns = joint.joint->n_p() > joint.joint->n_v();
  const bool by_vector = turns && has_any(s, kRotationVector), by_angles = turns && has_any(s, kAngles);
  if (by_vector && by_angles)
    s.refuse("drive_angle_1", "the rotation is driven twice, by angles and by a rotation vector",
             "keep one of them");
  if (turns && s.has("drive_sequence") && !by_angles)
    s.refuse("drive_sequence", "goes with drive_angle_1, drive_angle_2, drive_angle_3 only",
             "drive these, or take it away");
  for (std::size_t i = 0; turns && (by_vector || by_angles) && i < 4; ++i)
    for (const std::string& key : {coordinates[i].name, i < 3 ? speeds[i].name : coordinates[i].name})
      if (s.has(key)) s.refuse(key, "the rotation is driven", "take this key away");
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const CoordinateInfo* const q = coordinate_of(*joint.joint, coordinates, static_cast<int>(i));
    const std::string by_speed = "drive_" + speeds[i].name,
                      by_acceleration = "drive_" + accelerations[i].name;
    const bool drives = q ? s.has(drive_key(coordinates, *q)) : by_vector || by_angles;
    if (q && drives)
      for (const std::string& key : {q->name, speeds[i].name})
        if (s.has(key)) s.refuse(key, "the coordinate is driven", "take this key away");
    if (drives + s.has(by_speed) + s.has(by_acceleration) > 1)
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

std::optional<PrescribedRotation> read_rotation_drive(const Section& s, const ReadContext& context) {
  const bool by_angles = has_any(s, kAngles);
  if (!by_angles && !has_any(s, kRotationVector)) return {};
  std::array<Prescribed, 3> q;
  for (std::size_t i = 0; i < 3; ++i) {
    const char* const key = by_angles ? kAngles[i] : kRotationVector[i];
    q[i] = s.has(key) ? context.motion_expression(s, key)
                      : context.time_expression_of(s, by_angles ? kAngles[0] : kRotationVector[0], "0");
  }
  if (!by_angles) return PrescribedRotation(std::move(q), {});
  return PrescribedRotation(std::move(q), axes_of_sequence(s.text("drive_sequence")));
}

}  // namespace

std::string component_of(const std::string& name) {
  if (name == "qw" || name == "qx" || name == "qy" || name == "qz")
    return ", of the quaternion (w, x, y, z) that turns F's axes into M's";
  const char last = name.back();
  const bool is_component =
      (last == 'x' || last == 'y' || last == 'z') && (name.size() == 1 || name[name.size() - 2] == '_');
  return is_component ? ", of M as seen from F, in the axes of F" : "";
}

std::vector<input::Key> drive_keys(const Joint& joint) {
  using namespace input;
  std::vector<Key> keys;
  const auto coordinates = joint.coordinates(), speeds = joint.speeds(),
             accelerations = joint.accelerations();
  const auto add = [&](const std::string& key, const Dimension& dimension, const std::string& doc) {
    keys.push_back(expression(key, dimension, doc));
  };
  constexpr const char* of_what =
      ": a formula of t, parameters, inputs, states of controls and algebraic states of these";
  for (int i = 0; i < joint.n_v(); ++i)
    if (const CoordinateInfo* q = coordinate_of(joint, coordinates, i))
      add(drive_key(coordinates, *q), q->dimension,
          "drives the coordinate \"" + q->name + "\"" + component_of(q->name) + of_what);
  for (const auto& [infos, what] : {std::pair(&speeds, "speed"), std::pair(&accelerations, "acceleration")})
    for (const CoordinateInfo& c : *infos)
      add("drive_" + c.name, c.dimension,
          fmt::format("drives this {} instead{}: a formula of t, parameters and signals", what,
                      component_of(c.name)));
  if (joint.n_p() == joint.n_v()) return keys;
  for (std::size_t i = 0; i < 3; ++i)
    add(kRotationVector[i], dim::angle,
        fmt::format("drives the rotation, by the {} component of the rotation vector (axis times angle) of M "
                    "in the axes "
                    "of F; 0 where another is given{}",
                    "xyz"[i], of_what));
  for (std::size_t i = 0; i < 3; ++i)
    add(kAngles[i], dim::angle,
        fmt::format("drives the rotation instead by turns about three axes, each turned by those before it: "
                    "turn {}; 0 "
                    "where another is given{}",
                    i + 1, of_what));
  keys.push_back(
      choice("drive_sequence", rotation_sequences(), "axes of drive_angle_1, drive_angle_2, drive_angle_3")
          .or_default("xyz"));
  return keys;
}

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
  if (joint.joint->n_p() > joint.joint->n_v()) joint.rotation_drive = read_rotation_drive(s, context);
  for (std::size_t i = 0; i < speeds.size(); ++i) {
    const int k = static_cast<int>(i);
    const CoordinateInfo* const q = coordinate_of(*joint.joint, coordinates, k);
    if (const std::string key = q ? drive_key(coordinates, *q) : ""; q && s.has(key))
      joint.drives[k] = context.motion_expression(s, key);
    if (const std::string key = "drive_" + speeds[i].name; s.has(key))
      joint.speed_drives[k] = context.motion_expression(s, key);
    if (const std::string key = "drive_" + accelerations[i].name; s.has(key))
      by_acceleration(k, key, s.text(key));
  }
}

}  // namespace flexura::mbs
