// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/scene/scene_physics.hpp"

/// Bodies as sums over their points: with r = R (x + Phi q) of a point from Bo and J its displacements by the body's
/// coordinates,
///
///     M = sum m J^T J,     f = sum m J^T (gravity - w x (w x r) - 2 w x R Phi q') - (omega^2 q + 2 zeta omega q')
namespace flexura::mbs::chance {

namespace {

Matrix3d cross(const Vector3d& a) {
  Matrix3d A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

// Points on the principal axes, two on each, with the body's mass, centre and second moments.
PointBody rigid_points(const SceneBody& body) {
  const Matrix3d second = 0.5 * body.inertia.trace() * Matrix3d::Identity() - body.inertia;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(second);
  PointBody out;
  out.x.resize(3, 6);
  out.mass = Eigen::VectorXd::Constant(6, body.mass / 6.0);
  for (int i = 0; i < 3; ++i) {
    const Vector3d arm =
        std::sqrt(std::max(0.0, 3.0 * axes.eigenvalues()(i) / body.mass)) * axes.eigenvectors().col(i);
    out.x.col(2 * i) = body.center + arm;
    out.x.col(2 * i + 1) = body.center - arm;
  }
  out.Phi.resize(18, 0);
  return out;
}

PointBody flexible_points(const SceneBody& body) {
  return {body.part->points(), body.part->mass(), body.part->shapes().leftCols(body.modes),
          body.part->omega2().head(body.modes), body.damping};
}

// r of point k.
Vector3d at(const PointBody& points, Eigen::Index k, const Place& place) {
  return place.X_WB.R * (points.x.col(k) + points.Phi.middleRows(3 * k, 3) * place.q);
}
Vector3d velocity(const PointBody& points, Eigen::Index k, const BodyMotion& m) {
  return m.V.linear + m.V.angular.cross(at(points, k, m.place)) +
         m.place.X_WB.R * (points.Phi.middleRows(3 * k, 3) * m.q_dot);
}

}  // namespace

PointBody points_of(const SceneBody& body) {
  return body.part ? flexible_points(body) : rigid_points(body);
}

Eigen::MatrixXd ScenePhysics::mass_matrix(int b, const Place& place) const {
  const PointBody& points = points_[b];
  const int n = scene_.bodies[b].n_dofs();
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n), J(3, n);
  for (Eigen::Index k = 0; k < points.mass.size(); ++k) {
    J << -cross(at(points, k, place)), Matrix3d::Identity(), place.X_WB.R * points.Phi.middleRows(3 * k, 3);
    M += points.mass(k) * J.transpose() * J;
  }
  return M;
}

Eigen::VectorXd ScenePhysics::body_forces(int b, const BodyMotion& m) const {
  const PointBody& points = points_[b];
  const Vector3d& w = m.V.angular;
  Eigen::VectorXd f = Eigen::VectorXd::Zero(scene_.bodies[b].n_dofs());
  for (Eigen::Index k = 0; k < points.mass.size(); ++k) {
    const Eigen::MatrixXd shapes = m.place.X_WB.R * points.Phi.middleRows(3 * k, 3);
    const Vector3d r = at(points, k, m.place);
    const Vector3d push =
        points.mass(k) * (scene_.gravity - w.cross(w.cross(r)) - 2.0 * w.cross(Vector3d(shapes * m.q_dot)));
    f.head<3>() += r.cross(push);
    f.segment<3>(3) += push;
    f.tail(scene_.bodies[b].modes) += shapes.transpose() * push;
  }
  f.tail(scene_.bodies[b].modes) -= points.omega2.cwiseProduct(m.place.q) +
                                    2.0 * points.damping * points.omega2.cwiseSqrt().cwiseProduct(m.q_dot);
  return f;
}

Eigen::MatrixXd ScenePhysics::inverse_root_mass(const Places& places) const {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(n_, n_);
  for (int b = 1; b < n_bodies(); ++b) {
    const int n = scene_.bodies[b].n_dofs();
    D.block(first(b), first(b), n, n) =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(mass_matrix(b, places[b])).operatorInverseSqrt();
  }
  return D;
}

double ScenePhysics::kinetic(const std::vector<BodyMotion>& motion) const {
  double T = 0.0;
  for (int b = 1; b < n_bodies(); ++b)
    for (Eigen::Index k = 0; k < points_[b].mass.size(); ++k)
      T += 0.5 * points_[b].mass(k) * velocity(points_[b], k, motion[b]).squaredNorm();
  return T;
}

Vector3d ScenePhysics::momentum(const std::vector<BodyMotion>& motion) const {
  Vector3d p = Vector3d::Zero();
  for (int b = 1; b < n_bodies(); ++b)
    for (Eigen::Index k = 0; k < points_[b].mass.size(); ++k)
      p += points_[b].mass(k) * velocity(points_[b], k, motion[b]);
  return p;
}

Vector3d ScenePhysics::angular_momentum(const std::vector<BodyMotion>& motion) const {
  Vector3d L = Vector3d::Zero();
  for (int b = 1; b < n_bodies(); ++b)
    for (Eigen::Index k = 0; k < points_[b].mass.size(); ++k)
      L += (motion[b].place.X_WB.p + at(points_[b], k, motion[b].place))
               .cross(points_[b].mass(k) * velocity(points_[b], k, motion[b]));
  return L;
}

double ScenePhysics::mass() const {
  double m = 0.0;
  for (const PointBody& body : points_) m += body.mass.sum();
  return m;
}

Vector3d ScenePhysics::centre(const std::vector<BodyMotion>& motion) const {
  Vector3d c = Vector3d::Zero();
  for (int b = 1; b < n_bodies(); ++b)
    for (Eigen::Index k = 0; k < points_[b].mass.size(); ++k)
      c += points_[b].mass(k) * (motion[b].place.X_WB.p + at(points_[b], k, motion[b].place));
  return c / mass();
}

double ScenePhysics::deformation(const Places& places) const {
  double largest = 0.0;
  for (int b = 1; b < n_bodies(); ++b) {
    if (!scene_.bodies[b].part || scene_.bodies[b].beam) continue;
    const Eigen::Matrix3Xd& x = points_[b].x;
    const double across = (x.rowwise().maxCoeff() - x.rowwise().minCoeff()).norm();
    const Eigen::VectorXd u = points_[b].Phi * places[b].q;
    for (Eigen::Index k = 0; k < x.cols(); ++k)
      largest = std::max(largest, u.segment<3>(3 * k).norm() / across);
  }
  return largest;
}

}  // namespace flexura::mbs::chance
