// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>

#include "mbs/solver/algebra/kinematic_blocks.hpp"
#include "mbs/solver/run/energy.hpp"

namespace flexura::study {

/// The polynomial of degree five that has the positions, velocities and accelerations of two moments of a run.
class SpanPath {
 public:
  /// `eq` outlives it.
  SpanPath(const mbs::Equations& eq, const Eigen::VectorXd& p);

  void lay(const mbs::State& begin, const Eigen::VectorXd& v_dot_begin, const mbs::Instant& end);
  void clear() { h_ = 0.0; }
  double begin() const { return t_; }
  double length() const { return h_; }  ///< [s]; 0: there is none

  /// Fills p, v and v_dot at its share x.
  void at(double x, mbs::State& s, Eigen::VectorXd& v_dot);
  /// s minus the path at its time, of p (n_p) and v (n_v); nothing before its begin.
  void beside(const mbs::State& s, Eigen::VectorXd& dp, Eigen::VectorXd& dv);

  /// Some coordinates' rates are no velocities.
  bool has_turns() const { return has_turns_; }
  const mbs::KinematicBlocks& kinematics() const { return kinematics_; }

 private:
  void rates(const mbs::State& s, const Eigen::VectorXd& v_dot, Eigen::VectorXd* p);
  void to_velocities(const Eigen::VectorXd& p, Eigen::VectorXd& v) const;
  void follow_norms(const mbs::State& s, Eigen::VectorXd& v_dot);

  const mbs::Equations& eq_;
  mbs::Sizes n_;
  mbs::KinematicBlocks kinematics_;
  bool has_turns_ = false;
  double t_ = 0.0, h_ = 0.0;
  // p, h p' and h^2 p'' at its begin; how far its end is from p + h p', h p' less that of the begin, h^2 p''.
  std::array<Eigen::VectorXd, 6> p_;
  Eigen::VectorXd step_, up_, down_, rate_, rate2_, v_step_, v_dot_;
  mbs::State s_;
};

}  // namespace flexura::study
