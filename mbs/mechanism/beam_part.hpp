// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "beam/exact/strain_field.hpp"
#include "beam/section/section.hpp"
#include "mbs/mechanism/mechanism.hpp"

/// A prismatic beam as a mechanism file states it, [body.NAME.beam], and what the fidelities make of it:
///
/// | fidelity | the beam is                                                                                 |
/// |----------|---------------------------------------------------------------------------------------------|
/// | rigid    | a rigid body                                                                                |
/// | segments | rigid pieces joined by the beam's stiffness                                                 |
/// | ancf     | a beam of the absolute nodal coordinate formulation, ancf_part.hpp                          |
/// | beam     | geometrically exact elements, each welded to the one before, exact_element.hpp              |
/// | rod      | the same without stretch and shear                                                          |
/// | cable    | the same with stretch and bending alone                                                     |
///
/// Segments (R. L. Huston, Comput. Struct. 13 (1981) 349).  n equal elements of length l give n + 1 pieces
/// about the nodes, half an element to either side.  Neighbours are joined at the middle of the element
/// between them by the six-dimensional spring of the element that is exact for end loads
/// (beam/element/element.hpp),
///
///     F = l f + l^3/12 D^T f D,   K = F^-1,   f = C^-1,   D_(M_y, V_z) = 1, D_(M_z, V_y) = -1
///
/// so that loads on the nodes deflect the chain as they do the beam.
namespace flexura::mbs {

struct BeamPart {
  Vector3d from_B = Vector3d::Zero(), to_B = Vector3d::UnitX();  ///< the axis, root to tip [m]
  Vector3d y_axis_B = Vector3d::UnitY();                         ///< the section's y, made normal to the axis
  int elements = 10;
  /// About the axis, N, V_y, V_z, T, M_y, M_z [N, N m, N m^2].
  Matrix6d C = Matrix6d::Identity();
  double mass_per_length = 1.0;             ///< [kg/m]
  double rho_I_y = 0.0, rho_I_z = 0.0;      ///< int z^2 dm, int y^2 dm per length [kg m]
  double m_y = 0.0, m_z = 0.0, m_yz = 0.0;  ///< int y dm, int z dm [kg], int y z dm [kg m] per length
  double damping_time = 0.0;                ///< Kelvin-Voigt [s]
  /// Of the stress-free axis about the section's axes [1/m], of geometrically exact beams alone: to_B is then where the
  /// tip would be were it straight.
  Vector3d curvature = Vector3d::Zero();
  /// Of geometrically exact beams: they bend in the plane of the axis and y_axis_B alone.
  bool is_planar = false;
  std::vector<std::pair<std::string, double>>
      points;  ///< places for markers by their distance from the root [m]

  double length() const { return (to_B - from_B).norm(); }
  /// Axes of the section: x along the beam, y, z.  Throws std::invalid_argument for a beam without length or
  /// a y axis along it.
  Matrix3d R_BE() const;
  /// The section's axes and place in B at the distance x from the root along the axis, nothing strained.
  Pose section_at(double x) const;
  beam::SectionInertia section_inertia() const;
  /// "root", "tip" and the points, with their places in B.
  std::vector<std::pair<std::string, Vector3d>> stations() const;
};

RigidInertia rigid_inertia(const BeamPart& part);

/// Nodes as in stations().  Throws std::invalid_argument.
std::shared_ptr<const FlexibleBody> ancf_body(const BeamPart& part);

/// A chain of pieces: rigid ones, or elements.
struct Segments {
  /// Where a station is: on a node of a piece, or fixed to it at p (in its frame).
  struct Seat {
    int body = -1, node = -1;
    Vector3d p = Vector3d::Zero();
  };
  std::vector<int> bodies;          ///< of each piece, from the root
  std::vector<Vector3d> origins_B;  ///< of each piece's frame in B, that of the first
  Vector3d root_B = Vector3d::Zero(), axis_B = Vector3d::UnitX();
  double element_length = 1.0;
  /// Of elements: of each of the stations() of the beam.
  std::vector<Seat> seats;

  /// The piece that a point of the undeformed body belongs to.
  int piece_at(const Vector3d& p_B) const;
};

/// Makes body `root` (in `d`, the piece at the root) a chain: inertia, further bodies "NAME.1", ...,
/// six-dimensional joints "NAME.joint_1", ... and springs "NAME.spring_1", ....
Segments add_segments(MechanismDescription& d, int root, const BeamPart& part);

/// Makes body `root` a chain of geometrically exact elements, the first of them in its own frame: bodies "NAME.1", ...,
/// each with its frame at its start, parallel to B where nothing is strained, and welds "NAME.weld_1", ....  Throws
/// std::invalid_argument.  Of a planar beam the bodies are pieces of many elements (planar_beam.hpp).
Segments add_exact_elements(MechanismDescription& d, int root, const BeamPart& part, beam::exact::Kind kind);

}  // namespace flexura::mbs
