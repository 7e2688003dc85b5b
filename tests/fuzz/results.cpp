// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/results/results.hpp"

#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] { results::read(fuzz::file_of("x.h5", fuzz::text_of(data, size))); });
}
