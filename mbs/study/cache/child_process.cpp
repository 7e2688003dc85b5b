// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/cache/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <ctime>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "mbs/base/files/signals.hpp"

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

enum class Waited { ended, late, told_to_end };

/// [s] that count against a limit: by the clock, or processor time of a child and at least a tenth of that by the clock.
double time_used(pid_t child, double wall, bool of_processor) {
  if (!of_processor) return wall;
  clockid_t clock{};
  timespec used{};
  if (::clock_getcpuclockid(child, &clock) != 0 || ::clock_gettime(clock, &used) != 0) return wall;
  return std::max(static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec), 0.1 * wall);
}

/// Until it ends, its time is over or (where `heeds`) this process is told to end.  `meanwhile` may be empty.
Waited wait_until(pid_t child, TimeLimit limit, bool heeds, const std::function<void()>& meanwhile = {}) {
  const int handle = static_cast<int>(::syscall(SYS_pidfd_open, child, 0));
  if (handle < 0) return Waited::ended;  // an old kernel: the caller's wait4 waits without a limit
  const auto start = std::chrono::steady_clock::now();
  Waited outcome = Waited::late;
  while (true) {
    const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const double left = limit.seconds - time_used(child, wall, limit.of_processor);
    if (left <= 0.0) break;
    if (heeds && files::StopRequests::wanted()) {
      outcome = Waited::told_to_end;
      break;
    }
    pollfd event{handle, POLLIN, 0};
    // A signal may reach another thread: it is looked for ten times a second.
    const int n = ::poll(&event, 1, static_cast<int>(std::ceil(std::min(left, 0.1) * 1e3)));
    if (n > 0) {
      outcome = Waited::ended;
      break;
    }
    if (n < 0 && errno != EINTR) break;
    if (meanwhile) meanwhile();
  }
  ::close(handle);
  return outcome;
}

void end(pid_t child) {
  ::kill(child, SIGTERM);  // it takes its unfinished files away
  if (wait_until(child, {5.0}, false) == Waited::late) ::kill(child, SIGKILL);
}

std::string host() {
  char name[256] = "";
  ::gethostname(name, sizeof name - 1);
  std::string text = name;
  std::ranges::replace(text, '/', '_');
  return text;
}

/// What a process does between fork and exec: nothing that takes a lock or memory, as other threads may hold
/// them.  Never returns; tells errno through `report`.
[[noreturn]] void become(char* const* argv, const char* out, const char* err, pid_t parent, int report) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(127);  // it has died before
  const int in_ = ::open("/dev/null", O_RDONLY), out_ = ::open(out, O_WRONLY | O_CREAT | O_TRUNC, 0600),
            err_ = ::open(err, O_WRONLY | O_CREAT | O_TRUNC, 0600);
  if (in_ >= 0 && out_ >= 0 && err_ >= 0 && ::dup2(in_, STDIN_FILENO) >= 0 &&
      ::dup2(out_, STDOUT_FILENO) >= 0 && ::dup2(err_, STDERR_FILENO) >= 0) {
    for (const int opened : {in_, out_, err_})
      if (opened > STDERR_FILENO) ::close(opened);
    ::execv(argv[0], argv);
  }
  const int why = errno;
  [[maybe_unused]] const ssize_t told = ::write(report, &why, sizeof why);
  ::_exit(127);
}

/// 0 or what went wrong.
int start(char* const* argv, const fs::path& out, const fs::path& err, pid_t& child) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return errno;
  const pid_t parent = ::getpid();
  child = ::fork();
  int why = child < 0 ? errno : 0;
  if (child == 0) become(argv, out.c_str(), err.c_str(), parent, ends[1]);
  ::close(ends[1]);
  if (child > 0) {
    int code = 0;
    ssize_t n = 0;
    while ((n = ::read(ends[0], &code, sizeof code)) < 0 && errno == EINTR) {
    }
    if (n == static_cast<ssize_t>(sizeof code)) {
      why = code;
      while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
  }
  ::close(ends[0]);
  return why;
}

}  // namespace

std::string scratch_mark() {
  return "by-" + host() + "-" + std::to_string(::getpid()) + ".";
}

void remove_scratch_left(const fs::path& scratch) {
  const std::string ours = "by-" + host() + "-";
  std::vector<fs::path> left;
  std::error_code none;
  for (fs::directory_iterator entry(scratch, none), last; !none && entry != last; entry.increment(none)) {
    const std::string name = entry->path().filename().string();
    const std::size_t at = name.find(ours);
    pid_t pid = 0;
    if (at == std::string::npos) continue;
    const char *digits = name.data() + at + ours.size(), *const stop = name.data() + name.size();
    const auto number = std::from_chars(digits, stop, pid);
    if (number.ec == std::errc() && number.ptr != stop && *number.ptr == '.' && pid > 0 &&
        ::kill(pid, 0) != 0 && errno == ESRCH)
      left.push_back(entry->path());
  }
  for (const fs::path& file : left) fs::remove(file, none);
}

ChildOutcome run_child(const std::vector<std::string>& command, const fs::path& scratch, TimeLimit limit,
                       const std::function<void(const fs::path& err)>& watch) {
  static std::atomic<unsigned> counter{0};
  const std::string stem = "child." + scratch_mark() + std::to_string(counter++);
  const fs::path out = scratch / (stem + ".out"), err = scratch / (stem + ".err");
  std::vector<std::string> words = command;
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  const files::Unfinished out_goes(fs::absolute(out)), err_goes(fs::absolute(err));
  const auto start_time = std::chrono::steady_clock::now();
  pid_t child = -1;
  const int failed = start(argv.data(), out, err, child);
  if (failed != 0) throw std::runtime_error(words.front() + ": cannot be started: " + std::strerror(failed));

  ChildOutcome outcome;
  const Waited waited = wait_until(
      child, limit, true, watch ? std::function<void()>([&] { watch(err); }) : std::function<void()>());
  outcome.timed_out = waited == Waited::late;
  if (waited != Waited::ended) end(child);
  int status = 0;
  rusage usage{};
  while (::wait4(child, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  outcome.wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_time).count();
  outcome.cpu = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  outcome.peak_memory = 1024.0 * static_cast<double>(usage.ru_maxrss);  // Linux counts in kilobytes
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  outcome.out = take_text(out);
  outcome.err = take_text(err);
  // From a terminal the signal went to the child, too: what it has done is not a whole run.
  if (files::StopRequests::wanted())
    throw Interrupted(std::string("interrupted by ") + files::StopRequests::name());
  return outcome;
}

}  // namespace flexura::study
