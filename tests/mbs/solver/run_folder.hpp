// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdlib>

#include "tests/mbs/test_folder.hpp"

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

/// Mechanism files in a folder of their own, and the program run in it.
class RunFolder : public TestFolder {
 protected:
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
};

}  // namespace flexura::mbs::test
