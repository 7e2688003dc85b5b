// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <string>

/// Rigid motions z = (t, w): u(x) = t + w x x, small rotations w about Bo, frame B.
namespace flexura::reduce {

using Vector6 = Eigen::Matrix<double, 6, 1>;

/// 3 x 6: u(x) = motion_at(x) z.
Eigen::Matrix<double, 3, 6> motion_at(const Eigen::Vector3d& x);

/// 6 x 6: displacement and rotation (u, theta) of a rigidly attached node at x are node_motion_at(x) z.
Eigen::Matrix<double, 6, 6> node_motion_at(const Eigen::Vector3d& x);

/// The motions z with H z = 0 to round-off (6 x p, p = 0 ... 6).  Rows of H are displacements per z; `length`
/// [m] and `centre` make translations and rotations comparable.
Eigen::Matrix<double, 6, Eigen::Dynamic> free_motions(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 6>>& H, const Eigen::Vector3d& centre,
    double length);

/// std::invalid_argument, with one of the motions, where rows H leave a body of these nodes free to move.
void require_held(const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 6>>& H,
                  const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points);

/// "rotation about the axis (0, 0, 1) through (0.1, 0, 0) m" and the like, for the first of the free motions.
std::string describe_motion(const Eigen::Matrix<double, 6, Eigen::Dynamic>& free,
                            const Eigen::Vector3d& centre, double length);

}  // namespace flexura::reduce
