// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// A short run and a short reduction while their disk, their memory or their killer strikes at one moment
// after the other.  Each ends right or with one sentence; what stood at the output's place before is the old
// file or the whole new one; no half file stays.  FLEXURA_FAULTS_MOST bounds the moments of each kind
// (default 200, spread evenly).
#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <random>
#include <set>
#include <thread>

#include "tests/app/command.hpp"

extern char** environ;

namespace flexura {
namespace {

namespace fs = std::filesystem;
using test::Folder;
using Clock = std::chrono::steady_clock;

long most_moments() {
  const char* text = std::getenv("FLEXURA_FAULTS_MOST");
  return text ? std::atol(text) : 200;
}

/// Up to most_moments() of 1, ..., n, the first and the last among them.
std::vector<long> moments(long n) {
  const long most = std::min(n, most_moments());
  std::vector<long> all;
  for (long k = 0; k < most; ++k) all.push_back(most == 1 ? 1 : 1 + k * (n - 1) / (most - 1));
  return all;
}

struct Ended {
  int code = 0, signal = 0;
  std::string err;
};

/// A program in a folder of its own, with its input and an older output.
class Program {
 public:
  std::vector<std::string> words;  ///< the program and its arguments
  std::string input;               ///< the file that arms the shim
  fs::path output;
  std::vector<std::string> reads;  ///< a command that reads the output
  std::string old;

  pid_t start(const std::vector<std::string>& environment) const {
    std::vector<std::string> all = environment;
    for (char** entry = environ; *entry != nullptr; ++entry) all.emplace_back(*entry);
    std::vector<char*> envp, argv;
    for (std::string& entry : all) envp.push_back(entry.data());
    std::vector<std::string> arguments = words;
    arguments[0] = std::string(FLEXURA_BIN_DIR) + "/" + words[0];
    for (std::string& word : arguments) argv.push_back(word.data());
    envp.push_back(nullptr);
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, (talk_ / "err").c_str(),
                                     O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = -1;
    if (posix_spawn(&child, arguments[0].c_str(), &actions, nullptr, argv.data(), envp.data()) != 0)
      std::abort();
    posix_spawn_file_actions_destroy(&actions);
    return child;
  }

  Ended wait(pid_t child) const {
    int status = 0;
    waitpid(child, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, WIFSIGNALED(status) ? WTERMSIG(status) : 0,
            test::read_text(talk_ / "err")};
  }

  Ended with_fault(const std::string& fault) const {
    std::vector<std::string> environment = {"LD_PRELOAD=" FLEXURA_SHIM, "FLEXURA_FAULT=" + fault,
                                            "FLEXURA_FAULT_COUNT=" + (talk_ / "count").string()};
    // Outputs are claimed before the input is opened, and the loader creates no files.
    if (!fault.starts_with("create")) environment.push_back("FLEXURA_FAULT_FROM=" + input);
    return wait(start(environment));
  }

  long count(const std::string& kind) const {
    const Ended ended = with_fault(kind + ":0");
    EXPECT_EQ(ended.code, 0) << ended.err;
    return std::atol(test::read_text(talk_ / "count").c_str());
  }

  void restore() const {
    std::error_code ignored;
    fs::remove(output, ignored);
    if (!old.empty()) std::ofstream(output, std::ios::binary) << old;
  }

  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(output.parent_path()))
      names.insert(entry.path().filename());
    return names;
  }

  bool is_whole() const { return test::run(reads[0], {reads.begin() + 1, reads.end()}).exit_code == 0; }

 private:
  Folder talk_;
};

class Faults : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string name = GetParam(), safe = std::string(FLEXURA_SOURCE_DIR) + "/tests/found/safe/";
    if (name == "simulate") {
      fs::copy_file(safe + "userlib/m.toml", folder_ / "m.toml");
      program_.input = "m.toml";
      program_.output = folder_ / "m.h5";
      program_.words = {
          "flexura", "simulate", "-q", (folder_ / "m.toml").string(), "-o", program_.output.string()};
      program_.reads = {"flexura", "view", program_.output.string(), "--summary"};
    } else {
      fs::copy_file(safe + "poisson/crash_young1e300.toml", folder_ / "p.toml");
      fs::copy_file(safe + "poisson/hex20.msh", folder_ / "hex20.msh");
      program_.input = "p.toml";
      program_.output = folder_ / "p.se.h5";
      program_.words = {"flexura-reduce",         "-q",    (folder_ / "p.toml").string(), "-o",
                        program_.output.string(), "--set", "material.steel.young=210e9"};
      program_.reads = {"flexura", "modes", program_.output.string()};
    }
    const Ended first = program_.wait(program_.start({}));
    ASSERT_EQ(first.code, 0) << first.err;
    program_.old = test::read_text(program_.output);
    clean_ = program_.files();
  }

  /// What every end has to be.
  void judge(Ended ended, const std::string& what) {
    // SUNDIALS says this itself while it has no integrator yet that could be told to be silent.
    const std::string of_sundials = "\n[IDA ERROR]  IDACreate\n  A memory request failed.\n\n";
    if (const auto at = ended.err.find(of_sundials); at != std::string::npos)
      ended.err.erase(at, of_sundials.size());
    // Nor can METIS be.
    if (const auto at = ended.err.find("error: "); ended.err.find("***Memory allocation failed for gk_") < at)
      ended.err.erase(0, at);
    EXPECT_EQ(ended.signal, 0) << what << ": ended by signal " << ended.signal << "\n" << ended.err;
    const bool kept = test::read_text(program_.output) == program_.old;
    if (ended.code == 0) {
      EXPECT_TRUE(program_.is_whole()) << what << ": exit code 0, but the output cannot be read";
    } else if (ended.signal == 0) {
      EXPECT_TRUE(ended.code == 1 || ended.code == 2) << what << ": exit code " << ended.code;
      // A run that stops keeps its rows, and says so.
      const bool rows = ended.err.find("what was computed until then is in") != std::string::npos;
      EXPECT_TRUE(kept || (rows && program_.is_whole()))
          << what << ": the older output is gone (exit code " << ended.code << ", " << ended.err << ")";
      // MPI without memory ends the program in its own words (docs/reliability.md, "Not promised").
      if (ended.err.find("MPI_INIT failed") == std::string::npos) {
        EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << what << ": " << ended.err;
        EXPECT_TRUE(ended.err.starts_with("error: ")) << what << ": " << ended.err;
      }
    }
    std::set<std::string> more;
    for (const std::string& name : program_.files())
      if (!clean_.contains(name)) more.insert(name);
    EXPECT_TRUE(more.empty()) << what << " left " << *more.begin();
    for (const std::string& name : more) fs::remove_all(folder_ / name);
  }

  Folder folder_;
  Program program_;
  std::set<std::string> clean_;
};

