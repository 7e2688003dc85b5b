// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
// Formulas, quantities with units.
#include <cmath>

#include "mbs/base/documents/units.hpp"
#include "mbs/formulas/expression.hpp"
#include "tests/fuzz/judge.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace flexura;
  const std::string text = fuzz::text_of(data, size);
  fuzz::judged([&] { input::try_parse_measured(text); });
  fuzz::judged([&] { input::parse_quantity(text, input::dim::angular_velocity); });
  return fuzz::judged([&] {
    mbs::SignalNames names;
    for (const char* name : {"crank.angle", "crank.speed", "x"}) names.add(name);
    const mbs::Curves tables = {
        {"lift", std::make_shared<mbs::Curve>(std::vector<double>{0, 1, 2}, std::vector<double>{0, 3, 1},
                                              mbs::Curve::Interpolation::cubic, mbs::Curve::Outside::hold)}};
    const mbs::Expression f("f", text, names, {{"load", 3.0}, {"omega", 2.0}}, tables);
    const double signals[] = {0.3, 1.0, -2.0, 0.0};
    if (!std::isfinite(f.evaluate(signals))) std::abort();
    for (const int place : f.reads()) f.derivative(signals, place);
    if (f.reads().empty()) f.time_derivatives(0.3);
  });
}
