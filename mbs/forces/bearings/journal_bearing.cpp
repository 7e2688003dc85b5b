// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/bearings/journal_bearing.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace flexura::mbs {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// J and its derivatives by a and b, where the half is that of cos phi > 0.
struct FilmIntegral {
  FilmIntegral(double a, double b, bool is_half) {
    const double W = 1.0 / (1.0 - a * a - b * b), w = std::sqrt(W);
    // What the ends of the half add: J_a = W (ends + a J), J_b = b W (ends a q + J).
    const double ends = is_half ? 2.0 : 0.0, q = 1.0 / (1.0 - b * b);
    const double J =
        is_half ? 2.0 * w * (0.5 * std::numbers::pi + std::atan(a * w)) : 2.0 * std::numbers::pi * w;
    const double J_a = W * (ends + a * J), J_b = b * W * (ends * a * q + J);
    aa = W * (3.0 * a * J_a + J);
    ab = W * (2.0 * b * J_a + a * J_b);
    bb = W * (ends * a * q + J) + 3.0 * b * W * J_b + 2.0 * ends * a * b * b * q * q * W;
    aaa = W * (5.0 * a * aa + 4.0 * J_a);
    aab = 2.0 * b * W * aa + W * (3.0 * a * ab + J_b);
    abb = W * (4.0 * b * ab + 2.0 * J_a + a * bb);
  }
  double aa, ab, bb, aaa, aab, abb;
};

}  // namespace

/// Force and its derivatives, components along x and y of F.
struct JournalBearing::FilmState {
  Vector2d d, velocity, u, force;
  double omega, eccentricity, shear;  ///< shear: torque per omega
  Matrix2d by_d, by_u;
  double lost;
};

JournalBearing::FilmState JournalBearing::film(const Relative& rel) const {
  FilmState s;
  s.d = rel.X_FM.p.head<2>();
  s.velocity = rel.V.segment<2>(3);
  s.omega = rel.V(2);
  s.u = s.velocity + 0.5 * s.omega * Vector2d(s.d.y(), -s.d.x());
  s.eccentricity = s.d.norm() / g_.clearance;
  if (!(s.eccentricity < 1.0))
    throw std::runtime_error(
        fmt::format("force \"{}\": the journal stands {:.4g} of the clearance out of its sleeve's centre, "
                    "where no film is "
                    "left; give it a start within, more oil or less load",
                    name(), s.eccentricity));
  const double speed = s.u.norm(), c = g_.clearance, R = g_.radius, L = g_.length;
  const double k = 0.5 * g_.viscosity * R * L * L * L / (c * c * c);
  // Axes along u and across; without u any will do, there is no force.
  Matrix2d axes = Matrix2d::Identity();
  if (speed > 0.0) axes << s.u.x() / speed, -s.u.y() / speed, s.u.y() / speed, s.u.x() / speed;
  const Vector2d at = axes.transpose() * s.d / c;
  const FilmIntegral J(at.x(), at.y(), g_.film == Film::half);
  Matrix2d by_u, by_d;
  by_u << J.aa, J.ab, J.ab, J.bb;
  by_d << J.aaa, J.aab, J.aab, J.abb;
  s.by_u = -k * axes * by_u * axes.transpose();
  s.by_d = -k * speed / c * axes * by_d * axes.transpose();
  s.force = s.by_u * s.u;
  s.shear = g_.viscosity * R * R * R * L * 2.0 * std::numbers::pi /
            (c * std::sqrt(1.0 - s.eccentricity * s.eccentricity));
  s.lost = -s.force.dot(s.u) + s.shear * s.omega * s.omega;
  return s;
}

Vector6d JournalBearing::on_M(const Relative& rel) const {
  const FilmState s = film(rel);
  Vector6d w = Vector6d::Zero();
  w(2) = -0.5 * (s.d.x() * s.force.y() - s.d.y() * s.force.x()) - s.shear * s.omega;
  w.segment<2>(3) = s.force;
  return w;
}

void JournalBearing::differentiate(const Kinematics& kin, const double*, Derivatives& d) const {
  const Relative rel = kin.relative_motion(F_, M_);
  const FilmState s = film(rel);
  Matrix2d u_by_d;
  u_by_d << 0.0, 0.5 * s.omega, -0.5 * s.omega, 0.0;
  const Matrix2d f_by_d = s.by_d + s.by_u * u_by_d;
  const Vector2d f_by_omega = s.by_u * (0.5 * Vector2d(s.d.y(), -s.d.x()));
  const Vector2d across(-s.d.y(), s.d.x());  // (x f_y - y f_x) = across . f
  Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
  const double slope = s.shear / ((1.0 - s.eccentricity * s.eccentricity) * g_.clearance * g_.clearance);
  W.block<2, 2>(3, 3) = f_by_d;
  W.block<1, 2>(2, 3) =
      -0.5 * (across.transpose() * f_by_d + Vector2d(s.force.y(), -s.force.x()).transpose()) -
      slope * s.omega * s.d.transpose();
  W.block<2, 1>(3, 8) = f_by_omega;
  W(2, 8) = -0.5 * across.dot(f_by_omega) - s.shear;
  W.block<2, 2>(3, 9) = s.by_u;
  W.block<1, 2>(2, 9) = -0.5 * across.transpose() * s.by_u;
  d.between(F_, M_, on_M(rel));
  d.by_relative(F_, M_, W);
}

void JournalBearing::add_powers(const Kinematics& kin, const double*, Powers& powers) const {
  powers.dissipated += film(kin.relative_motion(F_, M_)).lost;
}

std::vector<OutputInfo> JournalBearing::outputs() const {
  return {{"force_x", input::dim::force, "on the body of `to`, in the axes of `from`"},
          {"force_y", input::dim::force, "on the body of `to`, in the axes of `from`"},
          {"torque_z", input::dim::torque, "on the body of `to` about its marker"},
          {"eccentricity", input::dim::none, "of the journal, over the clearance"},
          {"thinnest_film", input::dim::length, "between journal and sleeve"},
          {"power_lost", input::dim::power, "in the film"}};
}

void JournalBearing::evaluate_outputs(const Kinematics& kin, const double*, double* values) const {
  const Relative rel = kin.relative_motion(F_, M_);
  const FilmState s = film(rel);
  values[0] = s.force.x();
  values[1] = s.force.y();
  values[2] = on_M(rel)(2);
  values[3] = s.eccentricity;
  values[4] = g_.clearance * (1.0 - s.eccentricity);
  values[5] = s.lost;
}

}  // namespace flexura::mbs
