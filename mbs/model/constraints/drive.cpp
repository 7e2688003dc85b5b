// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/constraint.hpp"

namespace flexura::mbs {

DriveConstraint::DriveConstraint(std::string name, CoordinateRef coordinate,
                                 std::shared_ptr<const Expression> motion)
    : Constraint(std::move(name)), coordinate_(coordinate), motion_(std::move(motion)) {}

void DriveConstraint::position(const Kinematics& kin, double* g) const {
  g[0] = kin.coordinate(coordinate_) - motion_->time_derivatives(kin.t).value;
}

void DriveConstraint::velocity(const Kinematics& kin, double* g_dot) const {
  g_dot[0] = kin.speed(coordinate_) - motion_->time_derivatives(kin.t).first;
}

void DriveConstraint::acceleration(const Kinematics& kin, double* g_ddot) const {
  g_ddot[0] = kin.acceleration(coordinate_) - motion_->time_derivatives(kin.t).second;
}

void DriveConstraint::apply_GT(const Kinematics&, const double* x, Loads& loads) const {
  loads.apply(coordinate_, x[0]);
}

void DriveConstraint::rate(const Kinematics& kin, double* g_t) const {
  g_t[0] = -motion_->time_derivatives(kin.t).first;
}

}  // namespace flexura::mbs
