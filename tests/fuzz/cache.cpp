// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// What the cache of a study keeps of a run.
#include <cmath>

#include "mbs/study/cache_entry.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] {
    const auto entry = study::cache_entry_of(fuzz::text_of(data, size));
    if (entry && !(entry->total_wall() >= 0.0)) fuzz::found("a time that is none", "");
  });
}
