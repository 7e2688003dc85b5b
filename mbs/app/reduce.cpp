// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "mbs/app/commands.hpp"

namespace flexura::app {

std::filesystem::path program_folder() {
  std::error_code failure;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", failure);
  return failure ? std::filesystem::path(".") : self.parent_path();
}

void hand_over(const std::string& companion, const std::vector<std::string>& arguments) {
  const std::filesystem::path program = program_folder() / companion;
  if (::access(program.c_str(), X_OK) != 0) {
    throw std::runtime_error(program.string() +
                             ": this program is not there; build it with \"cmake --build BUILD --target " +
                             companion + "\" or copy it beside flexura");
  }
  std::vector<std::string> words = {program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(program.c_str(), argv.data());
  throw std::runtime_error(program.string() + ": cannot be started: " + std::strerror(errno) +
                           "; install the program again");
}

// main() hands over before any command is read; these entries are for the list of commands and
// "flexura help reduce".
terminal::Command reduce_command() {
  return {"reduce", "make a superelement of a CAD part, a mesh or a beam model (by flexura-reduce)",
          [](terminal::Options&, const terminal::Verbosity&) -> std::function<int()> {
            hand_over("flexura-reduce", {"--help"});
          },
          "flexura-reduce"};
}

terminal::Command section_command() {
  return {"section", "constants of any cross-section, for beams (by flexura-reduce)",
          [](terminal::Options&, const terminal::Verbosity&) -> std::function<int()> {
            hand_over("flexura-reduce", {"section", "--help"});
          },
          "flexura-reduce section"};
}

terminal::Command import_command() {
  return {"import", "make a mechanism of a robot (URDF, MJCF, SDF) or a CAD assembly (by flexura-import)",
          [](terminal::Options&, const terminal::Verbosity&) -> std::function<int()> {
            hand_over("flexura-import", {"--help"});
          },
          "flexura-import"};
}

}  // namespace flexura::app
