// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "mbs/formulas/curve.hpp"
#include "mbs/kinematics/derivatives.hpp"
#include "mbs/kinematics/kinematics.hpp"
#include "mbs/kinematics/output_info.hpp"

/// Force elements.  Adding one: one file in mbs/forces, and an entry in mbs/file/elements/forces.cpp that says what it is called
/// there and what its keys are.
namespace flexura::mbs {

struct Powers {
  double potential = 0.0;   ///< energy stored [J]
  double input = 0.0;       ///< power put into the mechanism [W]
  double dissipated = 0.0;  ///< power taken out for good [W], >= 0
};

/// States of an element's own, found in Kinematics::own wherever the element is evaluated on velocity level.
class HasStates {
 public:
  virtual int n_states() const { return 0; }  ///< dynamic states and held values
  /// True of a state that is no dynamic one but a held value: it changes where the element switches and nowhere else.
  virtual bool is_held(int /*state*/) const { return false; }
  virtual int n_switches() const { return 0; }
  virtual std::string switch_name(int i) const { return "switch_" + std::to_string(i + 1); }
  /// False where what the element exerts is the same on both sides of the switch.
  virtual bool jumps_at(int /*which*/) const { return true; }
  /// Values of dynamic states before anything is known of the motion.
  virtual void start(double* /*c*/) const {}
  virtual void rates(const Kinematics& /*kin*/, const double* /*signals*/, double* /*c_rate*/) const {}
  /// Functions that are positive while their switches are in the right position: the integrator stops where
  /// one falls below 0.  Positions of switches and what hangs on them stay in between.
  virtual void switching(const Kinematics& /*kin*/, const double* /*signals*/, double* /*values*/) const {}
  /// Positions that an assembled state wants, and dynamic states that go with them.
  virtual void start_switches(const Kinematics& /*kin*/, const double* /*signals*/, int* /*root*/,
                              double* /*c*/) const {}
  /// Takes the switch `which`, whose function fell below 0, into its other position.
  virtual void change_switch(int /*which*/, const Kinematics& /*kin*/, const double* /*signals*/,
                             int* /*root*/, double* /*c*/) const {}

 protected:
  ~HasStates() = default;
};

/// What a force element is where a mechanism's loads are taken away or scaled.
enum class ForceNature {
  unknown,   ///< it does not say: judged by what it does (Mechanism::without_loads)
  response,  ///< follows from the state alone, as springs, dampers and contacts do: stays
  load       ///< holds a given load (dead, following, a preload): ForceElement::without_load() is what stays
};

/// A curve that a force follows: over what it takes it.
struct CurveLaw {
  std::shared_ptr<const Curve> curve;
  std::function<double(const Kinematics&)> argument;
};

class ForceElement : public HasStates {
 public:
  explicit ForceElement(std::string name) : name_(std::move(name)) {}
  virtual ~ForceElement() = default;
  const std::string& name() const { return name_; }

  /// Adds the applied forces; `signals` are the values of formulas' names (SignalNames).
  virtual void apply(const Kinematics& kin, const double* signals, Loads& loads) const = 0;
  /// True where differentiate() is there; what an element does without is differenced.
  virtual bool has_derivatives() const { return false; }
  /// Of apply() and rates().
  virtual void differentiate(const Kinematics& /*kin*/, const double* /*signals*/, Derivatives& /*d*/) const {
  }
  /// Adds to `powers` so that potential' = - power of the force + input - dissipated holds exactly.
  virtual void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const = 0;
  virtual std::vector<OutputInfo> outputs() const { return {}; }
  virtual void evaluate_outputs(const Kinematics& /*kin*/, const double* /*signals*/,
                                double* /*values*/) const {}
  /// Signals its formulas read.
  virtual std::vector<int> reads() const { return {}; }
  /// Coordinates of joints that it works on: these joints stay in the tree, where an angle counts turns.
  virtual std::vector<CoordinateRef> coordinates() const { return {}; }
  /// The markers it acts between, for pictures; -1 where there is none.
  virtual std::pair<int, int> markers() const { return {-1, -1}; }
  /// The marker in whose axes its outputs give their components; -1: the world's.
  virtual int axes() const { return markers().first; }
  virtual ForceNature nature() const { return ForceNature::unknown; }
  /// Of nature `load`: the element without the load that it gives in the state of `kin`, where nothing of its
  /// force is left but how it answers to other states; with the same states and switches.  nullptr: nothing
  /// stays.
  virtual std::shared_ptr<const ForceElement> without_load(const Kinematics& /*kin*/,
                                                           const double* /*signals*/) const {
    return nullptr;
  }
  /// The body and the load case of its superelement that it puts on it; -1 for none.
  virtual std::pair<int, int> load_case() const { return {-1, -1}; }
  /// Of curves no peak is leapt over.
  virtual std::vector<CurveLaw> curves() const { return {}; }
  virtual std::string_view type() const = 0;

 private:
  std::string name_;
};

}  // namespace flexura::mbs
