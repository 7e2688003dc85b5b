// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <variant>

#include "beam/section/section.hpp"

/// The standard sections, SIMBEAM types 1, 2, 4, 5, 6, 7, and their constants.
///
/// Torsion constants I_t: circle and ellipse (solid, and hollow with similar inner contour) exact,
/// Saint-Venant: pi a^3 b^3 / (a^2 + b^2) (1 - q^4); rectangle exact by Saint-Venant's series (Timoshenko,
/// Goodier, Theory of Elasticity, art. 109); hollow rectangle and general hollow ellipse by Bredt's formula
/// plus the open part, 4 A_m^2 / oint ds/t + 1/3 oint t^3 ds (EN 10210-2, annex A, without corner radii): for
/// thin walls.
///
/// Shear areas A_s = kappa A, by choice of
///   cowper        G. R. Cowper, The shear coefficient in Timoshenko's beam theory, J. Appl. Mech. 33 (1966)
///                 335-340.  Circle, hollow circle, rectangle, thin-walled box, ellipse.
///   hutchinson    J. R. Hutchinson, Shear coefficients for Timoshenko beam theory, J. Appl. Mech. 68 (2001)
///                 87-92, which agrees with N. G. Stephen, J. Appl. Mech. 47 (1980) 121-127.  Circle, hollow
///                 circle, rectangle, ellipse.
///   zero_poisson  Saint-Venant's flexure without lateral contraction, where all definitions agree (Cowper at
///                 nu = 0): 5/6 for the rectangle, 6/7 for the circle; hollow ellipse by thin-wall shear flow.
///                 Every shape.
///   rigid         no shear deformation: A_s infinite.
/// Without a choice: cowper, for the hollow ellipse zero_poisson.
namespace flexura::beam {

enum class ShearFormula { cowper, hutchinson, zero_poisson, rigid };

/// 1 Circle: diameter [m].
struct Circle {
  double diameter = 0.0;
};
/// 2 Circle, hollow.
struct HollowCircle {
  double outer_diameter = 0.0, inner_diameter = 0.0;
};
/// 4 Rectangle: width along y, height along z.
struct Rectangle {
  double width = 0.0, height = 0.0;
};
/// 5 Rectangle, hollow: outer width and height; `web` is the thickness of the two walls that run along z,
/// `flange` of the two that run along y.
struct HollowRectangle {
  double width = 0.0, height = 0.0, web = 0.0, flange = 0.0;
};
/// 6 Ellipse: full axes along y and z.
struct Ellipse {
  double width = 0.0, height = 0.0;
};
/// 7 Ellipse, hollow: full outer and inner axes.
struct HollowEllipse {
  double width = 0.0, height = 0.0, inner_width = 0.0, inner_height = 0.0;
};

using Shape = std::variant<Circle, HollowCircle, Rectangle, HollowRectangle, Ellipse, HollowEllipse>;

/// Name and SIMBEAM number for tables: "1 Circle".
std::string name_of(const Shape& shape);

/// Constants about the centroid, which is the origin O.  Throws std::invalid_argument for a dimension that is
/// not positive, walls that leave no hole, an inner contour that does not lie inside, or a formula that does
/// not exist for the shape (naming those that do).
Constants constants_of(const Shape& shape, double nu, std::optional<ShearFormula> formula = {});

/// Section of a standard shape with its outline and stress points (see stress_points).
Section make_section(std::string name, const Shape& shape, const Material& material,
                     std::optional<ShearFormula> formula = {});

/// The shape between two of the same kind, every dimension linear in t (0: first, 1: second): tapered
/// members. Throws std::invalid_argument for different kinds.
Shape interpolate(const Shape& first, const Shape& second, double t);

/// Extreme points of the contour, by stress_on_outline() (outline_stress.hpp), and the centre of a solid section.
std::vector<StressPoint> stress_points(const Shape& shape, const Constants& constants);

/// Contour as polygons, `n` vertices for each closed curve.
std::vector<Loop> outline_of(const Shape& shape, int n = 48);

}  // namespace flexura::beam
