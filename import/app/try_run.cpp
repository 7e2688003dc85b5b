// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/app/try_run.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>

#include "import/model/folder.hpp"
#include "mbs/study/cache/child_process.hpp"

namespace flexura::import {
namespace {

namespace fs = std::filesystem;

class PassingFolder {
 public:
  PassingFolder() {
    std::string name = (fs::temp_directory_path() / "flexura-import-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr)
      throw std::runtime_error(name + ": the folder cannot be made; free space, or set TMPDIR");
    path_ = name;
  }
  ~PassingFolder() {
    std::error_code none;
    fs::remove_all(path_, none);
  }
  PassingFolder(const PassingFolder&) = delete;
  PassingFolder& operator=(const PassingFolder&) = delete;
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

}  // namespace

void require_run(Mechanism& mechanism) {
  std::error_code failure;
  const fs::path program = fs::read_symlink("/proc/self/exe", failure).parent_path() / "flexura";
  if (failure || ::access(program.c_str(), X_OK) != 0) {
    mechanism.notes.push_back(program.string() + " is not there: the mechanism was not tried");
    return;
  }
  const PassingFolder folder;
  write_folder(folder.path() / "m", mechanism, {}, false);
  constexpr double limit_s = 60.0;
  const study::ChildOutcome run =
      study::run_child({program.string(), "simulate", (folder.path() / "m/mechanism.toml").string(), "-o",
                        (folder.path() / "r.h5").string(), "--no-estimate", "--set", "solver.end_time=0.001",
                        "solver.output_step=0.001"},
                       folder.path(), {.seconds = limit_s});
  if (run.timed_out)
    mechanism.notes.push_back(
        fmt::format("its first millisecond takes more than {:g} s: whether it runs is not known", limit_s));
  else if (run.exit_code != 0)
    throw std::runtime_error(
        fmt::format("the mechanism made of it does not run ({}); correct what this names in the file",
                    run.err.substr(run.err.rfind("error: ") + 7)));
}

}  // namespace flexura::import
