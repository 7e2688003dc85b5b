// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include "mbs/equations/equations.hpp"
#include "mbs/solver/accuracy/options.hpp"
#include "mbs/solver/algebra/history.hpp"

/// What an error in each state is allowed to be, the same for all integrators:
///
///     positions        tolerance * (min(|p|, L, 100 D) + absolute_factor D)
///     velocities       tolerance * (|v| + absolute_factor V)
///     dynamic states   tolerance * (|c| + absolute_factor)
///
/// All in displacements: what a unit of a state moves stands in SolverOptions::scales, so that lengths, angles
/// and modes are of the same worth.  L is the mechanism's length: a wheel's angle does not
/// loosen the tolerance with its revolutions, nor does the way that a vehicle has gone.  D is the largest
/// displacement since the run began, at most L, and V the largest speed, at most 1 rad/s and 1 m/s or L / 1 s: a micro
/// mechanism, or a stiff one that moves by nanometres, is held to its own motion.  What round-off
/// makes of L, or of a position itself, is not asked for.
///
/// Speeds of bodies that bend far (Scales::frequency) are held to what they displace before they turn: within 1 / frequency,
/// or within the step where that is shorter, since what vibrates faster decays in it.  Stretch and shear, whose frequencies are a
/// thousand times those of bending, would set the step else.
///
/// Forces that change by their own size within a narrow range of speeds about rest (a friction's transition speed) are
/// not resolved by errors of that range: Newton's method takes the stiffness it finds within for that beyond, and a
/// joint that should slip sticks, or creeps through.  They show where the mechanism at rest is disturbed: a force that
/// grows with the disturbance is a damper, one that does not has a range below.  All speeds are then held to a
/// thousandth of it.
namespace flexura::mbs {

class ErrorWeights {
 public:
  ErrorWeights(const Equations& eq, const SolverOptions& options);

  /// A (re)start at s with accelerations v_dot (n_v): at the first one D and V are what these accelerations
  /// make of the motion in a thousandth of the run, or in the shortest time in which they themselves change.
  void start(const State& s, const Eigen::VectorXd& v_dot);
  /// A step ended there.
  void take(ConstVectorRef p, ConstVectorRef v);

  /// w (n_p + n_v + n_dyn) = 1 / allowed error at these values, for a step of h (0: of any length).
  void evaluate(ConstVectorRef p, ConstVectorRef v, ConstVectorRef c, VectorRef w, double h = 0.0) const;

  double displacement() const { return displacement_; }  ///< D [m]
  double speed() const { return speed_; }                ///< V [m/s]
  /// Some force changes by its own size within a range of speeds finer than errors usually are: the stiffness that a
  /// matrix found within it says nothing of what is beyond.
  bool has_narrow_range() const;

  void remember(History& history);

 private:
  void guess(const State& s, const Eigen::VectorXd& v_dot);
  void look_for_narrow_ranges(const State& s);

  const Equations& eq_;
  double tolerance_, floor_, duration_, length_ = 1.0, place_ = 0.0;
  Eigen::VectorXd reach_p_, reach_v_;  // [m] for a unit
  Eigen::VectorXd usual_speed_;        // [m/s], of one unit of a velocity, or one length in a second
  bool has_start_ = false;
  Eigen::VectorXd p_start_;
  double displacement_ = 0.0, speed_ = 0.0;  // D, V without their upper bounds
  Eigen::VectorXd frequency_;                // [rad/s]
  double narrow_;                            // range of speeds [m/s], no bound where there is none
};

}  // namespace flexura::mbs
