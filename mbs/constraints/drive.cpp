// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <numbers>

#include "mbs/constraints/constraint.hpp"

namespace flexura::mbs {
namespace {

/// Integral of f over [a, b] by Gauss and Kronrod's rule of 7 and 15 points, halved until the two agree.
double integrate(const Expression& f, double a, double b, int depth = 0) {
  constexpr std::array<double, 8> x = {0.991455371120812639206854697526, 0.949107912342758524526189684048,
                                       0.864864423359769072789712788641, 0.741531185599394439863864773281,
                                       0.586087235467691130294144691694, 0.405845151377397166906606412077,
                                       0.207784955007898467600689403773, 0.0};
  constexpr std::array<double, 8> w_k = {0.022935322010529224963732008059, 0.063092092629978553290700663189,
                                         0.104790010322250183839876322542, 0.140653259715525918745189590510,
                                         0.169004726639267902826583426599, 0.190350578064785409913256402421,
                                         0.204432940075298892414161999235, 0.209482141084727828012999174892};
  constexpr std::array<double, 4> w_g = {0.129484966168869693270611432679, 0.279705391489276667901467771424,
                                         0.381830050505118944950369775489, 0.417959183673469387755102040816};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  double kronrod = 0.0, gauss = 0.0, size = 0.0;
  for (int i = 0; i < 8; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      if (i == 7 && sign > 0.0) continue;
      const double at = middle + sign * half * x[i], y = f.evaluate(&at);
      kronrod += w_k[i] * y;
      size += w_k[i] * std::abs(y);
      if (i % 2 == 1) gauss += w_g[i / 2] * y;
    }
  }
  if (depth >= 40 || std::abs(kronrod - gauss) <= 1e-12 * size) return half * kronrod;
  return integrate(f, a, middle, depth + 1) + integrate(f, middle, b, depth + 1);
}

}  // namespace

DriveConstraint::DriveConstraint(std::string name, CoordinateRef coordinate,
                                 std::shared_ptr<const Expression> motion, DriveLevel level,
                                 double start_speed)
    : Constraint(std::move(name)),
      coordinate_(coordinate),
      motion_(std::move(motion)),
      level_(level),
      start_speed_(start_speed) {}

double DriveConstraint::wanted_speed(double t) const {
  if (level_ == DriveLevel::position) return motion_->time_derivatives(t).first;
  if (level_ == DriveLevel::speed) return motion_->evaluate(&t);
  return start_speed_ + (t == 0.0 ? 0.0 : integrate(*motion_, 0.0, t));
}

double DriveConstraint::wanted_acceleration(double t) const {
  if (level_ == DriveLevel::acceleration) return motion_->evaluate(&t);
  const Jet f = motion_->time_derivatives(t);
  return level_ == DriveLevel::position ? f.second : f.first;
}

void DriveConstraint::position(const Kinematics& kin, double* g) const {
  g[0] = 0.0;
  if (level_ != DriveLevel::position) return;
  g[0] = kin.coordinate(coordinate_) - motion_->time_derivatives(kin.t).value;
  const JointPlace& place = (*kin.joints)[static_cast<std::size_t>(coordinate_.joint)];
  // Of a joint that closes a loop the frames tell the angle but for whole turns.
  if (!place.in_tree() && place.joint->coordinates()[coordinate_.index].dimension == input::dim::angle)
    g[0] = std::remainder(g[0], 2.0 * std::numbers::pi);
}

void DriveConstraint::velocity(const Kinematics& kin, double* g_dot) const {
  g_dot[0] = kin.speed(coordinate_) - wanted_speed(kin.t);
}

void DriveConstraint::acceleration(const Kinematics& kin, double* g_ddot) const {
  g_ddot[0] = kin.acceleration(coordinate_) - wanted_acceleration(kin.t);
}

void DriveConstraint::apply_GT(const Kinematics&, const double* x, Loads& loads) const {
  loads.apply(coordinate_, x[0]);
}

void DriveConstraint::differentiate(const Kinematics&, const double* x, Derivatives& d) const {
  d.force(coordinate_, x[0]);
  d.rows();
  d.by_speed(coordinate_, 1.0);
}

void DriveConstraint::rate(const Kinematics& kin, double* g_t) const {
  g_t[0] = -wanted_speed(kin.t);
}

}  // namespace flexura::mbs
