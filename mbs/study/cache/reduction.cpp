// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/cache/reduction.hpp"

#include <fmt/format.h>

#include <fstream>
#include <sstream>

#include "mbs/base/documents/document.hpp"

namespace flexura::study {

namespace fs = std::filesystem;

std::string refusal(const ChildOutcome& outcome) {
  std::string text = outcome.err;
  if (const auto at = text.rfind("error: "); at != std::string::npos) text = text.substr(at + 7);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

namespace {

std::string last_line_of(const fs::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);)
    if (!line.empty()) last = line;
  return last;
}

std::vector<std::string> warnings_in(const std::string& err) {
  std::vector<std::string> warnings;
  std::istringstream lines(err);
  bool goes_on = false;  // a sentence may be folded, its further lines indented
  for (std::string line; std::getline(lines, line);) {
    constexpr std::string_view mark = "warning: ";
    if (line.starts_with(mark))
      warnings.push_back(line.substr(mark.size()));
    else if (goes_on && line.starts_with(' '))
      warnings.back() += line.substr(line.find_first_not_of(' ') - 1);
    goes_on = line.starts_with(mark) || (goes_on && line.starts_with(' '));
  }
  return warnings;
}

}  // namespace

std::vector<std::string> reduce_into(const StudyCache& cache, const fs::path& folder,
                                     const Reduction& reduction,
                                     const std::function<void(std::string_view)>& progress) {
  const StudyCache::Passing beside{cache.path(reduction.key, ("." + scratch_mark() + "reduced").c_str())};
  std::vector<std::string> command = reduction.command;
  command.insert(command.end(), {"-o", beside.path.string()});
  std::function<void(const fs::path&)> watch;
  if (progress) watch = [&](const fs::path& err) { progress(last_line_of(err)); };
  const ChildOutcome outcome = run_child(command, folder, {}, watch);
  if (outcome.exit_code != 0) {
    std::string why = refusal(outcome);
    if (why.empty()) why = fmt::format("flexura-reduce ended with code {}", outcome.exit_code);
    const std::string text = fmt::format("{}: {}", reduction.name, why);
    if (outcome.exit_code == 2) throw input::InputError(text);
    throw std::runtime_error(text);
  }
  fs::rename(beside.path, cache.path(reduction.key, ".se.h5"));
  CacheEntry entry;
  entry.choice = reduction.name;
  entry.wall = {outcome.wall};
  entry.cpu = {outcome.cpu};
  entry.peak_memory = outcome.peak_memory;
  cache.record(reduction.key, ".se.h5", entry);
  return warnings_in(outcome.err);
}

}  // namespace flexura::study
