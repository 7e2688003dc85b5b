// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/mbs/cases/case_run.hpp"
#include "tests/mbs/test_folder.hpp"

namespace flexura::mbs::cases {

/// Mechanisms written in the test, each in a folder of its own.
class TextCase : public test::TestFolder {
 protected:
  PreparedMechanism prepared(const std::string& text) const { return prepare(file(text)); }
  std::string refusal(const std::string& text) const {
    return test::refusal_of([&] { prepared(text); });
  }
};

inline const std::string wheel = R"toml(
gravity = [0, 0, 0]
[body.wheel]
mass = 2
inertia = [1, 1, 0.5]
[joint.axle]
type = "revolute"
from = "ground"
to = "wheel"
)toml";
inline const std::string solver = "[solver]\nend_time = 2\noutput_step = 0.1\ntolerance = 1e-10\n";

}  // namespace flexura::mbs::cases
