// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/read_context.hpp"

#include <fmt/format.h>

namespace flexura::mbs {
namespace {

std::shared_ptr<const Expression> compile(const input::Section& section, const std::string& key,
                                          const SignalNames& signals,
                                          const std::map<std::string, double>& constants) {
  const std::string path = section.path() + "." + key;
  try {
    return std::make_shared<Expression>(path, section.text(key), signals, constants);
  } catch (const std::invalid_argument& error) {
    // The message opens with the path; in the file it also has a line.
    const std::string where = section.where(key);
    const std::string place = where.ends_with(path) ? where.substr(0, where.size() - path.size()) : "";
    throw input::InputError(place + error.what());
  }
}

}  // namespace

int ReadContext::body(const input::Section& section, const std::string& key) const {
  const std::string name = section.text(key);
  std::vector<std::string> known;
  for (std::size_t b = 0; b < d_.bodies.size(); ++b) {
    if (d_.bodies[b].name == name) return static_cast<int>(b);
    known.push_back(d_.bodies[b].name);
  }
  section.refuse(key, fmt::format("there is no body \"{}\"{}", name, input::suggestion(name, known)));
}

int ReadContext::marker(const input::Section& section, const std::string& key) const {
  const std::string name = section.text(key);
  for (std::size_t i = 0; i < d_.markers.size(); ++i)
    if (d_.markers[i].name == name) return static_cast<int>(i);
  const std::string body_name = name.substr(0, name.find('.'));
  std::vector<std::string> bodies, markers;
  int body = -1;
  for (std::size_t b = 0; b < d_.bodies.size(); ++b) {
    bodies.push_back(d_.bodies[b].name);
    if (bodies.back() == body_name) body = static_cast<int>(b);
  }
  if (body < 0)
    section.refuse(key,
                   fmt::format("there is no body \"{}\"{}", body_name, input::suggestion(body_name, bodies)));
  if (name == body_name) {
    const std::string frame = body_name + ".frame";
    for (std::size_t i = 0; i < d_.markers.size(); ++i)
      if (d_.markers[i].name == frame) return static_cast<int>(i);
    return d_.add_marker(body, "frame");
  }
  for (const MarkerDescription& marker : d_.markers)
    if (marker.body == body) markers.push_back(marker.name);
  section.refuse(key, fmt::format("body \"{}\" has no marker \"{}\"{}", body_name,
                                  name.substr(std::min(name.size(), body_name.size() + 1)),
                                  input::suggestion(name, markers)));
}

int ReadContext::joint(const input::Section& section, const std::string& key) const {
  const std::string name = section.text(key);
  std::vector<std::string> known;
  for (std::size_t j = 0; j < d_.joints.size(); ++j) {
    if (d_.joints[j].name == name) return static_cast<int>(j);
    known.push_back(d_.joints[j].name);
  }
  section.refuse(key, fmt::format("there is no joint \"{}\"{}", name, input::suggestion(name, known)));
}

CoordinateRef ReadContext::speed(const input::Section& section, const std::string& joint_key,
                                 const std::string& coordinate_key) const {
  const std::string joint = section.text(joint_key);
  if (!section.has(coordinate_key)) return coordinate(section, joint_key, joint);
  return coordinate(section, joint_key, joint + "." + section.text(coordinate_key));
}

CoordinateRef ReadContext::coordinate(const input::Section& section, const std::string& key,
                                      const std::string& name) const {
  const std::string joint_name = name.substr(0, name.find('.'));
  std::vector<std::string> known;
  int j = -1;
  for (std::size_t k = 0; k < d_.joints.size(); ++k) {
    if (d_.joints[k].name == joint_name) j = static_cast<int>(k);
    known.push_back(d_.joints[k].name);
  }
  if (j < 0)
    section.refuse(
        key, fmt::format("there is no joint \"{}\"{}", joint_name, input::suggestion(joint_name, known)));
  const Joint& joint = *d_.joints[j].joint;
  if (joint.n_p() != joint.n_v() || joint.n_v() == 0)
    section.refuse(key, fmt::format("a {} joint has no coordinate that can be acted on alone", joint.type()),
                   "use a force or torque at a marker");
  const auto coordinates = joint.coordinates();
  if (name == joint_name) {
    if (coordinates.size() == 1) return {j, 0};
    std::string names;
    for (const CoordinateInfo& c : coordinates) names += (names.empty() ? "\"" : ", \"") + c.name + "\"";
    section.refuse(key, fmt::format("a {} joint has the coordinates {}", joint.type(), names),
                   "say which is meant");
  }
  const std::string wanted = name.substr(joint_name.size() + 1);
  known.clear();
  for (std::size_t i = 0; i < coordinates.size(); ++i) {
    if (coordinates[i].name == wanted) return {j, static_cast<int>(i)};
    known.push_back(coordinates[i].name);
  }
  section.refuse(key, fmt::format("joint \"{}\" has no coordinate \"{}\"{}", joint_name, wanted,
                                  input::suggestion(wanted, known)));
}

std::shared_ptr<const Expression> ReadContext::expression(const input::Section& section,
                                                          const std::string& key) const {
  return compile(section, key, d_.signals, parameters_);
}

std::shared_ptr<const Expression> ReadContext::time_expression(const input::Section& section,
                                                               const std::string& key) const {
  return compile(section, key, SignalNames(), parameters_);
}

double ReadContext::number(const input::Section& section, const std::string& key) const {
  const double at_start = 0.0;
  try {
    return time_expression(section, key)->evaluate(&at_start);
  } catch (const input::InputError&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw input::InputError(section.where(key) + ": " + error.what());
  }
}

}  // namespace flexura::mbs
