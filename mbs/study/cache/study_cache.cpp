// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/cache/study_cache.hpp"

#include <fmt/format.h>

#include <chrono>
#include <stdexcept>
#include <thread>

#include "mbs/base/files/output.hpp"

namespace flexura::study {

namespace fs = std::filesystem;

bool StudyCache::is_there(const std::string& key, const char* ending) const {
  const fs::path file = path(key, ending), record = path(key, ".json");
  std::error_code none;
  if (!fs::exists(file, none) || !fs::exists(record, none)) return false;
  const auto entry = read_cache_entry(record);
  if (entry && entry->content == content_of(file)) return true;
  note_(fmt::format("{} is not what was written there: it is made again", (entry ? file : record).string()));
  return false;
}

CacheEntry StudyCache::entry_of(const std::string& key) const {
  if (auto entry = find(key)) return *std::move(entry);
  throw std::runtime_error(
      fmt::format("{}: cannot be read any more; start the study again", path(key, ".json").string()));
}

void StudyCache::record(const std::string& key, const char* ending, CacheEntry entry) const {
  entry.content = content_of(path(key, ending));
  write(key, entry);
}

void StudyCache::write(const std::string& key, const CacheEntry& entry) const {
  const std::string text = to_json(entry).dump(1) + '\n';
  // Another share of the study may write the same figures at this moment.
  for (int attempt = 1;; ++attempt) try {
      return files::write_whole(path(key, ".json"), text);
    } catch (const files::Busy&) {
      if (attempt == 1000) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
}

}  // namespace flexura::study
