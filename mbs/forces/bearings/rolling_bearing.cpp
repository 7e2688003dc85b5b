// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/bearings/rolling_bearing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mbs/forces/contacts/hertz.hpp"

namespace flexura::mbs {
namespace {

constexpr int slices_of_roller = 30;

// Both contacts of a ball, one after the other.
double ball_stiffness(const RollingGeometry& g) {
  const double modulus = g.youngs_modulus / (1.0 - g.poissons_ratio * g.poissons_ratio);
  const double gamma = g.diameter * std::cos(g.contact_angle) / g.pitch_diameter;
  const auto contact = [&](double groove, double rolling) {
    const double sum = 4.0 - 1.0 / groove + rolling, difference = 1.0 / groove + rolling;
    return hertz::point_stiffness(sum / g.diameter, difference / sum, modulus);
  };
  const double inner = contact(g.groove_inner, 2.0 * gamma / (1.0 - gamma));
  const double outer = contact(g.groove_outer, -2.0 * gamma / (1.0 + gamma));
  return std::pow(std::pow(inner, -2.0 / 3.0) + std::pow(outer, -2.0 / 3.0), -1.5);
}

void check(const RollingGeometry& g) {
  const auto need = [](bool holds, const char* rule) {
    if (!holds) throw std::invalid_argument(rule);
  };
  need(g.count >= 3, "a rolling bearing needs three rolling elements at least");
  need(g.diameter > 0.0 && g.pitch_diameter > g.diameter,
       "the rolling elements must be smaller than the pitch diameter");
  need(g.count * std::asin(g.diameter / g.pitch_diameter) <= std::numbers::pi,
       "so many rolling elements do not fit on the pitch diameter");
  // Shrink fits of rings leave microns, some 0.5 % of a ball; Hertz' contacts are small beside what touches.
  need(g.clearance >= -0.02 * g.diameter,
       "the interference (negative clearance) is more than 2 % of a rolling element, far beyond what its "
       "contacts bear");
  need(g.contact_angle >= 0.0 && g.contact_angle < 0.5 * std::numbers::pi,
       "the contact angle lies between 0 and 90 deg (excluded)");
  if (g.kind == RollingGeometry::Kind::roller) {
    need(g.length > 0.0, "a roller needs a length");
    return;
  }
  need(g.groove_inner > 0.5 && g.groove_outer > 0.5,
       "the grooves must be wider than the balls: radius / diameter above 0.5");
  need(g.youngs_modulus > 0.0 && g.poissons_ratio >= 0.0 && g.poissons_ratio <= 0.5,
       "the elastic constants of balls and grooves must be positive, Poisson's ratio at most 0.5");
}

}  // namespace

struct RollingBearing::State {
  double energy = 0.0, largest = 0.0;
  int loaded = 0;
  Vector3d a;
  Vector6d gradient = Vector6d::Zero();  ///< of the energy by (p, a)
  Matrix6d curvature = Matrix6d::Zero();
};

RollingBearing::RollingBearing(std::string name, int F, int M, const RollingGeometry& given, double damping,
                               double tilt_damping)
    : ForceElement(std::move(name)),
      F_(F),
      M_(M),
      damping_(damping),
      tilt_damping_(tilt_damping),
      is_ball_(given.kind == RollingGeometry::Kind::ball) {
  RollingGeometry g = given;
  check(g);
  if (is_ball_) {
    A_ = (g.groove_inner + g.groove_outer - 1.0) * g.diameter;
    if (g.is_deep_groove) {
      if (!(g.clearance < 2.0 * A_))
        throw std::invalid_argument(
            "the clearance is larger than the distance of the groove's centres allows; it must be below "
            "twice "
            "(groove_inner + groove_outer - 1) times the ball's diameter");
      g.contact_angle = g.clearance > 0.0 ? std::acos(1.0 - g.clearance / (2.0 * A_)) : 0.0;
    }
    n_ = 1.5;
    c_ = ball_stiffness(g);
    rest_ = g.is_deep_groove
                ? Eigen::Vector2d(A_ - 0.5 * g.clearance, 0.0)
                : Eigen::Vector2d(A_ * std::cos(g.contact_angle), A_ * std::sin(g.contact_angle));
    slices_.push_back(
        {0.5 * g.pitch_diameter + (g.groove_inner - 0.5) * g.diameter * std::cos(g.contact_angle), 0.0});
  } else {
    n_ = 10.0 / 9.0;
    c_ = 3.5948e10 * std::pow(g.length, 8.0 / 9.0);  // 35948 N/mm^(10/9), lengths in mm
    gap_ = 0.5 * g.clearance * std::cos(g.contact_angle);
    for (int k = 0; k < slices_of_roller; ++k) {
      const double along = g.length * ((k + 0.5) / slices_of_roller - 0.5);
      slices_.push_back(
          {0.5 * g.pitch_diameter - along * std::sin(g.contact_angle), along * std::cos(g.contact_angle)});
    }
  }
  normal_ = {std::cos(g.contact_angle), std::sin(g.contact_angle)};
  for (int j = 0; j < g.count; ++j) {
    const double angle = 2.0 * std::numbers::pi * j / g.count;
    elements_.emplace_back(std::cos(angle), std::sin(angle));
  }
}

RollingBearing::State RollingBearing::state(const Pose& X, bool with_slopes) const {
  State s;
  s.a = X.R.col(2);
  const double c = c_ / static_cast<double>(slices_.size());
  for (const Eigen::Vector2d& e : elements_) {
    double load = 0.0;
    for (const Slice& at : slices_) {
      const double tilt = e.dot(s.a.head<2>());
      const Eigen::Vector2d moved(e.dot(X.p.head<2>()) + at.z * tilt,
                                  X.p.z() + at.z * (s.a.z() - 1.0) - at.R * tilt);
      Eigen::Vector2d normal = normal_;
      double delta = normal_.dot(moved) - gap_, length = 0.0;
      if (is_ball_) {
        const Eigen::Vector2d r = rest_ + moved;
        length = r.norm();
        delta = length - A_;
        normal = r / length;
      }
      if (!(delta > 0.0)) continue;
      const double Q = c * std::pow(delta, n_);
      load += Q;
      s.energy += Q * delta / (n_ + 1.0);
      Eigen::Matrix<double, 6, 2> G;    // of (u, w) by (p, a)
      G << e, Eigen::Vector2d::Zero(),  //
          0.0, 1.0,                     //
          at.z * e, -at.R * e,          //
          0.0, at.z;
      const Vector6d g = G * normal;
      s.gradient += Q * g;
      if (!with_slopes) continue;
      s.curvature += n_ * Q / delta * g * g.transpose();
      if (!is_ball_) continue;
      const Vector6d across = G * Eigen::Vector2d(-normal.y(), normal.x());
      s.curvature += Q / length * across * across.transpose();
    }
    s.largest = std::max(s.largest, load);
    if (load > 0.0) ++s.loaded;
  }
  return s;
}

Vector6d RollingBearing::on_M(const Relative& rel) const {
  const State s = state(rel.X_FM, false);
  Vector6d w;
  w << -s.a.cross(Vector3d(s.gradient.tail<3>())),
      -Vector3d(s.gradient.head<3>()) - damping_ * rel.V.tail<3>();
  w.head<2>() -= tilt_damping_ * rel.V.head<2>();
  return w;
}

void RollingBearing::differentiate(const Kinematics& kin, const double*, Derivatives& d) const {
  const Relative rel = kin.relative_motion(F_, M_);
  const State s = state(rel.X_FM, true);
  const Vector3d by_a = s.gradient.tail<3>();
  Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
  for (int j = 0; j < 6; ++j) {
    const Vector3d da = j < 3 ? Vector3d(Vector3d::Unit(j).cross(s.a)) : Vector3d(Vector3d::Zero());
    Vector6d change;
    change << (j < 3 ? Vector3d(Vector3d::Zero()) : Vector3d(Vector3d::Unit(j - 3))), da;
    change = s.curvature * change;
    W.col(j) << -(da.cross(by_a) + s.a.cross(Vector3d(change.tail<3>()))), -change.head<3>();
  }
  for (int i = 0; i < 2; ++i) W(i, 6 + i) = -tilt_damping_;
  for (int i = 0; i < 3; ++i) W(3 + i, 9 + i) = -damping_;
  d.between(F_, M_, on_M(rel));
  d.by_relative(F_, M_, W);
}

void RollingBearing::add_powers(const Kinematics& kin, const double*, Powers& powers) const {
  const Relative rel = kin.relative_motion(F_, M_);
  powers.potential += state(rel.X_FM, false).energy;
  powers.dissipated +=
      damping_ * rel.V.tail<3>().squaredNorm() + tilt_damping_ * rel.V.head<2>().squaredNorm();
}

std::vector<OutputInfo> RollingBearing::outputs() const {
  std::vector<OutputInfo> infos;
  for (const char* name : {"force_x", "force_y", "force_z"})
    infos.push_back({name, input::dim::force, "on the body of `to`, in the axes of `from`"});
  for (const char* name : {"torque_x", "torque_y"})
    infos.push_back({name, input::dim::torque, "on the body of `to`, in the axes of `from`"});
  infos.push_back({"largest_load", input::dim::force, "of one rolling element"});
  infos.push_back({"loaded", input::dim::none, "number of rolling elements that carry"});
  return infos;
}

void RollingBearing::evaluate_outputs(const Kinematics& kin, const double*, double* values) const {
  const Relative rel = kin.relative_motion(F_, M_);
  const State s = state(rel.X_FM, false);
  const Vector6d w = on_M(rel);
  for (int i = 0; i < 3; ++i) values[i] = w(3 + i);
  for (int i = 0; i < 2; ++i) values[3 + i] = w(i);
  values[5] = s.largest;
  values[6] = s.loaded;
}

}  // namespace flexura::mbs
