// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/gmsh/worker/recognise.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

namespace flexura::mesh {
namespace {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3>;
constexpr double kTolerance = 1e-5;

/// Direction in which the rows of `vectors` vary least, and their root mean square along it.
std::pair<Eigen::Vector3d, double> least_direction(const Points& vectors) {
  const Eigen::Matrix3d moment = vectors.transpose() * vectors / static_cast<double>(vectors.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(moment);
  const Eigen::Vector3d direction = solver.eigenvectors().col(0);
  return {direction, (vectors * direction).norm() / std::sqrt(static_cast<double>(vectors.rows()))};
}

Eigen::Vector3d with_definite_sign(const Eigen::Vector3d& a) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(a[k]) > 1e-9) return a[k] > 0 ? a : Eigen::Vector3d(-a);
  return a;
}

/// Least squares of p = c + R n; returns c, R and the greatest residual.
struct Centre {
  Eigen::Vector3d c;
  double R, residual;
};
Centre fit_centre(const Points& p, const Points& n) {
  const Eigen::RowVector3d p_mean = p.colwise().mean(), n_mean = n.colwise().mean();
  const Points dp = p.rowwise() - p_mean, dn = n.rowwise() - n_mean;
  const double nn = dn.squaredNorm();
  const double R = nn > 0 ? dp.cwiseProduct(dn).sum() / nn : 0;
  return {(p_mean - R * n_mean).transpose(), R, (dp - R * dn).rowwise().norm().maxCoeff()};
}

}  // namespace

void recognise(const Points& points, const Points& normals, Face& face) {
  face.kind = FaceKind::other;
  if (points.rows() < 4) return;
  const Eigen::RowVector3d p_mean = points.colwise().mean(), n_mean = normals.colwise().mean();
  const Points p = points.rowwise() - p_mean, dn = normals.rowwise() - n_mean;
  const double extent = p.rowwise().norm().maxCoeff();
  if (!(extent > 0)) return;

  if (dn.rowwise().norm().maxCoeff() < kTolerance) {
    face.kind = FaceKind::plane;
    face.normal = n_mean.transpose().normalized();
    return;
  }
  if (const Centre sphere = fit_centre(p, normals); sphere.residual < kTolerance * extent) {
    face.kind = FaceKind::sphere;
    face.axis_point = p_mean.transpose() + sphere.c;
    face.radius = std::abs(sphere.R);
    face.hole = sphere.R < 0;
    return;
  }
  const auto place_on_axis = [&](const Eigen::Vector3d& axis, const Eigen::Vector3d& point) {
    face.axis = with_definite_sign(axis);
    const Eigen::VectorXd height = (p.rowwise() - point.transpose()) * face.axis;
    face.length = height.maxCoeff() - height.minCoeff();
    face.axis_point = p_mean.transpose() + point + 0.5 * (height.maxCoeff() + height.minCoeff()) * face.axis;
  };
  if (const auto [axis, rms] = least_direction(normals); rms < kTolerance) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    const Centre circle = fit_centre(p * across, normals * across);
    if (circle.residual < kTolerance * extent) {
      face.kind = FaceKind::cylinder;
      face.radius = std::abs(circle.R);
      face.hole = circle.R < 0;
      place_on_axis(axis, across * circle.c);
    }
    return;  // a general cylinder otherwise
  }
  if (const auto [axis, rms] = least_direction(dn); rms < kTolerance) {
    const Eigen::VectorXd height = normals.cwiseProduct(p).rowwise().sum();
    const Eigen::Vector3d apex = normals.colPivHouseholderQr().solve(height);
    if ((normals * apex - height).cwiseAbs().maxCoeff() > kTolerance * extent) return;
    face.kind = FaceKind::cone;
    place_on_axis(axis, apex);
    const Eigen::Vector3d middle = face.axis_point - p_mean.transpose() - apex;
    // |n . a| = sin(half angle); the radius grows with the distance from the apex as its tangent.
    const double sine = std::abs(n_mean.dot(face.axis));
    face.radius = middle.norm() * sine / std::sqrt(std::max(1e-300, 1 - sine * sine));
    const Eigen::Vector3d from_axis =
        (p.row(0).transpose() - apex) - face.axis * face.axis.dot(p.row(0).transpose() - apex);
    face.hole = from_axis.dot(normals.row(0).transpose()) < 0;
  }
}

}  // namespace flexura::mesh
