// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/section/shapes.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "beam/section/shape_math.hpp"
#include "beam/section/shear_factors.hpp"

namespace flexura::beam {
namespace {

// ---- refusals
// -------------------------------------------------------------------------------------------------------

void require_dimension(const Shape& shape, const char* symbol, double value) {
  if (!(value > 0.0) || !std::isfinite(value))
    throw std::invalid_argument(
        fmt::format("section {}: {} = {:g} must be positive", name_of(shape), symbol, value));
}

void require_inside(const Shape& shape, const char* inner, double inner_value, const char* outer,
                    double outer_value) {
  require_dimension(shape, outer, outer_value);
  if (!(inner_value >= 0.0))
    throw std::invalid_argument(
        fmt::format("section {}: {} = {:g} must not be negative", name_of(shape), inner, inner_value));
  if (!(inner_value < outer_value))
    throw std::invalid_argument(fmt::format("section {}: {} = {:g} must be smaller than {} = {:g}",
                                            name_of(shape), inner, inner_value, outer, outer_value));
}

void check(const Shape& shape) {
  std::visit(
      Overload{
          [&](const Circle& s) { require_dimension(shape, "diameter", s.diameter); },
          [&](const HollowCircle& s) {
            require_inside(shape, "inner_diameter", s.inner_diameter, "outer_diameter", s.outer_diameter);
          },
          [&](const Rectangle& s) {
            require_dimension(shape, "width", s.width);
            require_dimension(shape, "height", s.height);
          },
          [&](const HollowRectangle& s) {
            require_dimension(shape, "web", s.web);
            require_dimension(shape, "flange", s.flange);
            require_inside(shape, "twice the web", 2.0 * s.web, "width", s.width);
            require_inside(shape, "twice the flange", 2.0 * s.flange, "height", s.height);
          },
          [&](const Ellipse& s) {
            require_dimension(shape, "width", s.width);
            require_dimension(shape, "height", s.height);
          },
          [&](const HollowEllipse& s) {
            require_inside(shape, "inner_width", s.inner_width, "width", s.width);
            require_inside(shape, "inner_height", s.inner_height, "height", s.height);
            if ((s.inner_width > 0.0) != (s.inner_height > 0.0))
              throw std::invalid_argument(fmt::format(
                  "section {}: inner_width = {:g} and inner_height = {:g} must both be positive or both zero",
                  name_of(shape), s.inner_width, s.inner_height));
          },
      },
      shape);
}

// ---- torsion
// --------------------------------------------------------------------------------------------------------

double torsion_rectangle(double width, double height) {
  const double a = std::max(width, height), b = std::min(width, height);
  // Saint-Venant's series; terms fall as n^-5: n = 199 leaves 1e-13 of the sum.
  double sum = 0.0;
  for (int n = 199; n >= 1; n -= 2) sum += std::tanh(n * pi * a / (2.0 * b)) / pow5(n);
  return a * pow3(b) * (1.0 / 3.0 - 64.0 / pow5(pi) * b / a * sum);
}

double torsion_hollow_ellipse(double a, double b, double a_i, double b_i) {
  const MidLine wall(a, b, a_i, b_i);
  double flow = 0.0, open = 0.0;
  for (int k = 0; k < wall.n; ++k) {
    const auto [y, z, t, ds] = wall.at(k);
    flow += ds / t;
    open += pow3(t) * ds;
  }
  return 4.0 * pow2(pi * wall.a * wall.b) / flow + open / 3.0;
}

// ---- area and second moments
// ----------------------------------------------------------------------------------------

void fill_ellipse(Constants& c, double a, double b, double a_i, double b_i) {  // semi-axes along y, z
  c.A = pi * (a * b - a_i * b_i);
  c.I_y = pi / 4.0 * (a * pow3(b) - a_i * pow3(b_i));
  c.I_z = pi / 4.0 * (pow3(a) * b - pow3(a_i) * b_i);
  const double q_y = a_i / a, q_z = b_i / b;
  c.I_t = std::abs(q_y - q_z) <= 1e-12 ? pi * pow3(a) * pow3(b) / (a * a + b * b) * (1.0 - pow4(q_y))
                                       : torsion_hollow_ellipse(a, b, a_i, b_i);
}

}  // namespace

std::string name_of(const Shape& shape) {
  static const std::array<const char*, 6> names = {
      "1 Circle", "2 Circle, hollow", "4 Rectangle", "5 Rectangle, hollow", "6 Ellipse", "7 Ellipse, hollow"};
  return names[shape.index()];
}

Constants constants_of(const Shape& shape, double nu, std::optional<ShearFormula> formula) {
  check(shape);
  if (!(nu > -1.0 && nu < 0.5) && formula.value_or(ShearFormula::cowper) != ShearFormula::rigid &&
      formula.value_or(ShearFormula::cowper) != ShearFormula::zero_poisson)
    throw std::invalid_argument(
        fmt::format("section {}: the shear factor needs Poisson's ratio between -1 and 0.5, E and G imply "
                    "{:g}; correct G, or "
                    "choose the shear factor zero_poisson",
                    name_of(shape), nu));
  Constants c;
  std::visit(Overload{
                 [&](const Circle& s) { fill_ellipse(c, s.diameter / 2, s.diameter / 2, 0, 0); },
                 [&](const HollowCircle& s) {
                   fill_ellipse(c, s.outer_diameter / 2, s.outer_diameter / 2, s.inner_diameter / 2,
                                s.inner_diameter / 2);
                 },
                 [&](const Rectangle& s) {
                   c.A = s.width * s.height;
                   c.I_y = s.width * pow3(s.height) / 12.0;
                   c.I_z = pow3(s.width) * s.height / 12.0;
                   c.I_t = torsion_rectangle(s.width, s.height);
                 },
                 [&](const HollowRectangle& s) {
                   const double w = s.width - 2.0 * s.web, h = s.height - 2.0 * s.flange;
                   c.A = s.width * s.height - w * h;
                   c.I_y = (s.width * pow3(s.height) - w * pow3(h)) / 12.0;
                   c.I_z = (pow3(s.width) * s.height - pow3(w) * h) / 12.0;
                   const double w_m = s.width - s.web, h_m = s.height - s.flange;
                   c.I_t = 4.0 * pow2(w_m * h_m) / (2.0 * (w_m / s.flange + h_m / s.web)) +
                           2.0 / 3.0 * (w_m * pow3(s.flange) + h_m * pow3(s.web));
                 },
                 [&](const Ellipse& s) { fill_ellipse(c, s.width / 2, s.height / 2, 0, 0); },
                 [&](const HollowEllipse& s) {
                   fill_ellipse(c, s.width / 2, s.height / 2, s.inner_width / 2, s.inner_height / 2);
                 },
             },
             shape);
  c.A_sz = c.A * shear_factor(shape, nu, formula);
  c.A_sy = c.A * shear_factor(turned(shape), nu, formula);
  return c;
}

Section make_section(std::string name, const Shape& shape, const Material& material,
                     std::optional<ShearFormula> formula) {
  Section section = make_section(std::move(name), constants_of(shape, material.nu(), formula), material);
  section.points = stress_points(shape, *section.constants);
  section.outline = outline_of(shape);
  return section;
}

Shape interpolate(const Shape& first, const Shape& second, double t) {
  if (first.index() != second.index())
    throw std::invalid_argument(fmt::format(
        "a tapered member needs two sections of the same kind, not {} and {}; give both ends the same kind",
        name_of(first), name_of(second)));
  const auto mix = [t](double a, double b) { return (1.0 - t) * a + t * b; };
  return std::visit(Overload{
                        [&](const Circle& a) -> Shape {
                          return Circle{mix(a.diameter, std::get<Circle>(second).diameter)};
                        },
                        [&](const HollowCircle& a) -> Shape {
                          const auto& b = std::get<HollowCircle>(second);
                          return HollowCircle{mix(a.outer_diameter, b.outer_diameter),
                                              mix(a.inner_diameter, b.inner_diameter)};
                        },
                        [&](const Rectangle& a) -> Shape {
                          const auto& b = std::get<Rectangle>(second);
                          return Rectangle{mix(a.width, b.width), mix(a.height, b.height)};
                        },
                        [&](const HollowRectangle& a) -> Shape {
                          const auto& b = std::get<HollowRectangle>(second);
                          return HollowRectangle{mix(a.width, b.width), mix(a.height, b.height),
                                                 mix(a.web, b.web), mix(a.flange, b.flange)};
                        },
                        [&](const Ellipse& a) -> Shape {
                          const auto& b = std::get<Ellipse>(second);
                          return Ellipse{mix(a.width, b.width), mix(a.height, b.height)};
                        },
                        [&](const HollowEllipse& a) -> Shape {
                          const auto& b = std::get<HollowEllipse>(second);
                          return HollowEllipse{mix(a.width, b.width), mix(a.height, b.height),
                                               mix(a.inner_width, b.inner_width),
                                               mix(a.inner_height, b.inner_height)};
                        },
                    },
                    first);
}

std::vector<Loop> outline_of(const Shape& shape, int n) {
  const auto ellipse = [n](double a, double b, bool hole) {
    Loop loop(n, 2);
    for (int k = 0; k < n; ++k) {
      const double phi = (hole ? -1.0 : 1.0) * 2.0 * pi * k / n;
      loop.row(k) << a * std::cos(phi), b * std::sin(phi);
    }
    return loop;
  };
  const auto box = [](double w, double h, bool hole) {
    Loop loop(4, 2);
    if (hole)
      loop << -w / 2, -h / 2, -w / 2, h / 2, w / 2, h / 2, w / 2, -h / 2;
    else
      loop << -w / 2, -h / 2, w / 2, -h / 2, w / 2, h / 2, -w / 2, h / 2;
    return loop;
  };
  std::vector<Loop> loops;
  std::visit(
      Overload{
          [&](const Circle& s) { loops = {ellipse(s.diameter / 2, s.diameter / 2, false)}; },
          [&](const HollowCircle& s) {
            loops = {ellipse(s.outer_diameter / 2, s.outer_diameter / 2, false)};
            if (s.inner_diameter > 0)
              loops.push_back(ellipse(s.inner_diameter / 2, s.inner_diameter / 2, true));
          },
          [&](const Rectangle& s) { loops = {box(s.width, s.height, false)}; },
          [&](const HollowRectangle& s) {
            loops = {box(s.width, s.height, false), box(s.width - 2 * s.web, s.height - 2 * s.flange, true)};
          },
          [&](const Ellipse& s) { loops = {ellipse(s.width / 2, s.height / 2, false)}; },
          [&](const HollowEllipse& s) {
            loops = {ellipse(s.width / 2, s.height / 2, false)};
            if (s.inner_width > 0) loops.push_back(ellipse(s.inner_width / 2, s.inner_height / 2, true));
          },
      },
      shape);
  return loops;
}

}  // namespace flexura::beam
