// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/app/command.hpp"
#include "tests/mbs/random/judge.hpp"
#include "tests/mbs/random/random_scene.hpp"

/// Random mechanisms: each ends right or with a message.  FLEXURA_SEED=17 judges that one, FLEXURA_SEED=100:200 those
/// from 100 to 199, with a line for each; the file of one that failed stays where the failure says.
namespace flexura::mbs::chance {
namespace {

std::string as_text(const Judgement& j) {
  std::string text = fmt::format(
      "{}\n{}\n{} warned; {:.1e} {:.1e} {:.1e} {:.1e} {:.1e} {:.1e} {:.1e} {:.1e}\n", j.end, j.nature,
      j.warnings, j.rows, j.rates, j.accelerations, j.energy, j.balance, j.momentum, j.integrators, j.files);
  for (const std::string& complaint : j.complaints) text += complaint + "\n";
  return text;
}

/// In a process of its own, which may crash or hang: processor seconds are bounded, not time.
std::string judged_apart(std::uint64_t seed, const JudgeOptions& options) {
  constexpr rlim_t kSeconds = 60;
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  std::fflush(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    close(ends[0]);
    const rlimit limit{kSeconds, kSeconds + 1};
    setrlimit(RLIMIT_CPU, &limit);
    std::string text;
    try {
      text = as_text(judge(random_scene(seed), options));
    } catch (const std::exception& e) {
      text = fmt::format("?\n?\n?\nthe judge failed: {}\n", e.what());
    }
    const bool whole = write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size());
    _exit(whole ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFSIGNALED(status))
    return fmt::format("?\n?\n?\n{}\n",
                       WTERMSIG(status) == SIGXCPU
                           ? fmt::format("hangs: not done after {} s of processor time", kSeconds)
                           : fmt::format("crashes: {}", strsignal(WTERMSIG(status))));
  return text;
}

/// What is wrong with how the program ends on the same file; `judged` is the text of the judge, who ran it, too.
std::string told_by_the_program(std::uint64_t seed, const JudgeOptions& options, const std::string& judged) {
  std::ofstream(options.file + "_told.toml")
      << to_toml(random_scene(seed), std::filesystem::path(options.file).parent_path(),
                 {.solver = "tolerance = 1e-7\n"});
  const test::Outcome outcome = test::run("flexura", {"simulate", "-q", options.file + "_told.toml", "-o",
                                                      options.file + ".h5", "--no-estimate"});
  std::filesystem::remove(options.file + ".h5");
  const int expected = judged.starts_with("complete") ? 0 : judged.starts_with("stopped") ? 1 : 2;
  std::string complaints;
  // What only the program watches (turns of cut joints, linear ranges) may end a run that else is complete.
  if (outcome.exit_code != expected && !(expected == 0 && outcome.exit_code == 1))
    complaints += fmt::format("the program ends with exit code {}, not {}\n", outcome.exit_code, expected);
  const bool speaks_of_error = ("\n" + outcome.err).find("\nerror: ") != std::string::npos;
  if (speaks_of_error != (outcome.exit_code != 0))
    complaints +=
        fmt::format("the program ends with exit code {} and says: {}\n", outcome.exit_code, outcome.err);
  return complaints;
}

struct Range {
  std::uint64_t from, to;
};

void run_range(Range range, bool talks) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("flexura_random_{}", ::getpid());
  std::filesystem::create_directories(folder);
  int complete = 0, ended = 0, warned = 0;
  for (std::uint64_t seed = range.from; seed < range.to; ++seed) {
    JudgeOptions options;
    options.file = (folder / fmt::format("seed_{}", seed)).string();
    options.other_files = talks || seed % 4 == 1;
    options.other_commands = talks || seed % 4 == 2;
    std::string text = judged_apart(seed, options);
    if (seed % 20 == 7) text += told_by_the_program(seed, options, text);
    std::vector<std::string> lines;
    for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
      lines.push_back(text.substr(at, end - at));
    lines.resize(std::max<std::size_t>(lines.size(), 3));
    (lines[0] == "complete" ? complete : ended)++;
    if (!lines[2].starts_with("0 warned")) ++warned;
    std::string complaints;
    for (std::size_t i = 3; i < lines.size(); ++i) complaints += "\n    " + lines[i];
    if (talks)
      std::printf("seed %lu (%s): %s\n    %s\n    %s%s\n", static_cast<unsigned long>(seed),
                  random_scene(seed).what.c_str(), lines[0].c_str(), lines[1].c_str(), lines[2].c_str(),
                  complaints.c_str());
    if (complaints.empty() && talks) continue;
    if (complaints.empty())
      for (const char* suffix : {"", "_backwards", "_mm", "_fine", "_told"})
        std::filesystem::remove(options.file + suffix + ".toml");
    else
      ADD_FAILURE() << "seed " << seed << " (" << random_scene(seed).what << "), file " << options.file
                    << ".toml, " << lines[0] << " (" << lines[1] << ")" << complaints
                    << "\nagain: FLEXURA_SEED=" << seed << " with this test";
  }
  std::error_code not_empty;
  std::filesystem::remove(folder, not_empty);
  std::printf("%d complete, %d with a message, %d warned of rank loss\n", complete, ended, warned);
  // A warning that is always given says nothing.
  if (!talks) EXPECT_LE(warned, (complete + ended) / 20);
}

TEST(RandomMechanisms, FLEXURA_TEST_NAME) {
  Range range{1, 1 + FLEXURA_SEEDS};
  const char* const given = std::getenv("FLEXURA_SEED");
  if (given) {
    char* end = nullptr;
    range.from = std::strtoull(given, &end, 10);
    range.to = *end == ':' ? std::strtoull(end + 1, nullptr, 10) : range.from + 1;
  }
  run_range(range, given != nullptr);
}

}  // namespace
}  // namespace flexura::mbs::chance
