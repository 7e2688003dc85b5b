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
}

SectionForce SectionPoints::at(int point, const double* s) const {
  return of_modes_[static_cast<std::size_t>(point)] * Eigen::Map<const Eigen::VectorXd>(s, Y_.cols());
}

}  // namespace flexura::mbs
