// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <limits>
#include <optional>

#include "mbs/kinematics/kinematics.hpp"

/// What elements on joint coordinates are in the words that robot descriptions (URDF) have for them: <limit>, <dynamics>, <mimic>.
namespace flexura::mbs {

/// All that the element does along one coordinate; SI.
struct JointWords {
  CoordinateRef coordinate;
  double damping = 0.0;   ///< force per speed
  double friction = 0.0;  ///< Coulomb's force
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
  double stiffness = 0.0;  ///< of what is met at lower and upper
};

/// coordinate = multiplier * of + offset.
struct MimicWords {
  CoordinateRef coordinate, of;
  double multiplier = 1.0, offset = 0.0;
};

/// Elements that may have such words derive from this, too.  Nothing: these words do not say what it does.
class HasRobotWords {
 public:
  virtual ~HasRobotWords() = default;
  virtual std::optional<JointWords> joint_words() const { return std::nullopt; }
  virtual std::optional<MimicWords> mimic_words() const { return std::nullopt; }
};

}  // namespace flexura::mbs
