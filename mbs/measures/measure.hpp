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
  /// Where it is a formula and nothing else.
  virtual const Expression* formula() const { return nullptr; }

 private:
  std::string name_;
};

}  // namespace flexura::mbs
