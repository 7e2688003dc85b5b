// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/position/projection.hpp"
#include "mbs/solver/run/run.hpp"
#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/error_equation.hpp"
#include "mbs/study/estimate/integrator_check.hpp"
#include "mbs/study/estimate/judged_outputs.hpp"
#include "mbs/study/estimate/own_rows.hpp"

/// What the integrator costs the outputs of a run, from the run itself: the error of its states
/// (error_equation.hpp) is taken off those of a row, whose accelerations and multipliers are then solved for, and the
/// outputs of both are compared.  To first order: an error above a twentieth of the output is called unknown, since a
/// figure of a tenth was seen where the truth was the whole.  So it is where velocities or states of controls jump at a
/// switch of the motion, since how the jump itself changes with the error is not followed, and where a row could not be
/// judged.
namespace flexura::study {

class GlobalError {
 public:
  /// Null where nothing is integrated, or nothing is judged.  `run` outlives it.
  static std::unique_ptr<GlobalError> make(const mbs::PreparedMechanism& run);

  /// What RunCallbacks of these names give.
  void restart(const mbs::State& s, const Eigen::VectorXd& v_dot, const mbs::IntegratorKind& kind);
  void step(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes);
  /// Of the rows some 200 are looked at.
  void row(const mbs::State& s, const Eigen::VectorXd& v_dot);
  /// Adds itself to the callbacks, which call it before whatever they call already.
  void watch(mbs::RunCallbacks& callbacks);

  IntegratorEstimate estimate();
  /// Of a run under way: what its error has come to, relative to the whole run's rms of the worst of `outputs` (found by their
  /// names) or to its own so far, if no more came to it.
  double spent(const std::vector<OutputEstimate>& outputs);
  double wall() const { return wall_; }  ///< [s] that all this took

 private:
  explicit GlobalError(const mbs::PreparedMechanism& run);
  void advance(bool end);
  void choose_rows(const mbs::Instant& begin, const std::array<mbs::Instant, 3>& nodes);
  void close(mbs::Instant& at);
  void close_step();
  void compare(const mbs::State& s, const Eigen::VectorXd& v_dot);
  void compare_waiting();
  /// Why an error of this size is not told; empty where it is.
  std::string why_unknown(double error) const;

  const mbs::PreparedMechanism& run_;
  OwnRows rows_;
  ErrorEquation equation_;
  mbs::LoopCloser closer_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<OutputEstimate> outputs_;  // before which_, which fills it
  std::vector<double> scales_;           // of spent(): what an error is relative to; 0: it does not count
  std::vector<int> which_;
  Families families_;
  long every_ = 1, shown_ = 0, compared_ = 0;
  bool has_stepped_ = false, has_jumped_ = false, misses_part_ = false, misses_rows_ = false;
  int longest_span_ = 1;
  double wall_ = 0.0;
  std::vector<mbs::Instant> waiting_;  // rows whose error is not known yet
  mbs::State moved_;
  Eigen::VectorXd e_, y_, y_moved_, v_dot_moved_, squares_, sizes_;
  mbs::State last_;                           // where the last step ended
  double largest_v_ = 0.0, largest_c_ = 0.0;  // entries of velocities and states so far
  // Steps that leave the constraints are moved onto them.
  bool closes_steps_ = false, is_new_ = true;
  mbs::Instant begin_, end_;  // begin_ and nodes_: what the equation is given of the step
  std::array<mbs::Instant, 3> nodes_;
};

}  // namespace flexura::study
