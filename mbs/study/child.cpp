// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "mbs/files/signals.hpp"

extern char** environ;

namespace flexura::study {
namespace {

namespace fs = std::filesystem;

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

std::string take_text(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  std::error_code ignored;
  fs::remove(file, ignored);
  return text.str();
}

// False when the child still runs at the limit.
bool wait_until(pid_t child, double limit) {
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
  if (handle < 0) return true;  // an old kernel: the caller's wait4 waits without a limit
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit);
  bool ended = false;
  while (true) {
    const double left = std::chrono::duration<double>(end - std::chrono::steady_clock::now()).count();
    if (left <= 0.0) break;
    pollfd event{handle, POLLIN, 0};
    const int n = ::poll(&event, 1, static_cast<int>(std::ceil(std::min(left, 1e5) * 1e3)));
    if (n > 0) {
      ended = true;
      break;
    }
    if (n < 0 && errno != EINTR) break;
  }
  ::close(handle);
  return ended;
}

}  // namespace

ChildOutcome run_child(const std::vector<std::string>& command, const fs::path& scratch, double time_limit) {
  static std::atomic<unsigned> counter{0};
  const std::string stem = "child_" + std::to_string(::getpid()) + "_" + std::to_string(counter++);
  const fs::path out = scratch / (stem + ".out"), err = scratch / (stem + ".err");
  std::vector<std::string> words = command;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const files::Unfinished out_goes(fs::absolute(out)), err_goes(fs::absolute(err));
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const auto start = std::chrono::steady_clock::now();
  pid_t child = -1;
  const int failed = ::posix_spawn(&child, argv.front(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw std::runtime_error(words.front() + ": cannot be started: " + std::strerror(failed));

  ChildOutcome outcome;
  if (time_limit > 0.0 && !wait_until(child, time_limit)) {
    outcome.timed_out = true;
    ::kill(child, SIGTERM);  // it takes its unfinished files away
    if (!wait_until(child, 5.0)) ::kill(child, SIGKILL);
  }
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  outcome.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  outcome.cpu = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  outcome.peak_memory = 1024.0 * static_cast<double>(usage.ru_maxrss);  // Linux counts in kilobytes
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = take_text(out);
  outcome.err = take_text(err);
  return outcome;
}

}  // namespace flexura::study
