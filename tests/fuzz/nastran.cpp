// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/nastran.hpp"

#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] { mesh::read_nastran(fuzz::file_of("x.nastran", fuzz::text_of(data, size))); });
}
