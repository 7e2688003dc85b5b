// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Robots, and the mechanisms that they become.
#include "import/urdf/convert.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] {
    const auto file = fuzz::file_of("r.urdf", fuzz::text_of(data, size));
    import::mechanism_text(import::urdf::to_mechanism(import::urdf::read_robot(file), {}));
  });
}
