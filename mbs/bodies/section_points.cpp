// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/bodies/section_points.hpp"

#include <cmath>

namespace flexura::mbs {

void SectionPoints::add_point(const std::string& name, const Eigen::Vector3d& wanted) {
  Eigen::Index place = 0;
  const double square =
      (forces_.positions.rowwise() - wanted.transpose()).rowwise().squaredNorm().minCoeff(&place);
  points_.push_back({name, std::sqrt(square)});
  of_modes_.emplace_back(forces_.S.middleRows(6 * place, 6) * Y_);
  if (has_loads()) of_loads_.emplace_back(forces_.of_loads.middleRows(6 * place, 6));
}

SectionForce SectionPoints::at(int point, const double* s, const double* factors) const {
  const auto k = static_cast<std::size_t>(point);
  SectionForce out = of_modes_[k] * Eigen::Map<const Eigen::VectorXd>(s, Y_.cols());
  if (factors && has_loads())
    out += of_loads_[k] * Eigen::Map<const Eigen::VectorXd>(factors, of_loads_[k].cols());
  return out;
}

}  // namespace flexura::mbs
