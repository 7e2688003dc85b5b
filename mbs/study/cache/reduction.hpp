// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/study/cache/child_process.hpp"
#include "mbs/study/cache/study_cache.hpp"

/// Superelements that `flexura-reduce` makes as a child of this process, kept in a cache by what they were made of.
namespace flexura::study {

struct Reduction {
  std::string key;                   ///< of what the superelement is made of: KEY.se.h5 in the cache
  std::string name;                  ///< what it is called in messages
  std::vector<std::string> command;  ///< the program, the part file and options, without the output
};

/// "error: ..." of a program that has ended, without the word.
std::string refusal(const ChildOutcome& outcome);

/// Runs it and puts the superelement into the cache, of which `folder` is the absolute path.  `progress` is told the last
/// line that the program has written about its stages.  Returns what the program warned of.  Throws input::InputError
/// for what it refuses as bad input and std::runtime_error for what fails, with its own words after `name`.
std::vector<std::string> reduce_into(const StudyCache& cache, const std::filesystem::path& folder,
                                     const Reduction& reduction,
                                     const std::function<void(std::string_view line)>& progress = {});

}  // namespace flexura::study
