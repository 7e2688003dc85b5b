// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/bodies/modal_body.hpp"
#include "mbs/mechanism/mechanism.hpp"
#include "tests/mbs/model/lattice.hpp"

namespace flexura::mbs::test {

/// A crank, a flexible rod and a slider: a closed loop and modes.
inline MechanismDescription flexible_engine(bool closed) {
  const lattice::Lattice l = lattice::make_lattice(6, 4e4);
  const Vector3d left = l.se.interfaces[0].p_BoN_B, right = l.se.interfaces[1].p_BoN_B;
  const double length = (right - left).norm();
  MechanismDescription d;
  d.gravity = {0.0, -9.81, 0.0};
  const int crank = d.add_body(
      {.name = "crank",
       .inertia = RigidInertia::from_center(1.0, {0.1 * length, 0, 0}, Matrix3d::Identity() * 0.1)});
  const int rod = d.add_body({.name = "rod", .flexible = std::make_shared<ModalBody>(modal_data(l.se))});
  const int slider =
      d.add_body({.name = "slider",
                  .inertia = RigidInertia::from_center(1.0, Vector3d::Zero(), Matrix3d::Identity() * 0.1)});
  Pose pin, along_x;
  pin.p = {0.3 * length, 0.0, 0.0};
  along_x.R.col(0) = Vector3d::UnitY();
  along_x.R.col(1) = Vector3d::UnitZ();
  along_x.R.col(2) = Vector3d::UnitX();
  const int shaft = d.add_joint("shaft", "revolute", d.add_marker(0, "shaft"), d.add_marker(crank, "shaft"));
  d.joints[shaft].initial_speeds[0] = 3.0;
  d.add_joint("pin", "revolute", d.add_marker(crank, "pin", pin), d.add_marker(rod, "left", {}, 0));
  d.add_joint("guide", "prismatic", d.add_marker(0, "guide", along_x),
              d.add_marker(slider, "guide", along_x));
  if (closed)
    d.joints[d.add_joint("wrist", "spherical", d.add_marker(rod, "right", {}, 1),
                         d.add_marker(slider, "wrist"))]
        .cut = true;
  return d;
}

}  // namespace flexura::mbs::test
