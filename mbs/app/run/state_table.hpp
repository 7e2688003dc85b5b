// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include "mbs/solver/start/prepare.hpp"

/// The prepared state as people read it: units of its names, round-off as 0.
namespace flexura::app {

class StateText {
 public:
  explicit StateText(const mbs::PreparedMechanism& prepared);

  /// "arm.angle [rad]": a position coordinate, a velocity, a row's multiplier with its unit; quaternions are "[-]".
  std::string position_name(int i) const;
  std::string velocity_name(int i) const;
  std::string multiplier_name(int i) const;

  /// A dynamic or algebraic state, with its unit where results have one.
  std::string other_name(const std::string& name) const;

  /// Their values. A displacement, a speed, an acceleration that moves nothing by more than 1e-13 of the mechanism's
  /// size, of its fastest motion, of its largest acceleration (or gravity) is round-off and printed as 0.
  std::string position(int i, int digits) const;
  std::string velocity(int i, int digits) const;
  std::string acceleration(int i, int digits) const;
  std::string multiplier(int i, int digits) const;

 private:
  std::string unit_of(const std::string& name) const;

  const mbs::PreparedMechanism& p_;
  std::vector<std::pair<std::string, std::string>> units_;  // of quantities, sorted by name
  double length_, speed_, acceleration_, multiplier_;       // what is large
};

}  // namespace flexura::app
