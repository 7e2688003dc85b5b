// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/ancf/element/hermite.hpp"

#include <array>
#include <stdexcept>
#include <string>

namespace flexura::beam::ancf {

namespace {

// Abscissas and weights on [-1, 1] (Abramowitz and Stegun, table 25.4), moved to [0, 1].
constexpr QuadraturePoint at(double x, double w) {
  return {0.5 * (1 + x), 0.5 * w};
}

constexpr std::array<QuadraturePoint, 1> kOne{at(0, 2)};
constexpr std::array<QuadraturePoint, 2> kTwo{at(-0.577350269189625764509, 1),
                                              at(0.577350269189625764509, 1)};
constexpr std::array<QuadraturePoint, 3> kThree{at(-0.774596669241483377036, 5.0 / 9.0), at(0, 8.0 / 9.0),
                                                at(0.774596669241483377036, 5.0 / 9.0)};
constexpr std::array<QuadraturePoint, 4> kFour{at(-0.861136311594052575224, 0.347854845137453857373),
                                               at(-0.339981043584856264803, 0.652145154862546142627),
                                               at(0.339981043584856264803, 0.652145154862546142627),
                                               at(0.861136311594052575224, 0.347854845137453857373)};
constexpr std::array<QuadraturePoint, 5> kFive{at(-0.906179845938663992798, 0.236926885056189087514),
                                               at(-0.538469310105683091036, 0.478628670499366468041),
                                               at(0, 128.0 / 225.0),
                                               at(0.538469310105683091036, 0.478628670499366468041),
                                               at(0.906179845938663992798, 0.236926885056189087514)};

constexpr std::array<QuadraturePoint, 3> kSimpson{{{0, 1.0 / 6}, {0.5, 4.0 / 6}, {1, 1.0 / 6}}};

}  // namespace

std::span<const QuadraturePoint> lobatto_rule() {
  return kSimpson;
}

std::span<const QuadraturePoint> gauss_rule(int n) {
  switch (n) {
    case 1:
      return kOne;
    case 2:
      return kTwo;
    case 3:
      return kThree;
    case 4:
      return kFour;
    case 5:
      return kFive;
    default:
      throw std::invalid_argument("Gauss rule with " + std::to_string(n) +
                                  " points asked for, but only 1 to 5 are tabulated.");
  }
}

}  // namespace flexura::beam::ancf
