// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <numbers>

#include "mbs/constraints/constraint.hpp"
#include "mbs/formulas/time_integral.hpp"

namespace flexura::mbs {

namespace {

// The formula of a drive by its acceleration, and what it has made of the speed.
struct Acceleration : Expression {
  explicit Acceleration(const Expression& formula)
      : Expression(formula),
        gained_speed(TimeFunction(formula.where(), true, formula.tree(), formula.tree().root,
                                  [](int) -> const FormulaTree* { return nullptr; })) {}
  TimeIntegral gained_speed;
};

}  // namespace

bool is_without_turns(const Kinematics& kin, CoordinateRef c) {
  const JointPlace& place = (*kin.joints)[static_cast<std::size_t>(c.joint)];
  return !place.in_tree() &&
         place.joint->coordinates()[static_cast<std::size_t>(c.index)].dimension == input::dim::angle;
}

DriveConstraint::DriveConstraint(std::string name, CoordinateRef speed, int coordinate,
                                 std::shared_ptr<const Expression> motion, DriveLevel level,
                                 double start_speed)
    : Constraint(std::move(name)),
      speed_(speed),
      coordinate_{speed.joint, coordinate},
      motion_(level == DriveLevel::acceleration ? std::make_shared<const Acceleration>(*motion)
                                                : std::move(motion)),
      level_(level),
      start_speed_(start_speed) {}

double DriveConstraint::wanted_speed(const Kinematics& kin) const {
  if (level_ == DriveLevel::position) return motion_.at(kin).first;
  if (level_ == DriveLevel::speed)
    return motion_.follows() ? motion_.at(kin).value : motion_.formula()->evaluate(&kin.t);
  return start_speed_ + static_cast<const Acceleration&>(*motion_.formula()).gained_speed(kin.t);
}

double DriveConstraint::wanted_acceleration(const Kinematics& kin) const {
  if (level_ == DriveLevel::acceleration) return motion_.formula()->evaluate(&kin.t);
  const Jet f = motion_.at(kin);
  return level_ == DriveLevel::position ? f.second : f.first;
}

void DriveConstraint::by_followed(const Kinematics&, int, double* g_y, double* h_y, double* h_y_dot) const {
  const bool of_position = level_ == DriveLevel::position;
  g_y[0] = h_y_dot[0] = of_position ? -1.0 : 0.0;
  h_y[0] = of_position ? 0.0 : -1.0;
}

void DriveConstraint::position(const Kinematics& kin, double* g) const {
  g[0] = 0.0;
  if (level_ != DriveLevel::position) return;
  g[0] = kin.coordinate(coordinate_) - motion_.at(kin).value;
  if (is_without_turns(kin, coordinate_)) g[0] = std::remainder(g[0], 2.0 * std::numbers::pi);
}

void DriveConstraint::velocity(const Kinematics& kin, double* g_dot) const {
  g_dot[0] = kin.speed(speed_) - wanted_speed(kin);
}

void DriveConstraint::acceleration(const Kinematics& kin, double* g_ddot) const {
  g_ddot[0] = kin.acceleration(speed_) - wanted_acceleration(kin);
}

void DriveConstraint::apply_GT(const Kinematics&, const double* x, Loads& loads) const {
  loads.apply(speed_, x[0]);
}

void DriveConstraint::differentiate(const Kinematics&, const double* x, Derivatives& d) const {
  d.force(speed_, x[0]);
  d.rows();
  d.by_speed(speed_, 1.0);
}

void DriveConstraint::rate(const Kinematics& kin, double* g_t) const {
  g_t[0] = -wanted_speed(kin);
}

}  // namespace flexura::mbs
