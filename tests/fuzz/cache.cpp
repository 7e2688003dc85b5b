// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the cache of a study keeps of a run.
#include <cmath>

#include "mbs/base/files/json_text.hpp"
#include "mbs/study/cache/cache_entry.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  std::string text = fuzz::text_of(data, size);
  // The checksum is made to fit, so that mutations reach what stands behind it.
  try {
    if (auto json = files::try_read_json(text); json.is_object()) {
      json["checksum"] = study::checksum_of(json);
      text = json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }
  } catch (const std::exception&) {
  }
  return fuzz::judged([&] {
    const auto entry = study::cache_entry_of(text);
    if (entry && !(entry->total_wall() >= 0.0)) fuzz::found("a time that is none", "");
  });
}
