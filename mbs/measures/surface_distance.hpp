// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>

#include "mbs/kinematics/surface_mesh.hpp"
#include "mbs/measures/shown_measure.hpp"

namespace flexura::mbs {

/// How near the surfaces of two bodies come to each other, as their modes deform them; 0 where they cross.  Of the triangles: round
/// faces are nearer to each other by what their facets stand off.
class SurfaceDistance final : public ShownMeasure {
 public:
  /// Bodies with the markers of their frames.
  SurfaceDistance(std::string name, int body_A, int A, std::shared_ptr<const SurfaceMesh> of_A, int body_B,
                  int B, std::shared_ptr<const SurfaceMesh> of_B)
      : ShownMeasure(std::move(name)),
        body_A_(body_A),
        A_(A),
        body_B_(body_B),
        B_(B),
        of_A_(std::move(of_A)),
        of_B_(std::move(of_B)) {}
  input::Dimension dimension() const override { return input::dim::length; }
  double value(const Kinematics& kin, const double*) const override {
    return SurfaceMesh::between(*of_A_, kin.bodies[static_cast<std::size_t>(body_A_)].s, *of_B_,
                                kin.bodies[static_cast<std::size_t>(body_B_)].s, kin.relative_pose(A_, B_))
        .distance;
  }

 private:
  int body_A_, A_, body_B_, B_;
  std::shared_ptr<const SurfaceMesh> of_A_, of_B_;
};

}  // namespace flexura::mbs
