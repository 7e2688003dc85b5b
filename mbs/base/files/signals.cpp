// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/base/files/signals.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <stdexcept>
#include <string>

namespace flexura::files {

// A signal handler may take no lock and no memory: the names lie in slots that are never freed, only used
// again.
struct Unfinished::Slot {
  enum State { vacant, filling, live };
  std::atomic<int> state{filling};
  pid_t owner = 0;
  char path[PATH_MAX] = {};
  Slot* next = nullptr;
};

namespace {

std::atomic<int> stop_signal{0}, interrupts{0};  // lock-free: a handler may touch them
std::atomic<int> held_back{0}, held_signal{0};
std::atomic<void*> first_slot{nullptr};  // Unfinished::Slot, which only Unfinished and its friend may name

}  // namespace

void remove_unfinished() noexcept {
  using Slot = Unfinished::Slot;
  for (Slot* s = static_cast<Slot*>(first_slot.load()); s != nullptr; s = s->next)
    if (s->state.load() == Slot::live && s->owner == ::getpid()) ::unlink(s->path);
}

namespace {

std::atomic<pid_t> program{0};  // not what is forked from it

void say_why(int signal) {
  const char* const why = signal == SIGINT    ? "error: interrupted by SIGINT\n"
                          : signal == SIGTERM ? "error: interrupted by SIGTERM\n"
                          : signal == SIGHUP  ? "error: interrupted by SIGHUP\n"
                          : signal == SIGXCPU
                              ? "error: interrupted: the processor time that is allowed is over\n"
                              : "error: interrupted\n";
  if (program == ::getpid() && ::write(STDERR_FILENO, why, std::strlen(why)) < 0) return;  // nobody listens
}

extern "C" void end_by(int signal) {
  if (held_back > 0) {
    held_signal = signal;
    return;
  }
  remove_unfinished();
  say_why(signal);
  std::signal(signal, SIG_DFL);
  ::raise(signal);
}

extern "C" void ask_to_stop(int signal) {
  if (signal == SIGINT && ++interrupts > 1) return end_by(signal);
  stop_signal = signal;
}

constexpr int kAsks[] = {SIGINT, SIGTERM, SIGHUP};

void open_if_closed(int descriptor, const char* onto, int mode) {
  if (::fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) return;
  // The lowest free number is this one: those below it are open by now.
  [[maybe_unused]] const int opened = ::open(onto, mode);
}

}  // namespace

void prepare_process() {
  program = ::getpid();
  open_if_closed(STDIN_FILENO, "/dev/null", O_RDONLY);
  open_if_closed(STDOUT_FILENO, "/dev/full", O_WRONLY);  // what is printed is lost, and that is said
  open_if_closed(STDERR_FILENO, "/dev/null", O_WRONLY);
  std::atexit([] { remove_unfinished(); });  // a library that gives up (MPI) ends the program by itself
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  for (const int signal : {SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXCPU})
    if (std::signal(signal, end_by) == SIG_IGN) std::signal(signal, SIG_IGN);
}

Unfinished::Unfinished(const std::filesystem::path& file) : slot_(nullptr) {
  const std::string name = file.string();
  if (name.size() >= PATH_MAX)
    throw std::invalid_argument(name +
                                ": the path is too long; name an output in a folder nearer to the root");
  for (Slot* s = static_cast<Slot*>(first_slot.load()); s != nullptr && slot_ == nullptr; s = s->next) {
    int vacant = Slot::vacant;
    if (s->state.compare_exchange_strong(vacant, Slot::filling)) slot_ = s;
  }
  if (slot_ == nullptr) {
    slot_ = new Slot;
    void* head = first_slot.load();
    do slot_->next = static_cast<Slot*>(head);
    while (!first_slot.compare_exchange_weak(head, slot_));
  }
  slot_->owner = ::getpid();
  std::memcpy(slot_->path, name.c_str(), name.size() + 1);
  slot_->state = Slot::live;
}

Unfinished::~Unfinished() {
  slot_->state = Slot::vacant;
}

HeldBack::HeldBack() {
  ++held_back;
}

HeldBack::~HeldBack() {
  if (--held_back == 0)
    if (const int signal = held_signal.exchange(0)) end_by(signal);
}

StopRequests::StopRequests() {
  stop_signal = 0;
  interrupts = 0;
  for (int i = 0; i < 3; ++i) {
    before_[i] = std::signal(kAsks[i], ask_to_stop);
    if (kAsks[i] == SIGHUP && before_[i] == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
  }
}

StopRequests::~StopRequests() {
  for (int i = 0; i < 3; ++i) std::signal(kAsks[i], before_[i]);
}

bool StopRequests::wanted() {
  return stop_signal != 0;
}

const char* StopRequests::name() {
  switch (stop_signal.load()) {
    case SIGINT:
      return "SIGINT";
    case SIGTERM:
      return "SIGTERM";
    case SIGHUP:
      return "SIGHUP";
    default:
      return "";
  }
}

void finish_standard_output() {
  std::cout.flush();
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  const int why = errno;
  if (flushed && std::ferror(stdout) == 0 && std::cout.good()) return;
  throw std::runtime_error(
      fmt::format("standard output cannot be written{}{}; what was printed is not whole; check the pipe or "
                  "the disk behind it",
                  why ? ": " : "", why ? std::strerror(why) : ""));
}

}  // namespace flexura::files
