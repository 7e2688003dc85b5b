// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "mbs/study/cache/cache_entry.hpp"

/// The folder in which a study keeps what it ran: files named by the key of what made them, each with its entry
/// (cache_entry.hpp).  Other processes may write there at the same moment.
namespace flexura::study {

class StudyCache {
 public:
  /// `note` takes a sentence about a file that is not as it was written.
  StudyCache(std::filesystem::path folder, std::function<void(const std::string&)> note)
      : folder_(std::move(folder)), note_(std::move(note)) {}

  /// A file of ours in the cache on its way to its name, gone with this object.
  struct Passing {
    std::filesystem::path path;
    ~Passing() {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  };

  std::filesystem::path path(const std::string& key, const char* ending) const {
    return folder_ / (key + ending);
  }
  /// A file and its entry, both as they were written.
  bool is_there(const std::string& key, const char* ending) const;
  std::optional<CacheEntry> find(const std::string& key) const {
    return read_cache_entry(path(key, ".json"));
  }
  /// Of a run that has just been found there; throws std::runtime_error where another process has taken it away since.
  CacheEntry entry_of(const std::string& key) const;
  /// Writes the entry of a file that has just been put there.
  void record(const std::string& key, const char* ending, CacheEntry entry) const;
  void write(const std::string& key, const CacheEntry& entry) const;

 private:
  std::filesystem::path folder_;
  std::function<void(const std::string&)> note_;
};

}  // namespace flexura::study
