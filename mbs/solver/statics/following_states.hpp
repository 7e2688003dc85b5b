// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "mbs/solver/algebra/tangents.hpp"

/// Dynamic states that only motion changes, whatever its speed: of a friction that sticks, of bristles,
///
///     c' = B(p, c) v,     B of either sense of v where friction yields as it is loaded: c' = v - |v| sigma c / F.
///
/// At rest any value would do.  They hold what they held where the search for an equilibrium began and follow its steps d as they
/// would slow motion: dc = B d, and z_c B is a part of the stiffness.
namespace flexura::mbs {

class FollowingStates {
 public:
  explicit FollowingStates(const Equations& eq);

  /// Finds them where `t` was evaluated, at rest; K (n_z x n_v) is z_p by tangent coordinates, c_rate (n_dyn) the rates. B is
  /// that of the sense of `d_before`, the last step (n_v; 0: of neither).
  void find(const State& s, const Tangents& t, const Eigen::MatrixXd& K, const Eigen::VectorXd& c_rate,
            const Eigen::VectorXd& d_before);
  const std::vector<int>& which() const { return which_; }  ///< of c
  const Eigen::MatrixXd& B() const { return B_; }           ///< which().size() x n_v

  /// What a step d (n_v) from s makes of them, by c' = a - b c along it, so that they end where the friction yields and not beyond.
  void begin_step(const State& s, const Eigen::VectorXd& d);
  /// c (n_dyn) after this part of the step.
  void move(double part, Eigen::VectorXd& c) const;

 private:
  Eigen::VectorXd rate_along(State s, const Eigen::VectorXd& d);

  const Equations& eq_;
  Sizes n_;
  std::unique_ptr<Equations::Scratch> scratch_;
  std::vector<int> which_;
  Eigen::MatrixXd B_;
  Eigen::VectorXd size_v_, slope_, decay_, r_, c_rate_, b_;
};

}  // namespace flexura::mbs
