// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stdexcept>

#include "mbs/kinematics/deformation_derivatives.hpp"
#include "mbs/kinematics/derivatives.hpp"
#include "mbs/mechanism/elements/constraint_rows.hpp"

namespace flexura::mbs {

/// Takes up only what controls and measures say.
class OfSignals : public Derivatives {
 public:
  using Derivatives::by_coordinate;
  using Derivatives::by_formula;
  using Derivatives::by_speed;
  using Derivatives::by_state;
  void between(int, int, const Vector6d&) override { refuse(); }
  void wrench(int, int, int, const Vector6d&) override { refuse(); }
  void force(CoordinateRef, double) override { refuse(); }
  void modal(int, const Eigen::VectorXd&) override { refuse(); }
  void rate(int) override {}
  void rows() override {}
  void by_relative(int, int, const Matrix&) override {}
  void by_coordinate(CoordinateRef, const Matrix&) override { refuse(); }
  void by_speed(CoordinateRef, const Matrix&) override { refuse(); }
  void by_signal(int, const Matrix&) override {}
  void by_deformation(int, int, const Vector6d&) override { refuse(); }
  void by_state(int, const Matrix&) override {}
  void by_algebraic(double) override {}
  DeformationDerivatives& deformations() override { refuse(); }

 protected:
  [[noreturn]] static void refuse() { throw std::logic_error("no derivative of a control or a measure"); }
};

/// How outputs change along the motion, given how signals and states do.
class AlongMotion final : public OfSignals {
 public:
  AlongMotion(const Motion& motion, const FollowedValues& values) : motion_(motion), values_(values) {}
  void set_states(const double* c_rate) { c_rate_ = c_rate; }
  /// Where changes of rates go, one for each state; without it all goes into change().
  void set_rates(double* of_rates) { of_rates_ = of_rates; }
  double change() const { return change_; }

  using OfSignals::by_formula;
  void rate(int i) override { target_ = of_rates_ ? of_rates_ + i : &change_; }
  void rows() override { target_ = &change_; }
  void by_relative(int F, int M, const Matrix& d) override {
    *target_ += d.row(0).leftCols<6>().dot(motion_.kin.relative_motion(F, M).V);
  }
  void by_signal(int signal, const Matrix& d) override {
    *target_ += d(0, 0) * values_.signals[static_cast<std::size_t>(signal)].first;
  }
  void by_state(int i, const Matrix& d) override { *target_ += d(0, 0) * c_rate_[i]; }
  /// Explicit functions of time included.
  void by_formula(const Expression& f, const double* signals, const Matrix& d) override {
    *target_ += d(0, 0) * f.along(signals, values_.signals.data()).first;
  }

 private:
  const Motion& motion_;
  const FollowedValues& values_;
  const double* c_rate_ = nullptr;
  double* of_rates_ = nullptr;
  double change_ = 0.0;
  double* target_ = &change_;
};

/// The derivatives of an output by the control's own states.
class StateWeights final : public OfSignals {
 public:
  explicit StateWeights(Eigen::VectorXd& weights) : weights_(weights) {}
  void by_state(int i, const Matrix& d) override { weights_(i) += d(0, 0); }

 private:
  Eigen::VectorXd& weights_;
};

}  // namespace flexura::mbs
