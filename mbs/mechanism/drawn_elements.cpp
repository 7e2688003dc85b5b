// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/mechanism/drawn_elements.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "mbs/bodies/beams/planar_beam.hpp"
#include "mbs/bodies/modal_data.hpp"

namespace flexura::mbs {
namespace {

const PlanarBeam* planar(const Mechanism& mechanism, int body) {
  return dynamic_cast<const PlanarBeam*>(mechanism.deforming(body));
}

// Of a beam that deforms in modal coordinates; null of any other body.
std::shared_ptr<const superelement::Superelement> reduced(const Mechanism& mechanism, int body) {
  return mechanism.deforming(body) ? mechanism.description().bodies[static_cast<std::size_t>(body)].of_beam
                                   : nullptr;
}

}  // namespace

std::vector<DrawnElement> drawn_elements(const Mechanism& mechanism) {
  std::vector<DrawnElement> out;
  const auto& bodies = mechanism.description().bodies;
  for (int b = 0; b < static_cast<int>(bodies.size()); ++b)
    if (const PlanarBeam* const beam = planar(mechanism, b)) {
      for (int k = 1; k <= beam->elements(); ++k)
        out.push_back({fmt::format("{}.element_{}", bodies[static_cast<std::size_t>(b)].name, k), b,
                       beam->element_length()});
    } else if (const auto& se = reduced(mechanism, b)) {
      const auto& points = se->surface.vertices;
      for (Eigen::Index k = 1; k < points.rows(); ++k)
        out.push_back({fmt::format("{}.element_{}", bodies[static_cast<std::size_t>(b)].name, k), b,
                       (points.row(k) - points.row(k - 1)).norm()});
    }
  return out;
}

std::vector<Pose> drawn_chords(const Mechanism& mechanism, int body, const State& s) {
  if (const PlanarBeam* const beam = planar(mechanism, body))
    return beam->chords(mechanism.modal_coordinates(body, s));
  std::vector<Pose> out;
  const auto& se = reduced(mechanism, body);
  if (!se) return out;
  const FlexibleBody& deforms = *mechanism.deforming(body);
  const Eigen::VectorXd u = se->shapes.cast<double>() *
                            (deforms.modal()->Y * Eigen::Map<const Eigen::VectorXd>(
                                                      mechanism.modal_coordinates(body, s), deforms.m()));
  const auto at = [&](Eigen::Index k) {
    return Vector3d(se->surface.vertices.row(k).transpose() + u.segment<3>(3 * k));
  };
  for (Eigen::Index k = 1; k < se->surface.vertices.rows(); ++k) {
    const Vector3d along = (at(k) - at(k - 1)).normalized();
    out.push_back(
        {Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix(), at(k - 1)});
  }
  return out;
}

}  // namespace flexura::mbs
