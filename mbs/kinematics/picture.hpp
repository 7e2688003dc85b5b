// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mbs/kinematics/body_path.hpp"

/// What pictures draw of an element beside its markers.
namespace flexura::mbs {

/// A surface that is touched, in the axes of the marker F that carries it.
struct DrawnSurface {
  std::string kind;     ///< plane (xy of F), sphere (about F), cylinder (about z), curve (in xy), body (F's)
  double radius = 0.0;  ///< of a sphere or cylinder [m]
  std::vector<Vector3d> points{};  ///< along a curve, which is drawn out along z [m]
  bool is_closed = false;          ///< the curve
  double touching = 0.0;  ///< radius of the sphere about M that touches; 0: a point, or a body's own surface
};

/// Elements that have something to draw derive from this, too.
class HasPicture {
 public:
  virtual ~HasPicture() = default;
  virtual std::optional<DrawnSurface> drawn_surface() const { return std::nullopt; }
  /// The line along which the element's output "place" stands.
  virtual const BodyPath* drawn_path() const { return nullptr; }
};

}  // namespace flexura::mbs
