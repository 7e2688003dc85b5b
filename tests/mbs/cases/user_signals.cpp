// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>

#include "mbs/mechanism/user_element.hpp"

/// Controls and measures of a user's own, of each kind of state: user_signals_test.cpp holds them against the program's own or
/// against what they must give.
namespace {

using namespace flexura::mbs;

/// c' = (input - c) / time: a dynamic state.
class Lag final : public DifferencedControl {
 public:
  explicit Lag(const UserArguments& a) : DifferencedControl(a.name), a_(a), time_(a.value("time")) {
    a.require_inputs(1);
  }
  std::string_view type() const override { return "lag"; }
  int n_states() const override { return 1; }
  void start(double* c) const override { c[0] = a_.value("start", 0.0); }
  void rates(const double* signals, const double* c, double* c_rate) const override {
    c_rate[0] = (a_.inputs[0]->evaluate(signals) - c[0]) / time_;
  }
  double output(const double*, const double* c) const override { return c[0]; }
  std::vector<int> reads() const override { return a_.reads(); }

 private:
  UserArguments a_;
  double time_;
};

/// 0 = x + x^3 - input, x the control itself: an algebraic state.  inputs = [x, input].
class Cubic final : public DifferencedControl {
 public:
  explicit Cubic(const UserArguments& a) : DifferencedControl(a.name), a_(a) { a.require_inputs(2); }
  std::string_view type() const override { return "cubic"; }
  int n_states() const override { return 0; }
  void start(double*) const override {}
  void rates(const double*, const double*, double*) const override {}
  double output(const double*, const double*) const override { return 0.0; }
  std::vector<int> reads() const override { return a_.reads(); }
  bool is_algebraic() const override { return true; }
  double residual(const double* signals) const override {
    const double x = a_.inputs[0]->evaluate(signals);
    return x + x * x * x - a_.inputs[1]->evaluate(signals);
  }

 private:
  UserArguments a_;
};

/// size tanh(input / size): feeds through.
class Saturation final : public DifferencedControl {
 public:
  explicit Saturation(const UserArguments& a) : DifferencedControl(a.name), a_(a) { a.require_inputs(1); }
  std::string_view type() const override { return "saturation"; }
  int n_states() const override { return 0; }
  void start(double*) const override {}
  void rates(const double*, const double*, double*) const override {}
  double output(const double* signals, const double*) const override {
    const double size = a_.value("size");
    return size * std::tanh(a_.inputs[0]->evaluate(signals) / size);
  }
  bool feeds_through() const override { return true; }
  std::vector<int> reads() const override { return a_.reads(); }

 private:
  UserArguments a_;
};

/// How often the input has risen through 0: held values, a switch.
class Counter final : public DifferencedControl {
 public:
  explicit Counter(const UserArguments& a) : DifferencedControl(a.name), a_(a) { a.require_inputs(1); }
  std::string_view type() const override { return "counter"; }
  int n_states() const override { return 2; }  // the count; 1 where the input lies above 0
  bool is_held(int) const override { return true; }
  void start(double* c) const override { c[0] = c[1] = 0.0; }
  void rates(const double*, const double*, double* c_rate) const override { c_rate[0] = c_rate[1] = 0.0; }
  double output(const double*, const double* c) const override { return c[0]; }
  std::vector<int> reads() const override { return a_.reads(); }
  int n_switches() const override { return 1; }
  std::string switch_name(int) const override { return "sign"; }
  void switching(const double* signals, const double* c, double* values) const override {
    const double x = a_.inputs[0]->evaluate(signals);
    values[0] = c[1] > 0.5 ? x : -x;
  }
  void start_switches(const double* signals, double* c) const override {
    c[1] = a_.inputs[0]->evaluate(signals) > 0.0 ? 1.0 : 0.0;
  }
  void change_switch(int, const double*, double* c) const override {
    c[1] = 1.0 - c[1];
    c[0] += c[1];
  }

 private:
  UserArguments a_;
};

/// The same, and does not say that it feeds through.
class Hidden final : public DifferencedControl {
 public:
  explicit Hidden(const UserArguments& a) : DifferencedControl(a.name), a_(a) {}
  std::string_view type() const override { return "hidden"; }
  int n_states() const override { return 0; }
  void start(double*) const override {}
  void rates(const double*, const double*, double*) const override {}
  double output(const double* signals, const double*) const override {
    return a_.inputs.at(0)->evaluate(signals);
  }
  std::vector<int> reads() const override { return a_.reads(); }

 private:
  UserArguments a_;
};

/// A switch whose function is no number once the input is above 0.5.
class Unsure final : public DifferencedControl {
 public:
  explicit Unsure(const UserArguments& a) : DifferencedControl(a.name), a_(a) {}
  std::string_view type() const override { return "unsure"; }
  int n_states() const override { return 0; }
  void start(double*) const override {}
  void rates(const double*, const double*, double*) const override {}
  double output(const double*, const double*) const override { return 0.0; }
  std::vector<int> reads() const override { return a_.reads(); }
  int n_switches() const override { return 1; }
  void switching(const double* signals, const double*, double* values) const override {
    values[0] = a_.inputs.at(0)->evaluate(signals) > 0.5 ? std::nan("") : 1.0;
  }

 private:
  UserArguments a_;
};

/// The distance of two markers less an input.
class Gap final : public DifferencedMeasure {
 public:
  explicit Gap(const UserArguments& a) : DifferencedMeasure(a.name), a_(a) {
    a.require_markers(2);
    a.require_inputs(1);
  }
  flexura::input::Dimension dimension() const override { return flexura::input::dim::length; }
  std::vector<int> markers() const override { return a_.markers; }
  std::vector<int> reads() const override { return a_.reads(); }
  double value(const Kinematics& kin, const double* signals) const override {
    return kin.relative_pose(a_.markers[0], a_.markers[1]).p.norm() - a_.inputs[0]->evaluate(signals);
  }

 private:
  UserArguments a_;
};

/// A component of the velocity as seen from the first marker times the x component of the position.
class Flow final : public DifferencedMeasure {
 public:
  explicit Flow(const UserArguments& a) : DifferencedMeasure(a.name), a_(a) { a.require_markers(2); }
  flexura::input::Dimension dimension() const override { return flexura::input::dim::none; }
  std::vector<int> markers() const override { return a_.markers; }
  double value(const Kinematics& kin, const double*) const override {
    const Relative rel = kin.relative_motion(a_.markers[0], a_.markers[1]);
    return rel.V(4) * rel.X_FM.p.x();
  }

 private:
  UserArguments a_;
};

template <class Element>
auto make() {
  return [](const UserArguments& a) { return std::make_shared<Element>(a); };
}

}  // namespace

FLEXURA_ELEMENTS(elements) {
  elements.controls["lag"] = make<Lag>();
  elements.controls["cubic"] = make<Cubic>();
  elements.controls["counter"] = make<Counter>();
  elements.controls["misplaced"] = make<Saturation>();
  elements.controls["hidden"] = make<Hidden>();
  elements.controls["unsure"] = make<Unsure>();
  elements.direct_controls["saturation"] = make<Saturation>();
  elements.measures["gap"] = make<Gap>();
  elements.measures["flow"] = make<Flow>();
}
