// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/cad/worker/slippage.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace flexura::import::cad {

using Eigen::Vector3d;

namespace {

// Root mean square of n . velocity: CAD programs sweep threads as splines, whose normals are right to some 1e-3; what does not slip is
// off by a tenth and more. A second slippage is told from the first by that gap.
constexpr double kSlips = 5e-3, kHolds = 3e-2;
// A rotation's lead over the distance from the axis: round-off of the splines; the finest threads have 0.01.
constexpr double kNoLead = 3e-3;

}  // namespace

std::optional<Slippage> slippage_of(const Eigen::Matrix<double, Eigen::Dynamic, 3>& points,
                                    const Eigen::Matrix<double, Eigen::Dynamic, 3>& normals) {
  if (points.rows() < 12) return std::nullopt;
  const Vector3d centre = points.colwise().mean().transpose();
  const double n = static_cast<double>(points.rows());
  const double size = std::sqrt((points.rowwise() - centre.transpose()).squaredNorm() / n);
  if (!(size > 0.0)) return std::nullopt;
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Vector3d normal = normals.row(i).transpose(), p = (points.row(i).transpose() - centre) / size;
    Eigen::Matrix<double, 6, 1> row;
    row << p.cross(normal), normal;
    A += row * row.transpose() / n;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> solver(A);
  const Eigen::Matrix<double, 6, 1> twist = solver.eigenvectors().col(0);
  const Vector3d omega = twist.head<3>(), v = twist.tail<3>();
  const auto off = [&](int i) { return std::sqrt(std::max(0.0, solver.eigenvalues()(i))); };
  // Of twists of unit length: a thread far longer than wide hardly moves by the rotation alone.
  if (off(0) > kSlips || off(1) < kHolds * 0.1 || off(1) < 10.0 * off(0)) return std::nullopt;
  if (omega.norm() < 1e-6) return std::nullopt;
  Slippage found;
  found.axis = omega.normalized();
  found.point = centre + size * omega.cross(v) / omega.squaredNorm();
  double from_axis = 0.0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    from_axis += (points.row(i).transpose() - found.point).cross(found.axis).norm() / n;
  const double along = size * omega.dot(v) / omega.squaredNorm();  // in one radian
  if (std::abs(along) > kNoLead * from_axis) found.lead = 2.0 * std::numbers::pi * along;
  return found;
}

}  // namespace flexura::import::cad
