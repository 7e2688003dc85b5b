// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/mbs/random/scene/scene.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

namespace flexura::mbs::chance {

struct JudgeOptions {
  std::string file;  ///< where the mechanism is written, without ".toml" and what tells its writings apart
  bool other_files = true;     ///< the same mechanism in other units and orders
  bool other_commands = true;  ///< statics, modes, linearisation
};

struct Judgement {
  std::string end;                      ///< "complete", "stopped: ...", "refused: ..."
  std::string nature;                   ///< what scene_physics.hpp says
  std::vector<std::string> complaints;  ///< each one sentence: what was wrong
  /// Largest of the run: rows, rates and accelerations against scene_physics.hpp, energy that is not conserved,
  /// momentum, difference of two integrators.
  double rows = 0.0, rates = 0.0, accelerations = 0.0, energy = 0.0, balance = 0.0, momentum = 0.0,
         integrators = 0.0, files = 0.0;
  int warnings = 0;  ///< runs that warned of rows near rank loss
};

/// Runs the scene in every way and asks whether it ended right, or with a message where it may.
Judgement judge(const Scene& scene, const JudgeOptions& options);

}  // namespace flexura::mbs::chance
