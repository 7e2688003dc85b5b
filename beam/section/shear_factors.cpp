// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/shear_factors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "beam/section/shape_math.hpp"

namespace flexura::beam {
namespace {

[[noreturn]] void refuse_formula(const Shape& shape, const char* formula, const char* known) {
  throw std::invalid_argument(fmt::format("section {}: there is no shear factor by {} for this shape; use {}",
                                          name_of(shape), formula, known));
}

double cowper_hollow_circle(double m, double nu) {  // m = inner / outer
  const double q = pow2(1.0 + m * m);
  return 6.0 * (1.0 + nu) * q / ((7.0 + 6.0 * nu) * q + (20.0 + 12.0 * nu) * m * m);
}

double hutchinson_hollow_circle(double m, double nu) {
  const double a = 1.0, b = m;
  return 6.0 * pow2(a * a + b * b) * pow2(1.0 + nu) /
         (7 * pow4(a) + 34 * a * a * b * b + 7 * pow4(b) +
          nu * (12 * pow4(a) + 48 * a * a * b * b + 12 * pow4(b)) +
          nu * nu * (4 * pow4(a) + 16 * a * a * b * b + 4 * pow4(b)));
}

// Ellipses: a is the semi-axis along the shear force.
double cowper_ellipse(double a, double b, double nu) {
  return 12.0 * (1.0 + nu) * a * a * (3.0 * a * a + b * b) /
         ((40.0 + 37.0 * nu) * pow4(a) + (16.0 + 10.0 * nu) * a * a * b * b + nu * pow4(b));
}

double hutchinson_ellipse(double a, double b, double nu) {
  const double a2 = a * a, b2 = b * b;
  return 6.0 * a2 * (3.0 * a2 + b2) * pow2(1.0 + nu) /
         (20 * a2 * a2 + 8 * a2 * b2 + nu * (37 * a2 * a2 + 10 * a2 * b2 + b2 * b2) +
          nu * nu * (17 * a2 * a2 + 2 * a2 * b2 - 3 * b2 * b2));
}

double cowper_rectangle(double nu) {
  return 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
}

// depth 2a along the shear force, width 2b.
double hutchinson_rectangle(double a, double b, double nu) {
  double C4 = 4.0 / 45.0 * pow3(a) * b * (-12.0 * a * a - 15.0 * nu * a * a + 5.0 * nu * b * b);
  for (int n = 200; n >= 1; --n)
    C4 +=
        16.0 * nu * nu * pow5(b) * (n * pi * a - b * std::tanh(n * pi * a / b)) / (pow5(n * pi) * (1.0 + nu));
  return -2.0 * (1.0 + nu) / (9.0 / (4.0 * pow5(a) * b) * C4 + nu * (1.0 - b * b / (a * a)));
}

// Thin-walled box: h between the flanges' mid-lines along the force, b between the webs'.
double cowper_box(double h, double b, double web, double flange, double nu) {
  const double m = b * flange / (h * web), n = b / h;
  return 10.0 * (1.0 + nu) * pow2(1.0 + 3.0 * m) /
         (12.0 + 72.0 * m + 150.0 * m * m + 90.0 * pow3(m) +
          nu * (11.0 + 66.0 * m + 135.0 * m * m + 90.0 * pow3(m)) +
          10.0 * n * n * ((3.0 + nu) * m + 3.0 * m * m));
}

// Thin wall of a hollow ellipse, force along z: shear flow q = V/I int z t ds from the top, kappa = I^2 / (A
// int q^2/t ds).
double thin_hollow_ellipse(double a, double b, double a_i, double b_i) {  // semi-axes along y, z
  const MidLine wall(a, b, a_i, b_i);
  double area = 0.0, inertia = 0.0, flow = 0.0, energy = 0.0;
  for (int k = 0; k < wall.n / 4; ++k) {  // a quarter, midpoints, from (0, z_max)
    const auto [y, z, t, ds] = wall.at(0.25 * wall.n - k - 0.5);
    const double middle = flow + 0.5 * z * t * ds;
    flow += z * t * ds;
    area += t * ds;
    inertia += z * z * t * ds;
    energy += middle * middle / t * ds;
  }
  return inertia * inertia / (area * energy);
}

}  // namespace

Shape turned(const Shape& shape) {
  return std::visit(Overload{
                        [](const Circle& s) -> Shape { return s; },
                        [](const HollowCircle& s) -> Shape { return s; },
                        [](const Rectangle& s) -> Shape {
                          return Rectangle{s.height, s.width};
                        },
                        [](const HollowRectangle& s) -> Shape {
                          return HollowRectangle{s.height, s.width, s.flange, s.web};
                        },
                        [](const Ellipse& s) -> Shape {
                          return Ellipse{s.height, s.width};
                        },
                        [](const HollowEllipse& s) -> Shape {
                          return HollowEllipse{s.height, s.width, s.inner_height, s.inner_width};
                        },
                    },
                    shape);
}

double shear_factor(const Shape& shape, double nu, std::optional<ShearFormula> choice) {
  const auto* hollow_ellipse = std::get_if<HollowEllipse>(&shape);
  const ShearFormula formula =
      choice.value_or(hollow_ellipse ? ShearFormula::zero_poisson : ShearFormula::cowper);
  if (formula == ShearFormula::rigid) return std::numeric_limits<double>::infinity();
  if (formula == ShearFormula::zero_poisson) {
    if (hollow_ellipse)
      return thin_hollow_ellipse(hollow_ellipse->width / 2, hollow_ellipse->height / 2,
                                 hollow_ellipse->inner_width / 2, hollow_ellipse->inner_height / 2);
    return shear_factor(shape, 0.0, ShearFormula::cowper);
  }
  const bool cowper = formula == ShearFormula::cowper;
  return std::visit(Overload{
                        [&](const Circle&) {
                          return cowper ? cowper_hollow_circle(0.0, nu) : hutchinson_hollow_circle(0.0, nu);
                        },
                        [&](const HollowCircle& s) {
                          const double m = s.inner_diameter / s.outer_diameter;
                          return cowper ? cowper_hollow_circle(m, nu) : hutchinson_hollow_circle(m, nu);
                        },
                        [&](const Rectangle& s) {
                          return cowper ? cowper_rectangle(nu)
                                        : hutchinson_rectangle(s.height / 2, s.width / 2, nu);
                        },
                        [&](const HollowRectangle& s) -> double {
                          if (!cowper) refuse_formula(shape, "hutchinson", "cowper or zero_poisson");
                          return cowper_box(s.height - s.flange, s.width - s.web, s.web, s.flange, nu);
                        },
                        [&](const Ellipse& s) {
                          return cowper ? cowper_ellipse(s.height / 2, s.width / 2, nu)
                                        : hutchinson_ellipse(s.height / 2, s.width / 2, nu);
                        },
                        [&](const HollowEllipse&) -> double {
                          refuse_formula(shape, cowper ? "cowper" : "hutchinson", "zero_poisson");
                        },
                    },
                    shape);
}

}  // namespace flexura::beam
