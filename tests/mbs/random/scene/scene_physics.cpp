// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/mbs/random/scene/scene_physics.hpp"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "mbs/base/math/rotation.hpp"
#include "tests/mbs/random/differences.hpp"

namespace flexura::mbs::chance {

namespace {
constexpr double kRankLost = 1e-7;
}

PointBody points_of(const SceneBody& body);  // scene_points.cpp

Places places_of(const std::vector<BodyMotion>& motion) {
  Places places;
  for (const BodyMotion& body : motion) places.push_back(body.place);
  return places;
}

ScenePhysics::ScenePhysics(const Scene& scene) : scene_(scene), first_(1, 0), points_(1) {
  for (int b = 1; b < n_bodies(); ++b) {
    first_.push_back(n_);
    n_ += scene.bodies[b].n_dofs();
    points_.push_back(points_of(scene.bodies[b]));
  }
  const Places places = scene.places();
  std::vector<Vector3d> seen;
  for (int m = 0; m < static_cast<int>(scene.markers.size()); ++m) seen.push_back(marker(m, places).p);
  for (int b = 1; b < n_bodies(); ++b)
    seen.push_back(places[b].X_WB.p), seen.push_back(places[b].X_WB * scene.bodies[b].center);
  size_ = 0.1;
  for (const Vector3d& p : seen)
    for (const Vector3d& q : seen) size_ = std::max(size_, (p - q).norm());
  list_rows();
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    for (std::size_t i = 0; i < turns_[j].size(); ++i)
      turns_[j][i] =
          coordinate_value(scene.joints[j], coordinates_of(scene.joints[j].type)[i],
                           marker(scene.joints[j].F, places).inverse() * marker(scene.joints[j].M, places));
}

Places ScenePhysics::moved(const Places& places, const Eigen::VectorXd& d) const {
  Places out = places;
  for (int b = 1; b < n_bodies(); ++b) {
    out[b].X_WB.R = rotation_exp(d.segment<3>(first(b))) * places[b].X_WB.R;
    out[b].X_WB.p += d.segment<3>(first(b) + 3);
    out[b].q += d.segment(first(b) + 6, scene_.bodies[b].modes);
  }
  return out;
}

Places ScenePhysics::later(const std::vector<BodyMotion>& motion, double dt) const {
  return moved(places_of(motion), dt * speeds(motion));
}

Eigen::VectorXd ScenePhysics::speeds(const std::vector<BodyMotion>& motion) const {
  Eigen::VectorXd v(n_);
  for (int b = 1; b < n_bodies(); ++b)
    v.segment(first(b), scene_.bodies[b].n_dofs()) << motion[b].V.angular, motion[b].V.linear,
        motion[b].q_dot;
  return v;
}

// Differences in time take steps that turn, move and deform no body far.
double ScenePhysics::calm(const Eigen::VectorXd& v) const {
  double fastest = 1.0;
  for (int b = 1; b < n_bodies(); ++b) {
    fastest = std::max({fastest, v.segment<3>(first(b)).norm(), v.segment<3>(first(b) + 3).norm() / size_});
    if (scene_.bodies[b].part)
      fastest = std::max(fastest, v.segment(first(b) + 6, scene_.bodies[b].modes).norm());
  }
  return 1.0 / fastest;
}

Eigen::MatrixXd ScenePhysics::jacobian(const Places& X, double t) const {
  Eigen::MatrixXd G(n_rows(), n_);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(n_);
  for (int b = 1; b < n_bodies(); ++b) scale.segment<3>(first(b) + 3).setConstant(size_);
  for (int i = 0; i < n_; ++i) {
    const Eigen::VectorXd d = scale(i) * Eigen::VectorXd::Unit(n_, i);
    G.col(i) = first_difference([&](double h) { return rows(moved(X, h * d), t); }, kFirst) / scale(i);
    if (slip_rows_.empty()) continue;
    const Eigen::VectorXd slides = slip(X, Eigen::VectorXd::Unit(n_, i));
    for (std::size_t k = 0; k < slip_rows_.size(); ++k)
      G(slip_rows_[k], i) = slides(static_cast<Eigen::Index>(k));
  }
  return G;
}

Eigen::VectorXd ScenePhysics::rates(const std::vector<BodyMotion>& motion, double t) const {
  const Places X = places_of(motion);
  const Eigen::VectorXd v = speeds(motion);
  Eigen::VectorXd out =
      first_difference([&](double h) { return rows(moved(X, h * v), t + h); }, kFirst * calm(v));
  const Eigen::VectorXd slides = slip(X, v);
  for (std::size_t k = 0; k < slip_rows_.size(); ++k)
    out(slip_rows_[k]) = slides(static_cast<Eigen::Index>(k));
  return out;
}

Eigen::VectorXd ScenePhysics::gamma(const std::vector<BodyMotion>& motion, double t) const {
  const Places X = places_of(motion);
  const Eigen::VectorXd v = speeds(motion);
  Eigen::VectorXd out =
      second_difference([&](double h) { return rows(moved(X, h * v), t + h); }, kSecond * calm(v));
  if (slip_rows_.empty()) return out;
  const Eigen::VectorXd slides =
      first_difference([&](double h) { return slip(moved(X, h * v), v); }, kFirst * calm(v));
  for (std::size_t k = 0; k < slip_rows_.size(); ++k)
    out(slip_rows_[k]) = slides(static_cast<Eigen::Index>(k));
  return out;
}

double ScenePhysics::speed(int j, int i, const std::vector<BodyMotion>& motion) const {
  const Places X = places_of(motion);
  const Eigen::VectorXd v = speeds(motion);
  return slope([&](double h) { return value(j, i, moved(X, h * v)); }, kFirst * calm(v));
}

Eigen::VectorXd ScenePhysics::row_scale() const {
  Eigen::VectorXd scale(n_rows());
  for (int k = 0; k < n_rows(); ++k) scale(k) = is_length_[k] ? 1.0 / size_ : 1.0;
  return scale;
}

namespace {
ScenePhysics::Rank rank_of(const Eigen::VectorXd& sigma) {
  ScenePhysics::Rank rank;
  if (sigma.size() == 0 || sigma(0) == 0.0) return rank;
  for (const double s : sigma) {
    if (s > kRankLost * sigma(0)) {
      ++rank.rank;
      rank.smallest = s / sigma(0);
    } else {
      rank.next = std::max(rank.next, s / sigma(0));
    }
  }
  return rank;
}
// Rows of one length each: a gear of 100 teeth is no better row than one of 10.
void normalise(Eigen::MatrixXd& G, Eigen::VectorXd& right) {
  const double largest = G.size() > 0 ? G.rowwise().norm().maxCoeff() : 0.0;
  for (Eigen::Index k = 0; k < G.rows(); ++k) {
    const double norm = G.row(k).norm();
    if (!(norm > 1e-6 * largest)) continue;
    G.row(k) /= norm;
    right(k) /= norm;
  }
}
}  // namespace

ScenePhysics::Rank ScenePhysics::rank(const Places& X, double t) const {
  if (n_rows() == 0) return {};
  Eigen::MatrixXd G = row_scale().asDiagonal() * jacobian(X, t) * inverse_root_mass(X);
  Eigen::VectorXd none = Eigen::VectorXd::Zero(n_rows());
  normalise(G, none);
  return rank_of(Eigen::JacobiSVD<Eigen::MatrixXd>(G).singularValues());
}

ScenePhysics::Gauss ScenePhysics::accelerations(const std::vector<BodyMotion>& motion, double t) const {
  const Places X = places_of(motion);
  const Eigen::MatrixXd D = inverse_root_mass(X);  // M^-1/2
  const Eigen::VectorXd free = D * (D * forces(motion, t));
  Gauss out{free, 0.0, {}};
  if (n_rows() == 0) return out;
  const Eigen::VectorXd scale = row_scale();
  const Eigen::MatrixXd G = scale.asDiagonal() * jacobian(X, t);
  const Eigen::VectorXd gamma_now = scale.cwiseProduct(gamma(motion, t));
  Eigen::VectorXd wanted = -gamma_now - G * free;
  Eigen::MatrixXd GD = G * D;
  const Eigen::VectorXd before = wanted;
  normalise(GD, wanted);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(GD, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& sigma = svd.singularValues();
  out.rank = rank_of(sigma);
  Eigen::VectorXd y = svd.matrixU().transpose() * wanted;
  for (Eigen::Index i = 0; i < sigma.size(); ++i) y(i) = i < out.rank.rank ? y(i) / sigma(i) : 0.0;
  const Eigen::VectorXd step = svd.matrixV() * y;
  out.a += D * step;
  out.contradiction = (GD * step - wanted).cwiseAbs().maxCoeff();
  return out;
}

double ScenePhysics::close(Places& X, double t) const {
  const Eigen::VectorXd scale = row_scale();
  double left = 0.0;
  for (int pass = 0; pass < 12; ++pass) {
    const Eigen::VectorXd g = scale.cwiseProduct(rows(X, t));
    left = g.size() > 0 ? g.cwiseAbs().maxCoeff() : 0.0;
    if (left < 1e-13) break;
    const Eigen::MatrixXd D = inverse_root_mass(X);
    const Eigen::MatrixXd G = scale.asDiagonal() * jacobian(X, t) * D;
    Eigen::JacobiSVD<Eigen::MatrixXd> svd(G, Eigen::ComputeThinU | Eigen::ComputeThinV);
    svd.setThreshold(kRankLost);
    X = moved(X, D * svd.solve(-g));
  }
  return left;
}

ScenePhysics::Nature ScenePhysics::nature(std::string* why) const {
  const auto say = [&](std::string text, Nature nature) {
    if (why) *why = std::move(text);
    return nature;
  };
  Places X = scene_.places();
  if (n_rows() == 0) return say("no rows", Nature::moves);
  const double open = row_scale().cwiseProduct(rows(X, 0.0)).cwiseAbs().maxCoeff();
  if (open > 1e-6) {
    if (close(X, 0.0) > 1e-9) return say("its rows do not close", Nature::unclear);
  }
  const Rank here = rank(X, 0.0);
  if (!here.is_clear())
    return say(fmt::format("singular values {:.1e} and {:.1e}", here.smallest, here.next), Nature::unclear);
  // A little later, and a little elsewhere along a freedom.
  const double dt = 0.01;
  Places later = X;
  const double left = close(later, dt);
  if (left > 1e-7) return say(fmt::format("rows are open by {:.1e} at {} s", left, dt), Nature::contradicts);
  if (rank(later, dt).rank != here.rank) return say("its rank changes at once", Nature::unclear);
  const Eigen::MatrixXd D = inverse_root_mass(X);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(row_scale().asDiagonal() * jacobian(X, 0.0) * D,
                                              Eigen::ComputeFullV);
  for (int i = here.rank; i < n_; ++i) {
    const Eigen::VectorXd along = D * svd.matrixV().col(i);
    Places beside = moved(X, 0.03 / along.norm() * along);
    if (close(beside, 0.0) > 1e-10) return say("a freedom of the instant alone", Nature::unclear);
    if (rank(beside, 0.0).rank != here.rank) return say("its rank changes beside", Nature::unclear);
  }
  return say("", Nature::moves);
}

}  // namespace flexura::mbs::chance
