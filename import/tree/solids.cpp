// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/tree/inertia.hpp"

namespace flexura::import::tree {
namespace {

// Of density 1, about its own origin.
Inertial of(const Solid& solid) {
  const Vector3d& s = solid.size;
  switch (solid.kind) {
    case Solid::Kind::box:
      return box_properties(2.0 * s);
    case Solid::Kind::sphere:
      return sphere_properties(s.x());
    case Solid::Kind::cylinder:
      return cylinder_properties(s.x(), 2.0 * s.y());
    case Solid::Kind::capsule:
      return capsule_properties(s.x(), 2.0 * s.y());
    case Solid::Kind::surface:
      return surface_properties(solid.surface);
    case Solid::Kind::ellipsoid:
      break;
  }
  // A ball drawn out along its axes.
  Inertial ellipsoid = sphere_properties(1.0);
  ellipsoid.mass *= s.prod();
  const Vector3d p = ellipsoid.mass / 5.0 * s.array().square();
  ellipsoid.inertia = Vector3d(p.sum() - p.array()).asDiagonal();
  return ellipsoid;
}

}  // namespace

Inertial together(const Inertial& a, const Inertial& b) {
  if (!(a.mass + b.mass > 0.0)) return {0.0, a.center, a.inertia + b.inertia};
  return a + b;
}

Inertial uniform(const Solid& solid, double density) {
  Inertial inertial = of(solid).in(solid.X_LS);
  inertial.mass *= density;
  inertial.inertia *= density;
  return inertial;
}

}  // namespace flexura::import::tree
