// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "reduce/assembly/input/rigid_motion.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <stdexcept>

namespace flexura::reduce {
namespace {

// z scaled so that all six entries are displacements of the body's size: (t + w x centre, w length).
Eigen::Matrix<double, 6, 6> from_scaled(const Eigen::Vector3d& centre, double length) {
  Eigen::Matrix<double, 6, 6> S = Eigen::Matrix<double, 6, 6>::Identity();
  S.bottomRightCorner<3, 3>() /= length;
  for (int a = 0; a < 3; ++a) S.block<3, 1>(0, 3 + a) = -Eigen::Vector3d::Unit(a).cross(centre) / length;
  return S;
}

std::string print(Eigen::Vector3d v, double length) {
  for (int a = 0; a < 3; ++a)
    if (std::abs(v(a)) < 1e-9 * length) v(a) = 0.0;
  return fmt::format("({:.4g}, {:.4g}, {:.4g})", v(0), v(1), v(2));
}

std::string describe(const Vector6& z, double length) {
  const Eigen::Vector3d t = z.head<3>(), w = z.tail<3>();
  if (w.norm() * length < 1e-6 * t.norm()) {
    Eigen::Vector3d direction = t.normalized();
    if (direction.sum() < 0.0) direction = -direction;
    return "translation along " + print(direction, 1.0);
  }
  Eigen::Vector3d axis = w.normalized();
  if (axis.sum() < 0.0) axis = -axis;
  const Eigen::Vector3d through = w.cross(t) / w.squaredNorm();
  const double pitch = t.dot(w) / w.squaredNorm();
  std::string text =
      "rotation about the axis " + print(axis, 1.0) + " through " + print(through, length) + " m";
  if (std::abs(pitch) > 1e-6 * length)
    text += fmt::format(" with a slide of {:.3g} m per radian along it", pitch);
  return text;
}

}  // namespace

Eigen::Matrix<double, 3, 6> motion_at(const Eigen::Vector3d& x) {
  Eigen::Matrix<double, 3, 6> D;
  D << 1, 0, 0, 0, x(2), -x(1),  //
      0, 1, 0, -x(2), 0, x(0),   //
      0, 0, 1, x(1), -x(0), 0;
  return D;
}

Eigen::Matrix<double, 6, 6> node_motion_at(const Eigen::Vector3d& x) {
  Eigen::Matrix<double, 6, 6> D = Eigen::Matrix<double, 6, 6>::Identity();
  D.topRows<3>() = motion_at(x);
  return D;
}

Eigen::Matrix<double, 6, Eigen::Dynamic> free_motions(
    const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 6>>& H, const Eigen::Vector3d& centre,
    double length) {
  const Eigen::Matrix<double, 6, 6> S = from_scaled(centre, length);
  const Eigen::Matrix<double, Eigen::Dynamic, 6> scaled = H * S;
  // The squared singular values suffice: a motion held by less than 1e-6 of the others is as good as free.
  const Eigen::Matrix<double, 6, 6> gram = scaled.transpose() * scaled;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(gram, Eigen::ComputeFullV);
  int rank = 0;
  while (rank < 6 && svd.singularValues()(rank) > 1e-12 * std::max(svd.singularValues()(0), 1e-300)) ++rank;
  return S * svd.matrixV().rightCols(6 - rank);
}

void require_held(const Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, 6>>& H,
                  const Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>& points) {
  const Eigen::Vector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
  const Eigen::Vector3d centre = 0.5 * (low + high);
  const double length = high != low ? 0.5 * (high - low).norm() : 1.0;
  const auto free = free_motions(H, centre, length);
  if (free.cols() == 0) return;
  throw std::invalid_argument(
      fmt::format("the interfaces together leave the body free to move ({} of six rigid motions), for "
                  "instance a {}: add an interface or retain more directions",
                  free.cols(), describe_motion(free, centre, length)));
}

std::string describe_motion(const Eigen::Matrix<double, 6, Eigen::Dynamic>& free,
                            const Eigen::Vector3d& centre, double length) {
  // Of several free motions prefer one that is easy to say: an axis of B, if such a motion is among them.
  const Eigen::Matrix<double, 6, 6> S = from_scaled(centre, length);
  const Eigen::MatrixXd scaled = S.inverse() * free;
  const Eigen::MatrixXd basis = Eigen::HouseholderQR<Eigen::MatrixXd>(scaled).householderQ() *
                                Eigen::MatrixXd::Identity(6, scaled.cols());
  for (int k = 0; k < 6; ++k) {
    const Vector6 candidate = Vector6::Unit(k);
    if ((candidate - basis * (basis.transpose() * candidate)).norm() < 1e-6)
      return describe(S * candidate, length);
  }
  return describe(free.col(0), length);
}

}  // namespace flexura::reduce
