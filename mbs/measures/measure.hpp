// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "mbs/base/documents/units.hpp"
#include "mbs/kinematics/derivatives.hpp"
#include "mbs/kinematics/kinematics.hpp"

/// Measures.  Adding one: a function of the relative motion in relative_measure.cpp or a class of its own in
/// mbs/measures, and an entry in mbs/file/elements/measures.cpp.
namespace flexura::mbs {

/// What exerts the force or torque that a measure takes, by its place in the description.
struct Exerted {
  enum class By { none, joint, drive, constraint, force } by = By::none;
  int element = -1;    ///< joint, constraint or force
  int coordinate = 0;  ///< of a drive
};

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
  /// Whose load it takes; by none: it is value().
  virtual Exerted exerted() const { return {}; }
  /// Its value where this is exerted: the wrench (torque about Mo, force, in F) through a joint, on the body of M; the force
  /// or torque of a drive; the outputs of a constraint or a force element.
  virtual double value_of_load(const Kinematics& /*kin*/, const double* /*load*/) const { return 0.0; }
  /// Of what is exerted: near which it is sought at the start.
  virtual double guess() const { return 0.0; }
  /// The markers F and M where it is a function of the pose of M in F with known derivatives; -1, -1 of another.
  virtual std::pair<int, int> markers_of_pose() const { return {-1, -1}; }
  virtual PoseFunction of_pose(const Relative& /*rel*/) const { return {}; }

 private:
  std::string name_;
};

}  // namespace flexura::mbs
