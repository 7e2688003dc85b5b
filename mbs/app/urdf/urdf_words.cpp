// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/app/urdf/urdf_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace flexura::app {
namespace {

UrdfWords::Coordinate key(const mbs::CoordinateRef& c) {
  return {c.joint, c.index};
}

}  // namespace

UrdfWords::UrdfWords(const mbs::MechanismDescription& d) {
  for (const auto& force : d.forces) {
    const auto* const says = dynamic_cast<const mbs::HasRobotWords*>(force.get());
    const auto words = says ? says->joint_words() : std::nullopt;
    // A free joint has several freedoms in one joint of the URDF, which has no words for each of them.
    if (!words || d.joints[static_cast<std::size_t>(words->coordinate.joint)].joint->n_v() == 6) {
      left_out_.push_back(force->name());
      continue;
    }
    mbs::JointWords& all = words_[key(words->coordinate)];
    all.damping += words->damping;
    all.friction += words->friction;
    all.lower = std::max(all.lower, words->lower);
    all.upper = std::min(all.upper, words->upper);
    all.stiffness = std::max(all.stiffness, words->stiffness);
  }
  for (const auto& constraint : d.constraints) {
    const auto* const says = dynamic_cast<const mbs::HasRobotWords*>(constraint.get());
    const auto words = says ? says->mimic_words() : std::nullopt;
    if (!words)
      throw std::invalid_argument(fmt::format(
          "constraint \"{}\": a URDF has joints only, and one that mimics another (a coupler of two "
          "joints with a constant offset); take the constraint away",
          constraint->name()));
    add_mimic(constraint->name(), *words);
  }
  for (const mbs::JointDescription& joint : d.joints)
    if (joint.is_driven()) driven_.push_back(joint.name);
}

void UrdfWords::add_mimic(const std::string& name, mbs::MimicWords words) {
  // One joint mimics one other: where the first of the two does already, the second may.
  if (mimics_.contains(key(words.coordinate)) && words.multiplier != 0.0)
    words = {.coordinate = words.of,
             .of = words.coordinate,
             .multiplier = 1.0 / words.multiplier,
             .offset = -words.offset / words.multiplier};
  std::set<Coordinate> met = {key(words.coordinate)};
  for (Coordinate at = key(words.of);; at = key(mimics_.at(at).of)) {
    if (!met.insert(at).second || mimics_.contains(key(words.coordinate)))
      throw std::invalid_argument(fmt::format(
          "constraint \"{}\": in a URDF a joint mimics one other, and not itself in a ring; take the "
          "constraint away",
          name));
    if (!mimics_.contains(at)) break;
  }
  mimics_[key(words.coordinate)] = words;
}

const mbs::JointWords* UrdfWords::of(Coordinate c) const {
  const auto found = words_.find(c);
  return found == words_.end() ? nullptr : &found->second;
}

const mbs::MimicWords* UrdfWords::mimic(Coordinate c) const {
  const auto found = mimics_.find(c);
  return found == mimics_.end() ? nullptr : &found->second;
}

}  // namespace flexura::app
