// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/import/abaqus.hpp"

#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] { mesh::read_abaqus(fuzz::file_of("x.abaqus", fuzz::text_of(data, size))); });
}
