// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

/// Constants of cross-sections by their shape, which decks name (nastran_sections.hpp, abaqus_beam_sections.hpp).  y and z are the
/// element's axes; all moments about the centroid.
namespace flexura::mesh {

struct BarSection {
  double A = 0, I_yy = 0, I_zz = 0, I_yz = 0;  ///< I_yy = int z^2 dA, I_zz = int y^2 dA, I_yz = int y z dA
  double J = 0;                                ///< torsion constant of Saint-Venant
  double kappa_y = 0, kappa_z = 0;             ///< shear factors; 0: no shear deformation
  double node_y = 0, node_z = 0;               ///< the deck's node, from the centroid (Abaqus' I)
  double shear_y = 0, shear_z = 0;  ///< shear centre, from the centroid (thin walls; Roark, table of 9.2)
  std::vector<Eigen::Vector2d> outline =
      {};  ///< where bending stresses are largest, around; from the centroid
};

/// The corners of the convex hull of points (y, z), around; fewer than three where they lie in one line.
std::vector<Eigen::Vector2d> hull(std::vector<Eigen::Vector2d> points);

/// A rectangle of the section, with its middle at (y, z).
struct Wall {
  double y, z, along_y, along_z;
};

BarSection circle(double radius);
/// Of the semi-axes along y and z.  J by Saint-Venant; shear factors Cowper's (1966) for nu = 0.
BarSection ellipse(double along_y, double along_z);
/// J = I_p; shear factors of a thin wall, 1/2, to those of the full circle, 6/7 (Cowper 1966, nu = 0).
BarSection tube(double outer_radius, double inner_radius);
/// J by Saint-Venant's series (Timoshenko, Goodier, art. 109); shear factors 5/6.
BarSection rectangle(double along_y, double along_z);
/// Outer measures; `side` is the thickness of the two walls that run along z, `flange` of those along y.  J by
/// Bredt; shear factors: the walls along the force.
BarSection box(double along_y, double along_z, double side, double flange);
/// Open sections: J the sum of length thickness^3 / 3; shear factors: the walls along the force.  The shear centre (y, z)
/// is given where the walls are.
BarSection open_section(const std::vector<Wall>& walls, double shear_y, double shear_z);

/// A wall of a thin-walled section, between two points.
struct Line {
  std::size_t from, to;
  double thickness;
};
/// The shear centre (y, z) of an open one; its walls are a tree, each from where an earlier one ends.
Eigen::Vector2d thin_shear_centre(const std::vector<Eigen::Vector2d>& points, const std::vector<Line>& lines);

/// Of the height between the middles of two flanges, the share at which the shear centre stands above the lower one (0 to 1): as their
/// moments of inertia about the web.
double flange_centre(double lower_thickness, double lower_width, double upper_thickness, double upper_width);

}  // namespace flexura::mesh
