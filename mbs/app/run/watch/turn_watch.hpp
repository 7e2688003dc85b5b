// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::app {

/// Angles of joints that close loops are taken from the pose and known within +-pi: a force that acts along one, or a
/// formula that reads it, sees it jump by a whole turn there. Joints of the tree count their turns.
class TurnWatch {
 public:
  explicit TurnWatch(const mbs::Mechanism& mechanism);
  void observe(const mbs::State& s, const Eigen::VectorXd& v_dot);
  /// One sentence once such an angle has jumped between two rows, else empty.
  const std::string& reason() const { return reason_; }

 private:
  const mbs::Mechanism& mechanism_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<int> which_;  // among quantities()
  std::vector<std::string> names_, readers_;
  Eigen::VectorXd before_, now_;
  std::string reason_;
};

}  // namespace flexura::app
