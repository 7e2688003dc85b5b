// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "import/mjcf/actuator_law.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "import/mjcf/joints.hpp"
#include "import/mjcf/sections.hpp"
#include "import/xml/values.hpp"

namespace flexura::import::mjcf {
namespace {

// All kinds of actuators set the same numbers, one after the other: those of the classes, then its own.
class LawReader {
 public:
  explicit LawReader(Findings& findings) : findings_(findings) {}

  void apply(const Node& e) {
    for (const char* key : {"gear", "ctrlrange", "forcerange", "ctrllimited", "forcelimited", "armature",
                            "actlimited", "actrange", "delay"})
      if (e.has(key)) common_.set(key, e.get(key));
    common_.file = e.file;
    common_.line = e.line;
    common_.tag = e.tag;
    if (e.tag == "general")
      general(e);
    else if (e.tag == "motor")
      set("fixed", {1.0}, "none", {}, "none");
    else if (e.tag == "position" || e.tag == "intvelocity")
      position(e);
    else if (e.tag == "velocity") {
      const double kv = xml::number(e, "kv", gains_[0], findings_);
      set("fixed", {kv}, "affine", {0.0, 0.0, -kv}, "none");
    } else if (e.tag == "damper") {
      set("affine", {0.0, 0.0, -xml::number(e, "kv", 1.0, findings_)}, "none", {}, "none");
    } else if (e.tag == "cylinder") {
      cylinder(e);
    } else {
      other_ = e.tag;
    }
  }

  ActuatorLaw law(const Compiler& compiler, const Option& option) {
    ActuatorLaw law;
    const std::vector<double> gear = xml::numbers(common_, "gear", findings_);
    if (!gear.empty()) law.gear = gear;
    law.armature = xml::number(common_, "armature", 0.0, findings_);
    const auto range = [&](const char* limited, const char* key) -> std::optional<std::pair<double, double>> {
      const std::vector<double> r = xml::numbers(common_, key, findings_);
      if (r.size() != 2 || !is_limited(common_, limited, key, compiler, findings_)) return {};
      return std::pair(r[0], r[1]);
    };
    if (option.clamp_controls) law.controls = range("ctrllimited", "ctrlrange");
    law.forces = range("forcelimited", "forcerange");
    if (!other_.empty()) law.unknown = fmt::format("the mechanism file has no {}", other_);
    if (gain_ != "fixed" && gain_ != "affine")
      law.unknown = fmt::format("gaintype \"{}\" is not known", shown(gain_));
    if (bias_ != "none" && bias_ != "affine")
      law.unknown = fmt::format("biastype \"{}\" is not known", shown(bias_));
    law.gain = three(gains_);
    if (gain_ == "fixed") law.gain[1] = law.gain[2] = 0.0;
    law.bias = bias_ == "none" ? std::vector<double>(3, 0.0) : three(biases_);
    // A positive third number is a damping ratio (MuJoCo 3.1.2).
    if (gain_ == "fixed" && law.gain[0] == -law.bias[1] && law.bias[2] > 0.0) {
      law.damping_ratio = law.bias[2];
      law.bias[2] = 0.0;
    }
    if (dynamics_ == "integrator") {
      law.activation = ActuatorLaw::Activation::integrator;
    } else if (dynamics_ == "filter" || dynamics_ == "filterexact") {
      if (time_ > 0.0) {
        law.activation = ActuatorLaw::Activation::filter;
        law.time = time_;
      }
    } else if (dynamics_ != "none") {
      law.unknown = fmt::format("dyntype \"{}\" is not known", shown(dynamics_));
    }
    return law;
  }

 private:
  static std::vector<double> three(std::vector<double> values) {
    values.resize(3, 0.0);
    return values;
  }

  void set(const std::string& gain, const std::vector<double>& gains, const std::string& bias,
           const std::vector<double>& biases, const std::string& dynamics) {
    gain_ = gain;
    gains_ = three(gains);
    bias_ = bias;
    biases_ = three(biases);
    dynamics_ = dynamics;
    other_.clear();
  }

