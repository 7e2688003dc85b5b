// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "mbs/study/estimate/full_model.hpp"

/// What a linear correction of left-out deformations cannot see: a dead band, a square or a table's flat part answers them to
/// the second order alone, and a switch that they would throw stays as it is.  Of all that the first order says "no change".
///
/// At the moved state the equations of motion hold to first order.  What is left of them is of higher order, and drives the
/// correction in its turn (shadows.cpp).  Where it is no smaller, on the coordinates of joints and the rates of controls'
/// states, than what the first order brings there and than what the run has there, neither says anything about it.
namespace flexura::study {

class BeyondFirstOrder {
 public:
  BeyondFirstOrder(const FullModel& full, std::size_t sources);

  /// A row of the run, in the full model, and its derivatives (or those of one shortly before).
  void begin(const mbs::State& s, const Eigen::VectorXd& v_dot, const LinearisedRow& row);
  /// The same as a source's correction moves it; `load` is what drives that.  Returns what is left of the momentum balance
  /// (n_v): the load of the next order is minus that.
  const Eigen::VectorXd& take(std::size_t source, const FullModel::Correction& by,
                              const Eigen::VectorXd& acceleration, const mbs::State& moved,
                              const Eigen::VectorXd& load);

  /// Why the correction of this source says too little; empty where it says enough.
  std::string why(std::size_t source) const;
  /// What is left of the equations on each velocity coordinate (n_v; rms, of all sources together; 0 on deformations): a
  /// joint's force along a direction that it leaves free is told no better.
  Eigen::VectorXd rests() const;

 private:
  struct Sums {
    Eigen::VectorXd rest, first;  // squares: on the coordinates of joints, then the rates of states
    std::set<int> thrown;         // switches
    int taken = 0;
  };
  const mbs::Mechanism& mechanism_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<int> rigid_;  // velocity coordinates that are no deformations
  const LinearisedRow* row_ = nullptr;
  std::vector<Sums> sources_;
  Eigen::VectorXd own_;  // squares: what the run has there
  Eigen::VectorXd a_, r_, c_rate_, r_moved_, left_, c_moved_, b_, roots_, roots_moved_;
  std::vector<int> first_positions_;
  std::vector<bool> has_changed_;
};

}  // namespace flexura::study
