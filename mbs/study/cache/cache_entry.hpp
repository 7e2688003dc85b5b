// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// What the cache of a study keeps beside the file of a run or a reduction: KEY.json.  A cache is never a reason to fail:
/// what is not as it was written is made again.
namespace flexura::study {

struct CacheEntry {
  std::string choice, failure;  ///< failure: why there is nothing to measure; "" where there is
  std::string content;          ///< the hash of the file beside it
  int exit_code = 0;
  std::vector<double> wall, cpu;  ///< [s] of the timed runs
  double peak_memory = 0.0;       ///< [B]

  double total_wall() const;
};

/// With "checksum" = checksum_of what stands beside it.
nlohmann::json to_json(const CacheEntry& entry);
/// Nothing where it is damaged: a checksum that does not fit, times that are no finite numbers above zero, keys that lack.
std::optional<CacheEntry> cache_entry_of(std::string_view text);
std::optional<CacheEntry> read_cache_entry(const std::filesystem::path& file);

/// Of all keys but "checksum".
std::string checksum_of(nlohmann::json entry);
/// Of a file beside an entry; "" where it cannot be read.
std::string content_of(const std::filesystem::path& file);

}  // namespace flexura::study
