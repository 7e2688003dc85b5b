// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "cases/assembly/drawing.hpp"
#include "tests/import/robot_run.hpp"

namespace flexura::test {

/// What the import of an assembly told.
struct Import {
  Outcome outcome;
  std::string mechanism;
  std::map<std::string, std::string> joints;  ///< name and type, but for that to the ground
  int freedom = -1;
};

inline Import import(const Folder& folder, const std::string& step, std::vector<std::string> words = {}) {
  Import result;
  words.insert(words.begin(), {"import", step, "-o", folder / "out"});
  result.outcome = run("flexura", words);
  if (result.outcome.exit_code != 0) return result;
  result.mechanism = read_text(folder / "out/mechanism.toml");
  std::istringstream lines(result.mechanism);
  std::string joint;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("[")) joint = line.starts_with("[joint.") ? line.substr(7, line.size() - 8) : "";
    if (!joint.empty() && joint != "to_ground" && line.starts_with("type = "))
      result.joints[joint] = line.substr(8, line.size() - 9);
  }
  const auto at = result.outcome.out.find("degrees of freedom: ");
  if (at != std::string::npos) result.freedom = std::stoi(result.outcome.out.substr(at + 20));
  // Whatever is proposed runs.
  const Outcome ran = run("flexura", {"simulate", folder / "out/mechanism.toml", "-o", folder / "out.h5",
                                      "--end-time", "0.002", "--no-estimate"});
  EXPECT_EQ(ran.exit_code, 0) << ran.err;
  return result;
}

inline Import import(const Folder& folder, drawing::Assembly& assembly,
                     const std::vector<std::string>& words = {}) {
  assembly.write(folder / "a.step");
  return import(folder, (folder / "a.step").string(), words);
}

}  // namespace flexura::test