  void general(const Node& e) {
    other_.clear();
    gain_ = e.get("gaintype", gain_);
    bias_ = e.get("biastype", bias_);
    dynamics_ = e.get("dyntype", dynamics_);
    if (e.has("gainprm")) gains_ = three(xml::numbers(e, "gainprm", findings_));
    if (e.has("biasprm")) biases_ = three(xml::numbers(e, "biasprm", findings_));
    if (const std::vector<double> d = xml::numbers(e, "dynprm", findings_); !d.empty()) time_ = d[0];
  }

  void position(const Node& e) {
    const double kp = xml::number(e, "kp", gains_[0], findings_);
    double third = biases_[2];
    if (e.has("kv")) third = -xml::number(e, "kv", 0.0, findings_);
    if (e.has("dampratio")) third = xml::number(e, "dampratio", 0.0, findings_);
    const double time = xml::number(e, "timeconst", dynamics_ == "filterexact" ? time_ : 0.0, findings_);
    set("fixed", {kp}, "affine", {0.0, -kp, third}, "none");
    if (e.tag == "intvelocity") dynamics_ = "integrator";
    if (time > 0.0) {
      dynamics_ = "filterexact";
      time_ = time;
    }
  }

  void cylinder(const Node& e) {
    double area = xml::number(e, "area", 1.0, findings_);
    if (e.has("diameter"))
      area = std::numbers::pi / 4.0 * std::pow(xml::number(e, "diameter", 0.0, findings_), 2);
    std::vector<double> bias = xml::numbers(e, "bias", findings_);
    set("fixed", {area}, "affine", bias, "filter");
    time_ = xml::number(e, "timeconst", 1.0, findings_);
  }

  Findings& findings_;
  Node common_;
  std::string gain_ = "fixed", bias_ = "none", dynamics_ = "none", other_;
  std::vector<double> gains_ = {1.0, 0.0, 0.0}, biases_ = {0.0, 0.0, 0.0};
  double time_ = 1.0;
};

}  // namespace

bool ActuatorLaw::reads_motion() const {
  return gain[1] != 0.0 || gain[2] != 0.0 || bias[1] != 0.0 || bias[2] != 0.0 || damping_ratio != 0.0;
}

ActuatorLaw ActuatorLaw::with_damping(double inertia) const {
  ActuatorLaw law = *this;
  if (damping_ratio > 0.0) law.bias[2] = -2.0 * damping_ratio * std::sqrt(std::max(gain[0] * inertia, 0.0));
  return law;
}

std::string ActuatorLaw::force(const std::string& a, const std::string& length,
                               const std::string& rate) const {
  const auto in_brackets = [](const std::string& x) { return "(" + x + ")"; };
  std::vector<std::pair<double, std::string>> terms;
  if (gain[1] == 0.0 && gain[2] == 0.0) {
    terms.emplace_back(gain[0], a);
  } else {
    terms.emplace_back(
        1.0,
        fmt::format("({}) * {}",
                    sum_of({{gain[0], "1.0"}, {gain[1], in_brackets(length)}, {gain[2], in_brackets(rate)}}),
                    a));
  }
  terms.emplace_back(bias[0], "1.0");
  terms.emplace_back(bias[1], in_brackets(length));
  terms.emplace_back(bias[2], in_brackets(rate));
  return sum_of(terms);
}

ActuatorLaw read_actuator(const Node& element, const Model& model, Findings& findings) {
  LawReader reader(findings);
  for (const Node& setting : model.defaults.actuators(element, findings)) reader.apply(setting);
  reader.apply(element);
  ActuatorLaw law = reader.law(model.compiler, model.option);
  if (element.tag == "plugin") law.unknown = "a plugin computes its force";
  return law;
}

}  // namespace flexura::import::mjcf
