// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

namespace flexura::test {

inline std::string sample(const std::string& name) {
  return FLEXURA_SOURCE_DIR "/tests/import/data/" + name;
}

/// Imports the sample into FOLDER/robot and simulates it with these words; the one run of the results.
inline results::Run run_robot(const Folder& folder, const std::string& urdf, std::vector<std::string> words,
                              const std::vector<std::string>& import_words = {}) {
  std::vector<std::string> arguments = {"import", urdf, "-o", folder / "robot"};
  arguments.insert(arguments.end(), import_words.begin(), import_words.end());
  const Outcome imported = run("flexura", arguments);
  EXPECT_EQ(imported.exit_code, 0) << imported.err;
  words.insert(words.begin(),
               {"simulate", folder / "robot/mechanism.toml", "-o", folder / "robot.h5", "--no-estimate"});
  const Outcome simulated = run("flexura", words);
  EXPECT_EQ(simulated.exit_code, 0) << simulated.err;
  return results::read(folder / "robot.h5").runs.at(0);
}

// Pieces of a URDF.
inline const std::string kMass =
    R"(<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>)";
inline std::string link(const std::string& name, const std::string& content = kMass) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}
inline std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& content = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + content + "</joint>\n";
}
inline std::string robot(const std::string& content) {
  return "<robot name=\"r\">\n" + content + "</robot>\n";
}
inline const std::string kTwo = link("a") + link("b");

inline Eigen::VectorXd column(const results::Run& run, const std::string& name) {
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name == name) return run.values.col(static_cast<Eigen::Index>(i));
  throw std::out_of_range("no quantity " + name);
}

inline const results::BodyHistory& body(const results::Run& run, const std::string& name) {
  for (const results::BodyHistory& b : run.bodies)
    if (b.name == name) return b;
  throw std::out_of_range("no body " + name);
}

}  // namespace flexura::test
