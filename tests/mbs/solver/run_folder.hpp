// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace flexura::mbs::test {

/// A rod of 1 m and 2 kg on a hinge at the origin, 20 degrees above the x axis; J = 2/3 kg m^2 about the
/// hinge.
inline const std::string rod = R"toml(
name = "rod"
gravity = [0, -9.81, 0]
[body.rod]
mass = 2
center = [0.5, 0, 0]
inertia = [1e-3, 0.16666666666666667, 0.16666666666666667]
[joint.hinge]
type = "revolute"
from = "ground"
to = "rod"
angle = "20 deg"
)toml";

/// A folder of its own for each test, with mechanism files and the program run in it.
class RunFolder : public ::testing::Test {
 protected:
  RunFolder() {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("flexura_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::create_directories(folder_);
  }
  ~RunFolder() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path file(const std::string& text, const char* name = "m.toml") const {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  int flexura(const std::string& arguments) const {
    const std::string command =
        "cd " + folder_.string() + " && " FLEXURA_BIN_DIR "/flexura " + arguments + " > out.txt 2> err.txt";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string text_of(const char* name) const {
    std::ifstream in(folder_ / name);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  std::filesystem::path folder_;
};

}  // namespace flexura::mbs::test
