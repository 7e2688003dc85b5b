// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cmath>

#include "tests/beam/ancf/exact/catenary.hpp"
#include "tests/beam/ancf/exact/elastica.hpp"

namespace flexura::beam::exact {
namespace {

TEST(ExactElastica, AgreesWithMattiassonsTable) {
  // K. Mattiasson, Int. J. Numer. Meth. Eng. 17 (1981) 145, table I: alpha, shortening, deflection, tip
  // angle; five decimals printed, so half of the last.
  const double table[][4] = {{1, 0.05643, 0.30172, 0.46135},
                             {2, 0.16064, 0.49346, 0.78175},
                             {5, 0.38763, 0.71379, 1.21537},
                             {10, 0.55500, 0.81061, 1.43029}};
  for (const auto& [alpha, shortening, deflection, angle] : table) {
    const Elastica tip = elastica_tip_load(alpha);
    EXPECT_NEAR(tip.shortening, shortening, 0.5001e-5) << alpha;
    EXPECT_NEAR(tip.deflection, deflection, 0.5001e-5) << alpha;
    EXPECT_NEAR(tip.tip_angle, angle, 0.5001e-5) << alpha;
  }
}

TEST(ExactElastica, TendsToTheLinearBeam) {
  // deflection = alpha/3 (1 - O(alpha^2)), angle = alpha/2 (1 - O(alpha^2)).
  const double alpha = 1e-3;
  EXPECT_NEAR(elastica_tip_load(alpha).deflection, alpha / 3, alpha * alpha * alpha);
  EXPECT_NEAR(elastica_tip_load(alpha).tip_angle, alpha / 2, alpha * alpha * alpha);
}

TEST(ExactCatenary, IsTheInextensibleCatenaryForStiffCables) {
  // L_0 = 2 c sinh(a/2c), sag = c (cosh(a/2c) - 1), H = w c: take c = 1, a = 2.
  const double L_0 = 2 * std::sinh(1.0), W = 3.0 * L_0;
  const Catenary cable(L_0, W, 1e12, 2.0);
  // Stretch of order W/EA = 1e-11.
  EXPECT_NEAR(cable.H(), 3.0, 1e-9);
  EXPECT_NEAR(cable.y(0.5 * L_0), -(std::cosh(1.0) - 1), 1e-10);
  EXPECT_NEAR(cable.y(L_0), 0.0, 1e-12);
}

TEST(ExactCatenary, StretchesWithItsTension) {
  // ds/ds_0 = 1 + T/EA with T^2 = H^2 + V^2, by central differences (h^2 third derivatives: 1e-8).
  const Catenary cable(3.0, 6.0, 20.0, 2.5);
  const double s = 0.8, h = 1e-4, V = 3.0 - 6.0 * s / 3.0;
  const double dx = (cable.x(s + h) - cable.x(s - h)) / (2 * h),
               dy = (cable.y(s + h) - cable.y(s - h)) / (2 * h);
  EXPECT_NEAR(std::hypot(dx, dy), 1 + std::hypot(cable.H(), V) / 20.0, 1e-7);
  EXPECT_NEAR(cable.x(3.0), 2.5, 1e-12);
}

}  // namespace
}  // namespace flexura::beam::exact
