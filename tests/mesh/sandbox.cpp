// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later

// What the processes that read meshes and CAD files can still do, tried call by call in a child that has entered the sandbox.
#include "mesh/gmsh/worker/sandbox.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <functional>
#include <thread>

#include "tests/mesh/scratch.hpp"

namespace flexura::mesh {
namespace {

/// What `work` returns in a child that is in the sandbox; -1 where the kernel has none, or the child was ended.
int in_sandbox(const std::function<bool()>& work) {
  const pid_t child = fork();
  if (child == 0) _exit(!enter_sandbox() ? 2 : work() ? 1 : 0);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) < 2 ? WEXITSTATUS(status) : -1;
}

class Sandbox : public ::testing::Test {
 protected:
  void SetUp() override {
    if (in_sandbox([] { return true; }) != 1) GTEST_SKIP() << "this kernel has no seccomp filters";
  }
};

bool runs(const char* program) {
  return std::system(program) == 0;
}

TEST_F(Sandbox, ReadsComputesAndWritesToWhatIsOpen) {
  const Scratch given("given.txt", "text");
  const int result = memfd_create("result", 0);
  EXPECT_EQ(in_sandbox([&] {
              int sum = 0;
              std::thread([&] { sum = 6 * 7; }).join();
              const int opened = open(given.path().c_str(), O_RDONLY);
              char letter = 0;
              return sum == 42 && opened >= 0 && read(opened, &letter, 1) == 1 && letter == 't' &&
                     write(result, "r", 1) == 1 && std::malloc(100'000'000) != nullptr;
            }),
            1);
  char letter = 0;
  EXPECT_EQ(pread(result, &letter, 1, 0), 1);
  EXPECT_EQ(letter, 'r');
  close(result);
}

TEST_F(Sandbox, HasNoWayToOthersFilesProgramsAndConnections) {
  const Scratch given("given.txt", "text");
  const std::string path = given.path().string(), beside = path + ".beside";
  const pid_t bystander = fork();
  if (bystander == 0) {
    pause();
    _exit(0);
  }
  const rlimit none{0, 0};
  const std::pair<const char*, std::function<bool()>> calls[] = {
      {"write a file", [&] { return open(path.c_str(), O_WRONLY) >= 0; }},
      {"read and write a file", [&] { return open(path.c_str(), O_RDWR) >= 0; }},
      {"cut a file", [&] { return open(path.c_str(), O_RDONLY | O_TRUNC) >= 0; }},
      {"make a file", [&] { return open(beside.c_str(), O_RDONLY | O_CREAT, 0600) >= 0; }},
      {"make a file by another call", [&] { return creat(beside.c_str(), 0600) >= 0; }},
      {"truncate", [&] { return truncate(path.c_str(), 0) == 0; }},
      {"remove", [&] { return unlink(path.c_str()) == 0; }},
      {"rename", [&] { return rename(path.c_str(), beside.c_str()) == 0; }},
      {"link", [&] { return link(path.c_str(), beside.c_str()) == 0; }},
      {"symlink", [&] { return symlink(path.c_str(), beside.c_str()) == 0; }},
      {"make a folder", [&] { return mkdir(beside.c_str(), 0700) == 0; }},
      {"make a pipe", [&] { return mkfifo(beside.c_str(), 0600) == 0; }},
      {"change rights", [&] { return chmod(path.c_str(), 0777) == 0; }},
      {"change times", [&] { return utimensat(AT_FDCWD, path.c_str(), nullptr, 0) == 0; }},
      {"change the folder", [] { return chdir("/") == 0; }},
      {"start a program", [] { return execl("/bin/true", "true", nullptr) == 0; }},
      {"a shell", [] { return runs("true"); }},
      {"fork", [] { return fork() >= 0; }},
      {"connect", [] { return socket(AF_INET, SOCK_STREAM, 0) >= 0; }},
      {"connect on this machine", [] { return socket(AF_UNIX, SOCK_STREAM, 0) >= 0; }},
      {"end another process", [&] { return kill(bystander, SIGKILL) == 0; }},
      {"bound another process", [&] { return prlimit(bystander, RLIMIT_AS, &none, nullptr) == 0; }},
      {"type into a terminal", [] { return ioctl(0, TIOCSTI, "x") == 0 || errno != EPERM; }}};
  for (const auto& [what, call] : calls) {
    if (std::string(what) != "start a program") {
      EXPECT_EQ(in_sandbox(call), 0) << what;
    } else {  // a program that started ends with code 0 instead
      EXPECT_EQ(in_sandbox([&] { return !call(); }), 1) << what;
    }
  }
  EXPECT_EQ(waitpid(bystander, nullptr, WNOHANG), 0);
  kill(bystander, SIGKILL);
  waitpid(bystander, nullptr, 0);
  EXPECT_FALSE(std::filesystem::exists(beside));
  EXPECT_EQ(std::filesystem::file_size(path), 4u);
}

// abort() and a library's own signals reach the process itself: the parent is told by what signal it ended.
TEST_F(Sandbox, LetsItAbort) {
  const pid_t child = fork();
  if (child == 0) {
    if (!enter_sandbox()) _exit(2);
    std::abort();
  }
  int status = 0;
  waitpid(child, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT);
}

}  // namespace
}  // namespace flexura::mesh
