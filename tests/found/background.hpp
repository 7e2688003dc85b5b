// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "mbs/results/results.hpp"
#include "tests/app/command.hpp"

extern char** environ;

namespace flexura::test {

/// A program that runs beside the test; killed with this object.
class Background {
 public:
  Background(const std::string& program, const std::vector<std::string>& arguments) {
    std::vector<std::string> words{std::string(FLEXURA_BIN_DIR "/") + program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    const std::string out = streams_ / "out", err = streams_ / "err";
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT, 0600);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT, 0600);
    const int failed = posix_spawn(&pid_, argv.front(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed != 0) throw std::runtime_error("cannot start " + words.front());
  }
  ~Background() {
    if (pid_ > 0) {
      ::kill(pid_, SIGKILL);
      wait();
    }
  }
  Background(const Background&) = delete;
  Background& operator=(const Background&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const { ::kill(pid_, signal); }
  /// Its end; exit code -1 where a signal ended it.
  Outcome wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = -1;
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(streams_ / "out"),
            read_text(streams_ / "err")};
  }
  bool has_ended() {
    siginfo_t info{};
    return ::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           info.si_pid == pid_;
  }

 private:
  Folder streams_;
  pid_t pid_ = -1;
};

/// Waits until `what` holds, for at most half a minute; returns whether it does.
inline bool wait_for(const std::function<bool()>& what) {
  for (int k = 0; k < 3000; ++k, std::this_thread::sleep_for(std::chrono::milliseconds(10)))
    if (what()) return true;
  return false;
}

/// Waits for the first rows of a run under way, which are read in `part` (FILE.part).
inline bool wait_for_rows(const std::filesystem::path& part) {
  return wait_for([&] {
    try {
      return std::filesystem::exists(part) && results::read(part).runs.at(0).time.size() > 0;
    } catch (const std::exception&) {
      return false;
    }
  });
}

/// A mechanism file whose run does not end by itself within a test.
inline std::string write_long_run(const Folder& folder) {
  return folder.write("long.toml", R"toml([body.block]
mass = 2
[joint.slide]
type = "prismatic"
from = "ground"
to = "block"
[force.spring]
type = "joint_spring_damper"
joint = "slide"
stiffness = 1000
[solver]
end_time = 1e6
output_step = 0.1
store_states = true
)toml");
}

}  // namespace flexura::test
