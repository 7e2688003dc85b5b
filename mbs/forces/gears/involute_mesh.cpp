// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/forces/gears/involute_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace flexura::mbs {
namespace {

Vector6d stacked(const Vector3d& by_turn, const Vector3d& by_move) {
  Vector6d x;
  x << by_turn, by_move;
  return x;
}

}  // namespace

/// The angle of r about z, and its derivatives.
struct InvoluteMesh::Direction {
  explicit Direction(const Vector3d& r)
      : square(r.head<2>().squaredNorm()),
        angle(std::atan2(r.y(), r.x())),
        gradient(-r.y() / square, r.x() / square, 0.0),
        r_(r) {}
  Vector3d change_of_gradient(const Vector3d& dr) const {
    const double mixed = 2.0 * r_.x() * r_.y(), plain = r_.y() * r_.y() - r_.x() * r_.x();
    return Vector3d(mixed * dr.x() + plain * dr.y(), plain * dr.x() - mixed * dr.y(), 0.0) /
           (square * square);
  }
  double square, angle;
  Vector3d gradient;

 private:
  Vector3d r_;
};

/// Where the wheels are; gradients by X_FM turned by (dtheta, dp), and how these change.
class InvoluteMesh::Wheels {
 public:
  Wheels(const Involute& gears, const Relative& rel)
      : gears_(gears),
        R_(rel.X_FM.R),
        p_(rel.X_FM.p),
        one_(p_),
        two_(-(R_.transpose() * p_)),
        weight_(gears.base_2 / (gears.base_1 + gears.base_2)),
        rates(rel.V) {
    const Vector3d e = Vector3d::UnitZ(), axis = R_.col(2), g = R_ * two_.gradient;
    distance = std::sqrt(one_.square);
    beta_1 = one_.angle;
    const double z = p_.dot((1.0 - weight_) * e + weight_ * axis);
    x = std::remainder(-(gears.base_1 * beta_1 + gears.base_2 * two_.angle) + gears.tan_base_helix * z,
                       gears.pitch);
    by_beta_1 = stacked(Vector3d::Zero(), one_.gradient);
    by_distance = stacked(Vector3d::Zero(), {p_.x() / distance, p_.y() / distance, 0.0});
    by_x = -gears.base_1 * by_beta_1 - gears.base_2 * stacked(p_.cross(g), -g) +
           gears.tan_base_helix * stacked(weight_ * axis.cross(p_), (1.0 - weight_) * e + weight_ * axis);
  }
  struct Change {
    Vector6d by_beta_1, by_distance, by_x;
  };
  Change change(const Vector3d& turn, const Vector3d& move) const {
    const Vector3d dq = R_.transpose() * (turn.cross(p_) - move), g = R_ * two_.gradient, axis = R_.col(2);
    const Vector3d dg = turn.cross(g) + R_ * two_.change_of_gradient(dq), daxis = turn.cross(axis);
    Change c;
    c.by_beta_1 = stacked(Vector3d::Zero(), one_.change_of_gradient(move));
    const Vector3d e = by_distance.tail<3>(), across(move.x(), move.y(), 0.0);
    c.by_distance = stacked(Vector3d::Zero(), (across - e * e.dot(across)) / distance);
    c.by_x = -gears_.base_1 * c.by_beta_1 - gears_.base_2 * stacked(move.cross(g) + p_.cross(dg), -dg) +
             gears_.tan_base_helix * weight_ * stacked(daxis.cross(p_) + axis.cross(move), daxis);
    return c;
  }

 private:
  const Involute& gears_;
  Matrix3d R_;
  Vector3d p_;
  Direction one_, two_;
  double weight_;

 public:
  Vector6d rates;
  double distance, beta_1, x;
  Vector6d by_beta_1, by_distance, by_x;
};

/// Side 0 is touched where wheel 1, turning positively, drives; side 1 the other.
struct InvoluteMesh::Flank {
  double sign, gap, gap_rate;
  Vector6d by_pose, y_by_pose;
  Involute::Play play;
  Involute::Ripple ripple;
  const int* root;
  const double* c;
};

InvoluteMesh::Flank InvoluteMesh::flank(int side, const Wheels& at, const Kinematics& kin) const {
  Flank f;
  f.sign = side == 0 ? 1.0 : -1.0;
  f.play = gears_.play(at.distance);
  f.gap = f.play.half - f.sign * at.x;
  f.by_pose = f.play.first * at.by_distance - f.sign * at.by_x;
  f.gap_rate = f.by_pose.dot(at.rates);
  f.ripple = gears_.ripple(gears_.base_1 * (gears_.half_thickness_1 - f.sign * at.beta_1));
  f.y_by_pose = -f.sign * gears_.base_1 * at.by_beta_1;
  f.root = kin.own.root + 2 * side;
  f.c = kin.own.c + side;
  return f;
}

std::string InvoluteMesh::switch_name(int i) const {
  static const char* names[] = {"front_gap", "front_push", "back_gap", "back_push"};
  return names[i];
}

