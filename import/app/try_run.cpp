// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/try_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "import/app/passing_folder.hpp"
#include "import/model/folder.hpp"
#include "mbs/study/cache/child_process.hpp"

namespace flexura::import {
namespace fs = std::filesystem;

void require_run(Mechanism& mechanism) {
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure).parent_path() / "flexura";
  if (failure || ::access(program.c_str(), X_OK) != 0) {
    mechanism.notes.push_back(program.string() + " is not there: the mechanism was not tried");
    return;
  }
  const PassingFolder folder;
  write_folder(folder.path() / "m", mechanism, {}, false);
  constexpr double limit_s = 20.0;
  const study::ChildOutcome run =
      study::run_child({program.string(), "simulate", (folder.path() / "m/mechanism.toml").string(), "-o",
                        (folder.path() / "r.h5").string(), "--no-estimate", "--set", "solver.end_time=0.001",
                        "solver.output_step=0.001"},
                       folder.path(), {.seconds = limit_s});
  if (run.timed_out)
    mechanism.notes.push_back(
        fmt::format("its first millisecond takes more than {:g} s: whether it runs is not known", limit_s));
  if (run.timed_out || run.exit_code == 0) return;
  constexpr std::string_view mark = "error: ";
  const auto from = run.err.rfind(mark);
  std::string why = from == std::string::npos ? run.err : run.err.substr(from + mark.size());
  while (why.ends_with('\n')) why.pop_back();
  throw std::runtime_error(
      fmt::format("the mechanism made of it does not run ({}); correct what this names in the file", why));
}

}  // namespace flexura::import
