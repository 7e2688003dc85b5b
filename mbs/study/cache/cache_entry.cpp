// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/cache/cache_entry.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numeric>

#include "mbs/base/documents/content_hash.hpp"
#include "mbs/base/files/json_text.hpp"

namespace flexura::study {
namespace {

using nlohmann::json;

bool is_time(double seconds) {
  return std::isfinite(seconds) && seconds >= 0.0;
}
bool are_times(const json& value) {
  return value.is_array() &&
         std::ranges::all_of(value, [](const json& x) { return x.is_number() && is_time(x.get<double>()); });
}

}  // namespace

double CacheEntry::total_wall() const {
  return std::accumulate(wall.begin(), wall.end(), 0.0);
}

json to_json(const CacheEntry& entry) {
  json out = {{"choice", entry.choice},
              {"exit_code", entry.exit_code},
              {"peak_memory", entry.peak_memory},
              {"wall", entry.wall},
              {"cpu", entry.cpu},
              {"content", entry.content}};
  if (!entry.failure.empty()) out["failure"] = entry.failure;
  out["checksum"] = checksum_of(out);
  return out;
}

std::string checksum_of(json entry) {
  entry.erase("checksum");
  // Texts that are no UTF-8 are replaced, not refused: their checksum does not fit then, which is enough.
  return input::ContentHash().add(entry.dump(-1, ' ', false, json::error_handler_t::replace)).hex();
}

std::string content_of(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return "";
  try {
    return input::ContentHash().add_file(file).hex();
  } catch (const std::runtime_error&) {
    return "";
  }
}

std::optional<CacheEntry> cache_entry_of(std::string_view text) {
  const json in = files::try_read_json(text);
  const auto has = [&in](const char* key, auto&& is_right) {
    const auto found = in.find(key);
    return found != in.end() && is_right(*found);
  };
  const auto is_text = [](const json& x) { return x.is_string(); };
  if (!in.is_object() || !has("choice", is_text) || !has("content", is_text) ||
      !has("checksum", [&](const json& x) { return x == checksum_of(in); }) ||
      (in.contains("failure") && !has("failure", is_text)) ||
      !has("exit_code", [](const json& x) { return x.is_number_integer(); }) || !has("wall", are_times) ||
      !has("cpu", are_times) ||
      !has("peak_memory", [](const json& x) { return x.is_number() && is_time(x.get<double>()); }))
    return std::nullopt;
  CacheEntry entry;
  entry.choice = in["choice"];
  entry.content = in["content"];
  entry.failure = in.value("failure", "");
  entry.exit_code = in["exit_code"];
  entry.wall = in["wall"].get<std::vector<double>>();
  entry.cpu = in["cpu"].get<std::vector<double>>();
  entry.peak_memory = in["peak_memory"];
  return entry;
}

std::optional<CacheEntry> read_cache_entry(const std::filesystem::path& file) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return std::nullopt;
  std::ifstream in(file);
  if (!in) return std::nullopt;
  return cache_entry_of(std::string(std::istreambuf_iterator<char>(in), {}));
}

}  // namespace flexura::study
