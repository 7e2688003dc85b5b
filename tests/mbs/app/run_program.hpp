// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

/// Runs a command line in the shell and returns what it printed and its exit code.
namespace flexura::testing {

struct Outcome {
  int code = -1;
  std::string out, err;
};

inline Outcome run_program(const std::string& command) {
  const std::filesystem::path errors =
      std::filesystem::temp_directory_path() / ("flexura_err_" + std::to_string(::getpid()));
  Outcome outcome;
  std::FILE* pipe = ::popen((command + " 2>" + errors.string()).c_str(), "r");
  std::array<char, 4096> block;
  for (std::size_t n; (n = std::fread(block.data(), 1, block.size(), pipe)) > 0;)
    outcome.out.append(block.data(), n);
  const int status = ::pclose(pipe);
  outcome.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  std::ifstream in(errors);
  outcome.err.assign((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  std::filesystem::remove(errors);
  return outcome;
}

}  // namespace flexura::testing
