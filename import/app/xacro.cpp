// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/xacro.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <set>
#include <stdexcept>

#include "import/app/passing_folder.hpp"
#include "import/model/mechanism.hpp"
#include "import/urdf/mesh_file.hpp"
#include "import/urdf/robot.hpp"
#include "import/urdf/templates.hpp"
#include "mbs/study/cache/child_process.hpp"

namespace flexura::import {
namespace {

namespace fs = std::filesystem;

fs::path program_in_path(const std::string& name) {
  const char* const given = std::getenv("PATH");
  for (std::string rest = given == nullptr ? "" : given; !rest.empty();) {
    const auto end = rest.find(':');
    const fs::path folder = rest.substr(0, end);
    std::error_code none;
    if (folder.is_absolute() && fs::is_regular_file(folder / name, none) &&
        ::access((folder / name).c_str(), X_OK) == 0)
      return folder / name;
    rest = end == std::string::npos ? "" : rest.substr(end + 1);
  }
  return {};
}

std::invalid_argument distrust(const fs::path& file, const urdf::Place& place, const char* what) {
  return std::invalid_argument(fmt::format(
      "{}:{}: \"{}\" {}, and what xacro evaluates is Python: look at it, then import with --xacro run "
      "if you trust it, or make the URDF yourself: xacro {} > robot.urdf",
      file.string(), place.line, shown(place.text), what, file.filename().string()));
}

// Of the file and of all that it includes.
void require_arithmetic(const fs::path& file, const std::vector<std::string>& packages,
                        std::set<fs::path>& seen) {
  constexpr std::size_t most = 1000;
  if (seen.size() > most)
    throw std::invalid_argument(
        fmt::format("{}: includes more than {} files; make the URDF of it first", file.string(), most));
  if (!seen.insert(fs::weakly_canonical(file)).second) return;
  const urdf::Template found = urdf::look_through(urdf::read_text(file), file);
  if (!found.code.empty()) throw distrust(file, found.code.front(), "is more than arithmetic");
  for (const urdf::Place& include : found.includes) {
    fs::path included;
    try {
      included = urdf::find_mesh(include.text, file, packages);
    } catch (const std::invalid_argument&) {
      throw distrust(file, include, "is included and not found here");
    }
    require_arithmetic(included, packages, seen);
  }
}

}  // namespace

bool has_xacro() {
  return !program_in_path("xacro").empty();
}

std::string expand_xacro(const fs::path& file, const std::vector<std::string>& packages, bool trusted) {
  const fs::path program = program_in_path("xacro");
  if (program.empty()) {
    const auto macro =
        urdf::look_through(urdf::read_text(file), file).first.value_or(urdf::Place{1, "robot"});
    throw std::invalid_argument(fmt::format(
        "{}:{}: <{}> holds a xacro macro that has not been expanded, and the program xacro is not on "
        "this machine; install it, or make the URDF of it first: xacro {} > robot.urdf",
        file.string(), macro.line, shown(macro.text), file.filename().string()));
  }
  std::set<fs::path> seen;
  if (!trusted) require_arithmetic(file, packages, seen);
  const PassingFolder scratch;
  constexpr double limit_s = 60.0;
  const study::ChildOutcome made =
      study::run_child({program.string(), fs::absolute(file).string()}, scratch.path(), {.seconds = limit_s});
  if (made.timed_out)
    throw std::runtime_error(
        fmt::format("{}: xacro takes more than {:g} s; make the URDF of it first", file.string(), limit_s));
  if (made.exit_code != 0)
    throw std::runtime_error(
        fmt::format("{}: xacro cannot expand it ({}); correct this, or make the URDF of it "
                    "first: xacro {} > robot.urdf",
                    file.string(), shown(made.err), file.filename().string()));
  return made.out;
}

}  // namespace flexura::import
