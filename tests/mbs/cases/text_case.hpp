// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <fstream>

#include "tests/mbs/cases/case_run.hpp"

namespace flexura::mbs::cases {

/// Mechanisms written in the test, each in a folder of its own.
class TextCase : public ::testing::Test {
 protected:
  TextCase() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("flexura_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::create_directories(folder_);
  }
  ~TextCase() override { std::filesystem::remove_all(folder_); }
  PreparedMechanism prepared(const std::string& text) const {
    std::ofstream(folder_ / "m.toml") << text;
    return prepare(folder_ / "m.toml");
  }
  std::string refusal(const std::string& text) const {
    try {
      prepared(text);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "accepted";
  }
  std::filesystem::path folder_;
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