void InvoluteMesh::start(double* c) const {
  std::fill_n(c, n_states(), 1.0);
}

void InvoluteMesh::rates(const Kinematics&, const double*, double* c_rate) const {
  std::fill_n(c_rate, n_states(), 0.0);
}

void InvoluteMesh::switching(const Kinematics& kin, const double*, double* values) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  for (int side = 0; side < 2; ++side) {
    const Flank f = flank(side, at, kin);
    law_.switching(f.gap, f.gap_rate, f.root, f.c, values + 2 * side);
  }
}

void InvoluteMesh::start_switches(const Kinematics& kin, const double*, int* root, double* c) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  for (int side = 0; side < 2; ++side) {
    const Flank f = flank(side, at, kin);
    law_.start(f.gap, f.gap_rate, root + 2 * side, c + side);
  }
}

void InvoluteMesh::change_switch(int which, const Kinematics& kin, const double*, int* root,
                                 double* c) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  const int side = which / 2;
  law_.change(which % 2, flank(side, at, kin).gap_rate, root + 2 * side, c + side);
}

void InvoluteMesh::apply(const Kinematics& kin, const double*, Loads& loads) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  Vector6d on_M = Vector6d::Zero();
  for (int side = 0; side < 2; ++side) {
    const Flank f = flank(side, at, kin);
    on_M += f.ripple.value * law_.force(f.gap, f.gap_rate, f.root, f.c) * f.by_pose -
            f.ripple.first * law_.energy(f.gap, f.root) * f.y_by_pose;
  }
  loads.apply_between(kin, F_, M_, on_M);
}

void InvoluteMesh::differentiate(const Kinematics& kin, const double*, Derivatives& d) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  Vector6d on_M = Vector6d::Zero(), by_state[2];
  Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
  for (int side = 0; side < 2; ++side) {
    const Flank f = flank(side, at, kin);
    const ContactLaw::Slopes slopes = law_.slopes(f.gap, f.gap_rate, f.root, f.c);
    const double N = law_.force(f.gap, f.gap_rate, f.root, f.c), E = law_.energy(f.gap, f.root);
    const double k = f.ripple.value;
    on_M += k * N * f.by_pose - f.ripple.first * E * f.y_by_pose;
    by_state[side] = k * slopes.by_state * f.by_pose;
    W.rightCols<6>() += k * slopes.by_rate * f.by_pose * f.by_pose.transpose();
    for (int j = 0; j < 6; ++j) {
      const Vector3d none = Vector3d::Zero(), unit = Vector3d::Unit(j % 3);
      const Wheels::Change c = at.change(j < 3 ? unit : none, j < 3 ? none : unit);
      const Vector6d turned =
          f.play.second * at.by_distance(j) * at.by_distance + f.play.first * c.by_distance - f.sign * c.by_x;
      const double dgap = f.by_pose(j), dy = f.y_by_pose(j);
      const double dN = slopes.by_gap * dgap + slopes.by_rate * turned.dot(at.rates);
      W.col(j) += (k * dN + f.ripple.first * dy * N) * f.by_pose + k * N * turned -
                  (f.ripple.second * dy * E - f.ripple.first * law_.elastic_force(f.gap, f.root) * dgap) *
                      f.y_by_pose +
                  f.ripple.first * E * f.sign * gears_.base_1 * c.by_beta_1;
    }
  }
  d.between(F_, M_, on_M);
  d.by_relative(F_, M_, W);
  if (law_.n_states() > 0)
    for (int side = 0; side < 2; ++side) d.by_state(side, by_state[side]);
}

void InvoluteMesh::add_powers(const Kinematics& kin, const double*, Powers& powers) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  for (int side = 0; side < 2; ++side) {
    const Flank f = flank(side, at, kin);
    powers.potential += f.ripple.value * law_.energy(f.gap, f.root);
    powers.dissipated += f.ripple.value * law_.lost_power(f.gap, f.gap_rate, f.root, f.c);
  }
}

std::vector<OutputInfo> InvoluteMesh::outputs() const {
  return {{"position", input::dim::length, "of the teeth between the flanks, along the line of action"},
          {"play", input::dim::length, "between the flanks, along the line of action"},
          {"force", input::dim::force,
           "along the line of action, positive where wheel 1 drives turning positively"},
          {"stiffness", input::dim::stiffness, "of the teeth in mesh on the flank that carries"}};
}

void InvoluteMesh::evaluate_outputs(const Kinematics& kin, const double*, double* values) const {
  const Wheels at(gears_, kin.relative_motion(F_, M_));
  values[0] = at.x;
  values[2] = 0.0;
  for (int side = 0; side < 2; ++side) {
    const Flank f = flank(side, at, kin);
    values[1] = 2.0 * f.play.half;
    values[2] += f.sign * f.ripple.value * law_.force(f.gap, f.gap_rate, f.root, f.c);
    if (side == 0 || ContactLaw::active(f.root)) values[3] = gears_.mean_stiffness * f.ripple.value;
  }
}

}  // namespace flexura::mbs
