// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "mbs/kinematics/robot_words.hpp"
#include "mbs/mechanism/mechanism.hpp"

namespace flexura::app {

/// What a URDF says of joints beside their axes: limits, damping, friction, mimic; from the forces and constraints on their coordinates.
class UrdfWords {
 public:
  using Coordinate = std::pair<int, int>;  ///< joint, index

  /// Throws std::invalid_argument, naming it, for a constraint that is no mimicking of one joint by another.
  explicit UrdfWords(const mbs::MechanismDescription& d);

  /// All elements on the coordinate together.
  const mbs::JointWords* of(Coordinate c) const;
  /// What the coordinate mimics, or null.
  const mbs::MimicWords* mimic(Coordinate c) const;
  /// Forces that have no word, and joints that a formula drives.
  const std::vector<std::string>& left_out() const { return left_out_; }
  const std::vector<std::string>& driven() const { return driven_; }

 private:
  void add_mimic(const std::string& name, mbs::MimicWords words);
  std::map<Coordinate, mbs::JointWords> words_;
  std::map<Coordinate, mbs::MimicWords> mimics_;
  std::vector<std::string> left_out_, driven_;
};

}  // namespace flexura::app