TEST_P(Faults, EveryCallThatFailsIsASentence) {
  long tried = 0;
  for (const std::string kind : {"write", "create", "sync", "rename", "map", "allocate"}) {
    const long n = program_.count(kind);
    // A machine that sees no calls finds nothing.  Memory is mapped by the libraries of a reduction alone.
    if (kind != "map") EXPECT_GT(n, 0) << kind;
    for (const std::string& more : {std::string(), std::string("+")}) {
      if (more == "+" && kind != "write" && kind != "allocate") continue;
      for (const long k : moments(n)) {
        const std::string fault = fmt::format("{}:{}{}", kind, k, more);
        program_.restore();
        judge(program_.with_fault(fault), fault + fmt::format(" of {}", n));
        ++tried;
      }
    }
    fmt::print("{}: {} calls\n", kind, n);
  }
  fmt::print("{} faults\n", tried);
}

TEST_P(Faults, KilledAtRandomMoments) {
  const auto start = Clock::now();
  program_.wait(program_.start({}));
  const double whole = std::chrono::duration<double>(Clock::now() - start).count();
  std::mt19937 random(20);  // any seed
  std::uniform_real_distribution<double> moment(0.0, 1.1 * whole);
  for (long k = 0; k < most_moments(); ++k) {
    program_.restore();
    const double at = moment(random);
    const pid_t child = program_.start({});
    std::this_thread::sleep_for(std::chrono::duration<double>(at));
    kill(child, SIGKILL);
    program_.wait(child);
    const bool kept = test::read_text(program_.output) == program_.old;
    EXPECT_TRUE(kept || program_.is_whole()) << "killed after " << at << " s of " << whole;
  }
  // What a killed process leaves beside it does not keep the next one from its work.
  const Ended next = program_.wait(program_.start({}));
  EXPECT_EQ(next.code, 0) << next.err;
  EXPECT_TRUE(program_.is_whole());
}

TEST_P(Faults, AFullDiskKeepsTheOlderFile) {
  const Folder mount;
  long tried = 0;
  for (const int kB : {4, 12, 20, 40, 80, 160}) {
    // In namespaces of its own: nobody else sees the small disk.
    const std::string out = (mount / "x.h5").string();
    std::string words = "'" + std::string(FLEXURA_BIN_DIR) + "/" + program_.words[0] + "'";
    for (std::size_t i = 1; i < program_.words.size(); ++i)
      words += " '" + (program_.words[i] == program_.output.string() ? out : program_.words[i]) + "'";
    const std::string script = fmt::format(
        "mount -t tmpfs -o size={}k none '{}' || exit 77; echo old > '{}'; {} 2> '{}'; code=$?; "
        "[ $code -eq 0 ] || [ \"$(cat '{}')\" = old ] || exit 78; [ $(ls '{}' | wc -l) -eq 1 ] || exit 79; "
        "exit $code",
        kB, mount.path().string(), out, words, (folder_ / "err").string(), out, mount.path().string());
    const auto file = folder_.write("disk.sh", script + "\n");
    const int status = std::system(("unshare -rm sh '" + file.string() + "' 2>/dev/null").c_str());
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    if (code == 77 || code == 127) GTEST_SKIP() << "no namespaces here";
    EXPECT_NE(code, 78) << kB << " kB: the older file is gone";
    EXPECT_NE(code, 79) << kB << " kB: a half file is left";
    EXPECT_TRUE(code == 0 || code == 1)
        << kB << " kB: exit code " << code << test::read_text(folder_ / "err");
    if (code == 1) EXPECT_THAT(test::read_text(folder_ / "err"), ::testing::HasSubstr("error: "));
    ++tried;
  }
  fmt::print("{} sizes of disk\n", tried);
}

INSTANTIATE_TEST_SUITE_P(Of, Faults, ::testing::Values("simulate", "reduce"),
                         [](const auto& info) { return std::string(info.param); });

}  // namespace
}  // namespace flexura
