// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What the cache of a study keeps beside the file of a run or a reduction: KEY.json.
namespace flexura::study {

struct CacheEntry {
  std::string choice, failure;  ///< failure: why there is nothing to measure; "" where there is
  int exit_code = 0;
  std::vector<double> wall, cpu;  ///< [s] of the timed runs
  double peak_memory = 0.0;       ///< [B]

  double total_wall() const;
};

nlohmann::json to_json(const CacheEntry& entry);
/// Nothing where it is damaged: times that are no finite numbers above zero, keys that lack.  What it belongs to is then
/// made again.
std::optional<CacheEntry> cache_entry_of(std::string_view text);
std::optional<CacheEntry> read_cache_entry(const std::filesystem::path& file);

}  // namespace flexura::study
