// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "import/mjcf/model.hpp"

namespace flexura::import::mjcf {

/// What an actuator does, all kinds as the general one: force = (g_0 + g_1 length + g_2 rate) a + b_0 + b_1 length + b_2 rate of what it acts
/// through, `a` its control or what a filter or an integrator makes of it.
struct ActuatorLaw {
  enum class Activation { none, integrator, filter } activation = Activation::none;
  double time = 1.0;  ///< of the filter [s]
  std::vector<double> gear = {1.0}, gain = {1.0, 0.0, 0.0}, bias = {0.0, 0.0, 0.0};
  double damping_ratio = 0.0;  ///< instead of bias[2], once the inertia is known
  double armature = 0.0;
  std::optional<std::pair<double, double>> controls, forces;
  std::string unknown;  ///< why it cannot be taken over

  bool reads_motion() const;
  ActuatorLaw with_damping(double inertia) const;
  std::string force(const std::string& a, const std::string& length, const std::string& rate) const;
};

ActuatorLaw read_actuator(const Node& element, const Model& model, Findings& findings);

}  // namespace flexura::import::mjcf
