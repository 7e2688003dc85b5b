// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

/// A prismatic beam as a mechanism file states it, [body.NAME.beam], and what the fidelities make of it:
///
/// | fidelity | the beam is                                                                                 |
/// |----------|---------------------------------------------------------------------------------------------|
/// | rigid    | a rigid body                                                                                |
/// | segments | rigid pieces joined by the beam's stiffness                                                 |
/// | ancf     | a beam of the absolute nodal coordinate formulation, ancf_part.hpp                          |
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
  double mass_per_length = 1.0;         ///< [kg/m]
  double rho_I_y = 0.0, rho_I_z = 0.0;  ///< int z^2 dm, int y^2 dm per length [kg m]
  double damping_time = 0.0;            ///< Kelvin-Voigt [s]
  std::vector<std::pair<std::string, double>>
      points;  ///< places for markers by their distance from the root [m]

  double length() const { return (to_B - from_B).norm(); }
  /// Axes of the section: x along the beam, y, z.  Throws std::invalid_argument for a beam without length or
  /// a y axis along it.
  Matrix3d R_BE() const;
  /// "root", "tip" and the points, with their places in B.
  std::vector<std::pair<std::string, Vector3d>> stations() const;
};

RigidInertia rigid_inertia(const BeamPart& part);

/// Nodes as in stations().  Throws std::invalid_argument.
std::shared_ptr<const FlexibleBody> ancf_body(const BeamPart& part);

/// A chain of rigid pieces.
struct Segments {
  std::vector<int> bodies;          ///< of each piece, from the root
  std::vector<Vector3d> origins_B;  ///< of each piece's frame in B, that of the first
  Vector3d root_B = Vector3d::Zero(), axis_B = Vector3d::UnitX();
  double element_length = 1.0;

  /// The piece that a point of the undeformed body belongs to.
  int piece_at(const Vector3d& p_B) const;
};

/// Makes body `root` (in `d`, the piece at the root) a chain: inertia, further bodies "NAME.1", ...,
/// six-dimensional joints "NAME.joint_1", ... and springs "NAME.spring_1", ....
Segments add_segments(MechanismDescription& d, int root, const BeamPart& part);

}  // namespace flexura::mbs
