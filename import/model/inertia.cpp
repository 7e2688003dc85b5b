// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/model/inertia.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <stdexcept>

namespace flexura::import {
namespace {

Matrix3d steiner(double mass, const Vector3d& from_center) {
  return mass * (from_center.squaredNorm() * Matrix3d::Identity() - from_center * from_center.transpose());
}

}  // namespace

bool is_inertia(const Matrix3d& I) {
  const Vector3d m = Eigen::SelfAdjointEigenSolver<Matrix3d>(I, Eigen::EigenvaluesOnly).eigenvalues();
  return m[0] >= -1e-12 * m.cwiseAbs().maxCoeff() && m[0] + m[1] >= 0.99 * m[2];
}

Matrix3d nearest_inertia(const Matrix3d& I) {
  const double s = 0.5 * I.trace();
  if (!(s > 0.0))
    throw std::invalid_argument("the sum of its principal moments is not positive; correct their signs");
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(I);
  const Vector3d p = s - axes.eigenvalues().array();  // falling
  double shift = 0.0, sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    sum += p[k];
    if (const double all = (sum - s) / (k + 1); p[k] > all) shift = all;
  }
  const Vector3d moments = s - (p.array() - shift).max(0.0);
  return axes.eigenvectors() * moments.asDiagonal() * axes.eigenvectors().transpose();
}

MassProperties MassProperties::operator+(const MassProperties& other) const {
  MassProperties out;
  out.mass = mass + other.mass;
  out.center = (mass * center + other.mass * other.center) / out.mass;
  out.inertia = inertia + steiner(mass, center - out.center) + other.inertia +
                steiner(other.mass, other.center - out.center);
  return out;
}

MassProperties MassProperties::in(const Pose& X) const {
  return {mass, X * center, X.R * inertia * X.R.transpose()};
}

MassProperties box_properties(const Vector3d& size) {
  MassProperties out{.mass = size.prod()};
  const Vector3d p = out.mass / 12.0 * size.array().square();
  out.inertia.diagonal() = p.sum() - p.array();
  return out;
}

MassProperties cylinder_properties(double radius, double length) {
  MassProperties out{.mass = std::numbers::pi * radius * radius * length};
  const double across = out.mass * (radius * radius / 4.0 + length * length / 12.0);
  out.inertia.diagonal() << across, across, out.mass * radius * radius / 2.0;
  return out;
}

MassProperties sphere_properties(double radius) {
  MassProperties out{.mass = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius};
  out.inertia.diagonal().setConstant(0.4 * out.mass * radius * radius);
  return out;
}

MassProperties capsule_properties(double radius, double length) {
  // The half spheres: a sphere's moments about its middle, with the centres of the halves 3 r / 8 from the cylinder's ends.
  MassProperties out = cylinder_properties(radius, length), ball = sphere_properties(radius);
  const double off = 3.0 / 8.0 * radius, at = 0.5 * length + off;
  const double across = ball.inertia(0, 0) + ball.mass * (at * at - off * off);
  out.inertia += Vector3d(across, across, ball.inertia(2, 2)).asDiagonal();
  out.mass += ball.mass;
  return out;
}

MassProperties surface_properties(const Surface& surface) {
  if (surface.triangles.empty()) return {};
  const Vector3d o = surface.vertices.front();  // near the body, so that little cancels
  double volume = 0.0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();
  for (const Eigen::Vector3i& t : surface.triangles) {
    Matrix3d A;
    for (int k = 0; k < 3; ++k) A.col(k) = surface.vertices[static_cast<std::size_t>(t[k])] - o;
    // Of a tetrahedron (0, a, b, c): V = det / 6, V/4 sum, V/20 (sum of a a^T + s s^T).
    const double V = A.determinant() / 6.0;
    const Vector3d s = A.rowwise().sum();
    volume += V;
    first += V / 4.0 * s;
    second += V / 20.0 * (A * A.transpose() + s * s.transpose());
  }
  if (volume < 0.0) {
    volume = -volume;
    first = -first;
    second = -second;
  }
  MassProperties out{.mass = volume};
  if (!(volume > 0.0)) return out;
  const Vector3d c = first / volume;
  second -= volume * c * c.transpose();
  out.center = o + c;
  out.inertia = second.trace() * Matrix3d::Identity() - second;
  return out;
}

}  // namespace flexura::import
