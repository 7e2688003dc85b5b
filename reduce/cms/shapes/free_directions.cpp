// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/cms/shapes/free_directions.hpp"

#include <algorithm>
#include <cmath>

#include "reduce/assembly/input/rigid_motion.hpp"

namespace flexura::reduce {

using Eigen::Index;
using Eigen::MatrixXd;

void set_free_motion(ReducedInterface& interface, const MatrixXd& motion, const MatrixXd& R_b) {
  if (interface.directions.empty()) return;  // a rigid piece of the part
  const MatrixXd R = node_motion_at(interface.point), moved = motion.leftCols(R_b.rows()) * R_b;
  for (int d = 0; d < 6; ++d) {
    if (std::ranges::find(interface.directions, d) != interface.directions.end()) continue;
    // Rigid motions are exact in the shapes but for round-off; a direction that is not there is off by all of itself.
    constexpr double kApart = 1e-7;
    const double size =
        R.row(d).norm() + motion.row(d).head(R_b.rows()).cwiseAbs().dot(R_b.cwiseAbs().rowwise().maxCoeff());
    if (!((moved.row(d) - R.row(d)).norm() <= kApart * size)) continue;
    const auto k = static_cast<Index>(interface.free.size());
    interface.free.push_back(d);
    interface.free_motion.conservativeResize(k + 1, motion.cols());
    interface.free_motion.row(k) = motion.row(d);
  }
}

}  // namespace flexura::reduce
