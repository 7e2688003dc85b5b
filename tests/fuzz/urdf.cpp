// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Robots, and the mechanisms that they become.
#include "import/urdf/convert.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  return fuzz::judged([&] {
    import::Findings findings("r.urdf");
    auto robot = import::urdf::read_robot(fuzz::text_of(data, size), findings);
    auto mechanism = import::urdf::to_mechanism(std::move(robot), {}, findings);
    import::tell(findings, mechanism);
    import::mechanism_text(mechanism);
  });
}
