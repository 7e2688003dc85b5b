// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "beam/model/section_stress.hpp"

#include <cmath>

namespace flexura::beam {

double PointStress::von_mises() const {
  return std::sqrt(sigma_xx * sigma_xx + 3.0 * (tau_xy * tau_xy + tau_xz * tau_xz));
}

std::vector<PointStress> section_stresses(const BeamMesh& mesh, int member, double x,
                                          const Vector6d& resultants) {
  const Model& model = mesh.model();
  const Member& m = model.members.at(member);
  const SectionEntry& first = model.sections[m.section];
  std::vector<StressPoint> points = first.section.points;
  if (m.section_at_end >= 0) {
    const double t = x / placement_of(model, m).length;
    const Shape shape = interpolate(*first.shape, *model.sections[m.section_at_end].shape, t);
    points = stress_points(shape, constants_of(shape, first.section.material->nu(), first.formula));
  }
  std::vector<PointStress> stresses;
  for (const StressPoint& point : points) {
    const Eigen::Vector3d s = point.S * resultants;
    stresses.push_back({point.name, point.y, point.z, s(0), s(1), s(2)});
  }
  return stresses;
}

}  // namespace flexura::beam
