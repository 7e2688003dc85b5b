// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/mechanism/mechanism.hpp"

namespace flexura::app {

/// Friction that is smooth about rest lets a joint, or what touches, creep where it would stick: under a load T of less than
/// the greatest force F_c at v_t artanh(T / F_c). What that came to in the rows is told where it is a part of the way made.
class CreepWatch {
 public:
  explicit CreepWatch(const mbs::Mechanism& mechanism);
  void observe(const mbs::State& s, const Eigen::VectorXd& v_dot);
  /// One sentence for each friction that crept.
  std::vector<std::string> sentences() const;

 private:
  struct Friction {
    std::string name, unit, remedy;
    double transition_speed;
    bool is_contact;
    double way = 0.0, crept = 0.0, time = 0.0, fastest = 0.0;  // crept within `time`
  };
  const mbs::Mechanism& mechanism_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<Friction> frictions_;
  std::vector<int> which_;  // of each its speed and, of a contact, its normal force, among quantities()
  double t_before_ = 0.0;
  Eigen::VectorXd before_, now_;
};

}  // namespace flexura::app
