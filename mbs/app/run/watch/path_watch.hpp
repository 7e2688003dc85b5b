// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/constraints/constraint.hpp"
#include "mbs/mechanism/mechanism.hpp"

namespace flexura::app {

/// A path that a marker travels along ends: beyond it nothing is known of the body.
class PathWatch {
 public:
  explicit PathWatch(const mbs::Mechanism& mechanism);
  void observe(const mbs::State& s, const Eigen::VectorXd& v_dot);
  /// One sentence once a marker has passed an end of its path, else empty.
  const std::string& reason() const { return reason_; }

 private:
  const mbs::Mechanism& mechanism_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<const mbs::Constraint*> watched_;
  std::vector<int> which_;  // the place and the speed of each, among quantities()
  Eigen::VectorXd now_;
  std::string reason_;
};

}  // namespace flexura::app
