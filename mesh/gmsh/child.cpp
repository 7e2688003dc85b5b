// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "mesh/gmsh/job.hpp"

extern char** environ;

namespace flexura::mesh {
namespace {

using Clock = std::chrono::steady_clock;

/// A descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {
    if (fd < 0) throw std::runtime_error(std::string("cannot open a descriptor: ") + std::strerror(errno));
  }
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  void close() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

 private:
  int fd_;
};

int memory_file(const char* name) {
  return memfd_create(name, MFD_CLOEXEC);
}

void write_all(int fd, const std::string& text) {
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = write(fd, text.data() + done, text.size() - done);
    if (n < 0) throw std::runtime_error(std::string("cannot hand over the job: ") + std::strerror(errno));
    done += static_cast<std::size_t>(n);
  }
  lseek(fd, 0, SEEK_SET);
}

/// The last `most` bytes of a memory file.
std::string read_back(int fd, std::size_t most) {
  struct stat info {};
  fstat(fd, &info);
  const auto size = static_cast<std::size_t>(info.st_size), first = size > most ? size - most : 0;
  std::string text(size - first, '\0');
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t n = pread(fd, text.data() + done, text.size() - done, static_cast<off_t>(first + done));
    if (n <= 0) break;
    done += static_cast<std::size_t>(n);
  }
  text.resize(done);
  return text;
}

/// A running process that never outlives this object.
class Process {
 public:
  explicit Process(pid_t pid) : pid_(pid) {}
  ~Process() {
    if (pid_ > 0) end();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  /// Kills where it still runs; the wait status.
  int end() {
    kill(pid_, SIGKILL);
    return wait();
  }
  int wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }
  /// Seconds for which it could have run but another process had the processor: the second number of the
  /// kernel's record, in ns; 0 where the kernel keeps none.
  double waited_s() const {
    std::ifstream record("/proc/" + std::to_string(pid_) + "/schedstat");
    double ran = 0.0, waited = 0.0;
    return record >> ran >> waited ? 1e-9 * waited : 0.0;
  }
  bool has_ended(int& status) {
    if (waitpid(pid_, &status, WNOHANG) != pid_) return false;
    pid_ = -1;
    return true;
  }

 private:
  pid_t pid_;
};

/// Descriptors are moved above the child's numbers first, so that dup2 never overwrites one that is still
/// needed.
pid_t spawn(const std::filesystem::path& program, int input, int log, int result, int progress) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  const int pairs[][2] = {
      {input, 0}, {log, 1}, {log, 2}, {result, kResultDescriptor}, {progress, kProgressDescriptor}};
  for (const auto& pair : pairs) posix_spawn_file_actions_adddup2(&actions, pair[0], pair[1]);
  std::string name = program.string();
  char* arguments[] = {name.data(), nullptr};
  pid_t pid = -1;
  const int error = posix_spawn(&pid, name.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot start " + name + ": " + std::strerror(error));
  return pid;
}

int above_standard(int fd) {
  if (fd < 0 || fd > 9) return fd;
  const int moved = fcntl(fd, F_DUPFD_CLOEXEC, 10);
  close(fd);
  return moved;
}

void report_lines(std::string& buffer, const std::function<void(std::string_view, double)>& progress,
                  std::string& stage, double& fraction) {
  for (std::size_t end; (end = buffer.find('\n')) != std::string::npos; buffer.erase(0, end + 1)) {
    const std::string_view line(buffer.data(), end);
    const std::size_t tab = line.find('\t');
    if (tab == std::string_view::npos) continue;
    fraction = 0.0;
    std::from_chars(line.data(), line.data() + tab, fraction);
    stage = line.substr(tab + 1);
    if (progress) progress(stage, fraction);
  }
}

}  // namespace

ChildOutcome run_child(const std::filesystem::path& program, const std::string& input, double limit_s,
                       const std::function<void(std::string_view, double)>& progress) {
  const auto start = Clock::now();
  const Descriptor job(above_standard(memory_file("job"))), log(above_standard(memory_file("log"))),
      result(above_standard(memory_file("result")));
  write_all(job.get(), input);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
  const Descriptor listen(above_standard(ends[0]));
  Descriptor speak(above_standard(ends[1]));
  Process process(spawn(program, job.get(), log.get(), result.get(), speak.get()));
  speak.close();

  ChildOutcome outcome;
  std::string lines;
  double fraction = 0.0;
  int status = 0;
  bool pipe_open = true;
  for (;;) {
    outcome.waited_s = std::max(outcome.waited_s, process.waited_s());
    if (process.has_ended(status)) break;
    const double spent = std::chrono::duration<double>(Clock::now() - start).count() - outcome.waited_s;
    const auto left = std::llround(1e3 * std::min(limit_s - spent, 1e8));
    if (left <= 0) {
      outcome.end = ChildEnd::out_of_time;
      status = process.end();
      break;
    }
    const int pause = static_cast<int>(std::min<long long>(left, 50));
    if (!pipe_open) {  // closed its descriptors but has not ended yet
      std::this_thread::sleep_for(std::chrono::milliseconds(std::min(pause, 2)));
      continue;
    }
    pollfd waiting{listen.get(), POLLIN, 0};
    if (poll(&waiting, 1, pause) <= 0) {
      // Still at it: a stage that takes long is seen to.
      if (progress && !outcome.stage.empty()) progress(outcome.stage, fraction);
      continue;
    }
    char bytes[512];
    const ssize_t n = read(listen.get(), bytes, sizeof bytes);
    if (n > 0) {
      lines.append(bytes, static_cast<std::size_t>(n));
      report_lines(lines, progress, outcome.stage, fraction);
    } else if (n == 0) {
      pipe_open = false;
    }
  }
  outcome.log = read_back(log.get(), 4000);
  if (outcome.end == ChildEnd::out_of_time) {
    outcome.reason = "did not end within its time";
  } else if (WIFSIGNALED(status)) {
    outcome.end = ChildEnd::crashed;
    outcome.status = WTERMSIG(status);
    outcome.reason = std::string("stopped with signal ") + std::to_string(outcome.status) + " (" +
                     strsignal(outcome.status) + ")";
  } else if (WEXITSTATUS(status) != 0) {
    outcome.end = ChildEnd::crashed;
    outcome.status = WEXITSTATUS(status);
    outcome.reason = "ended with code " + std::to_string(outcome.status);
  } else {
    outcome.result = read_back(result.get(), static_cast<std::size_t>(-1));
  }
  return outcome;
}

}  // namespace flexura::mesh
