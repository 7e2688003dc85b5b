// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "mbs/base/documents/units.hpp"
#include "mbs/kinematics/derivatives.hpp"
#include "mbs/kinematics/kinematics.hpp"

/// Measures.  Adding one: a function of the relative motion in relative_measure.cpp or a class of its own in
/// mbs/measures, and an entry in mbs/file/elements/measures.cpp.
namespace flexura::mbs {

/// A scalar of positions and velocities that formulas can read by its name.
class Measure {
 public:
  explicit Measure(std::string name) : name_(std::move(name)) {}
  virtual ~Measure() = default;
  const std::string& name() const { return name_; }
  virtual input::Dimension dimension() const = 0;
  /// `signals` holds the measures that stand before this one in the file.
  virtual double value(const Kinematics& kin, const double* signals) const = 0;
  /// Of value(), as rows().
  virtual void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const = 0;
  /// Signals read by it.
  virtual std::vector<int> reads() const { return {}; }
  /// True for one of positions alone, whose rate is then known from speeds.
  virtual bool is_of_positions() const { return false; }
  /// Where it is a formula and nothing else.
  virtual const Expression* formula() const { return nullptr; }
  /// True for what is known only after the equations of motion are solved: see ShownMeasure.
  virtual bool is_only_shown() const { return false; }
  /// The joint whose reaction it takes; -1: none, it is value().
  virtual int joint() const { return -1; }
  /// Its value where this wrench (torque about Mo, force, in F) goes through that joint, on the body of M.
  virtual double value_of_load(const Kinematics& /*kin*/, const Vector6d& /*on_M_F*/) const { return 0.0; }

 private:
  std::string name_;
};

}  // namespace flexura::mbs
