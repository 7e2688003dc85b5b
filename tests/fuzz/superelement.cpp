// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/superelement/file.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] {
    superelement::read(fuzz::file_of("x.se.h5", fuzz::text_of(data, size)), {.matrices = true,
                                                                             .inertia = true,
                                                                             .stiffening = true,
                                                                             .surface = true,
                                                                             .shapes = true,
                                                                             .stress = true,
                                                                             .sections = true,
                                                                             .mesh_error = true});
  });
}
