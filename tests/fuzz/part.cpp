// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Part files of solids and of beams.
#include "reduce/file/beam_file.hpp"
#include "reduce/file/part_file.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] {
    const auto file = fuzz::file_of("p.toml", fuzz::text_of(data, size));
    if (reduce::is_beam_file(file))
      reduce::read_beam_part(file, {}, {});
    else
      reduce::read_part(file);
  });
}
