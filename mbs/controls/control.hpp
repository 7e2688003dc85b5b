// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "mbs/kinematics/derivatives.hpp"

/// Control elements: they read signals (SignalNames), hold dynamic states c and give one output, a signal of
/// their own name, for the formulas of forces and measures.
///
///     c' = f(signals, c),     output = h(c) or, where the element feeds through, h(signals, c)
///
/// A control may switch: the integrator then stops where a switching function falls below 0 and lets it change
/// its states.  One that solves an algebraic equation has a = output for its state:
///
///     0 = residual(signals)
///
/// Adding one: one file in controls/ and one line in control_types().
namespace flexura::mbs {

class Control {
 public:
  explicit Control(std::string name) : name_(std::move(name)) {}
  virtual ~Control() = default;
  const std::string& name() const { return name_; }
  virtual std::string_view type() const = 0;

  virtual int n_states() const = 0;
  /// True of a state that is no dynamic one but a held value: it changes where the control switches and nowhere else.
  virtual bool is_held(int /*state*/) const { return false; }
  virtual void start(double* c) const = 0;  ///< initial values of the states
  virtual void rates(const double* signals, const double* c, double* c_rate) const = 0;
  /// `signals` is for those that feed through; the others must not read it.
  virtual double output(const double* signals, const double* c) const = 0;
  virtual bool feeds_through() const { return false; }
  virtual std::vector<int> reads() const = 0;  ///< signals
  /// How many times the output must be differentiated for what the control reads to appear: the poles that its transfer
  /// has more than zeros.
  virtual int relative_degree() const { return feeds_through() ? 0 : 1; }
  /// Of rates().
  virtual void differentiate_rates(const double* /*signals*/, const double* /*c*/, Derivatives& /*d*/) const {
  }
  /// Of output() or, where it is algebraic, of residual(): as rows().
  virtual void differentiate(const double* signals, const double* c, Derivatives& d) const = 0;

  virtual int n_switches() const { return 0; }
  virtual std::string switch_name(int i) const { return "switch_" + std::to_string(i + 1); }
  virtual void switching(const double* /*signals*/, const double* /*c*/, double* /*values*/) const {}
  virtual void start_switches(const double* /*signals*/, double* /*c*/) const {}
  virtual void change_switch(int /*which*/, const double* /*signals*/, double* /*c*/) const {}

  /// Of a control that changes at its own events alone: what a small change of the motion sees of it between them, on the
  /// average, with the same states and switches.  Null for others.
  virtual std::shared_ptr<const Control> on_the_average() const { return nullptr; }

  /// True for one whose output is an algebraic state, which starts at start_algebraic().
  virtual bool is_algebraic() const { return false; }
  virtual double start_algebraic() const { return 0.0; }
  virtual double residual(const double* /*signals*/) const { return 0.0; }
  /// The formula of residual().
  virtual const Expression* equation() const { return nullptr; }

 private:
  std::string name_;
};

}  // namespace flexura::mbs
