// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/properties/linear_scenes.hpp"

#include <fmt/format.h>

#include <cmath>
#include <tuple>

namespace flexura::properties {

std::string SceneMaker::input() {
  if (n_inputs_ == 0 || (n_inputs_ < 3 && chance_.flip(0.6))) ++n_inputs_;
  return fmt::format("u{}", 1 + chance_.below(n_inputs_));
}

std::string SceneMaker::followed() {
  const std::string u = input(), name = fmt::format("c{}", ++n_controls_);
  switch (chance_.below(7)) {
    case 0:
      return u;
    case 5:
      text_ += fmt::format(
          "[control.{0}]\ntype = \"algebraic\"\nequation = \"{0} + 0.4*{0}^3 + 0.3*sin({0}) - {1}\"\n", name,
          u);
      return name;
    case 6:
      text_ += fmt::format(
          "[control.{0}]\ntype = \"filter\"\ninput = \"{1}\"\ntime_constant = {2}\n[measure.of_{0}]\ntype = "
          "\"expression\"\nvalue = \"{0} + {0}^2 + 0.3*{1}\"\n[control.al_{0}]\ntype = "
          "\"algebraic\"\nequation = "
          "\"al_{0}*(2 + al_{0}) - of_{0}\"\n",
          name, u, number(0.05, 0.5));
      return "al_" + name;
    case 1:
      return fmt::format("sin({} + 0.3) - {:.17g}", u, std::sin(0.3));
    case 2:
      text_ += fmt::format("[control.{}]\ntype = \"filter\"\ninput = \"{}\"\ntime_constant = {}\n", name, u,
                           number(0.05, 0.5));
      return name;
    case 3: {
      const double gain = number(0.5, 2.0), damping = number(0.1, 0.5), inertia = number(0.01, 0.1);
      text_ += fmt::format(
          "[control.{}]\ntype = \"transfer_function\"\ninput = \"{}\"\nnumerator = [{}]\n"
          "denominator = [1, {}, {}]\n",
          name, u, gain, damping, inertia);
      return name;
    }
    default:
      text_ += fmt::format("[control.{0}]\ntype = \"state\"\nrate = \"{1} - {2}*{0}\"\n", name, u,
                           number(0.5, 5.0));
      return fmt::format("{} + 0.3*{}", name, u);
  }
}

std::string SceneMaker::led(const std::string& position, const std::string& beside) {
  const std::string name = fmt::format("c{}", ++n_controls_), u = input();
  const double damping = number(0.5, 4.0), growth = number(-3.0, 3.0);
  text_ += fmt::format("[control.{0}]\ntype = \"state\"\nrate = \"{1} - {2}*{0} + {3}*{4} + {5}\"\n", name, u,
                       damping, growth, position, beside);
  return name;
}

std::string SceneMaker::drive(const std::string& position, const std::string& speed,
                              const std::string& beside) {
  switch (chance_.below(5)) {
    case 0:
      return fmt::format("drive = \"{}\"\n", followed());
    case 1:
      return fmt::format("drive_speed = \"{}\"\n", followed());
    case 2: {
      const std::string u = input();
      const double damping = number(0.0, 3.0), growth = number(-2.0, 2.0);
      return fmt::format("drive_acceleration = \"{} - {}*{} + {}*{}\"\n", u, damping, speed, growth,
                         position);
    }
    case 3:
      return fmt::format("drive = \"{}\"\n", led(position, beside));
    default:
      return fmt::format("drive_speed = \"{}\"\n", led(position, beside));
  }
}

std::string SceneMaker::feedback(const std::string& position, const std::string& speed) {
  const std::string name = fmt::format("c{}", ++n_controls_), u = input();
  const double k = number(5.0, 40.0), d = number(0.0, 2.0);
  const std::string error = fmt::format("{} - {}", u, position);
  switch (chance_.below(5)) {
    case 0:
      text_ += fmt::format(
          "[control.{}]\ntype = \"pid\"\nerror = \"{}\"\nproportional = {}\nintegral = {}\nderivative = {}\n"
          "filter_time = 0.05\n",
          name, error, k, 5.0 * d, d);
      return name;
    case 1:
      text_ += fmt::format("[control.{}]\ntype = \"delay\"\ninput = \"{}\"\ntime = {}\n", name, error,
                           number(0.01, 0.1));
      break;
    case 2:
      text_ += fmt::format("[control.{0}]\ntype = \"algebraic\"\nequation = \"{0} + 0.2*sin({0}) - ({1})\"\n",
                           name, error);
      break;
    case 3:
      text_ += fmt::format("[control.{}]\ntype = \"filter\"\ninput = \"{}\"\ntime_constant = {}\n", name,
                           error, number(0.02, 0.3));
      break;
    default:
      return fmt::format("{}*({}) - {}*{}", k, error, d, speed);
  }
  return fmt::format("{}*{}", k, name);
}

void SceneMaker::body(const std::string& name, double length) {
  const double mass = number(0.5, 2.0), a = number(0.05, 0.1), b = number(0.05, 0.1), c = number(0.05, 0.09);
  text_ += fmt::format("[body.{}]\nmass = {}\ncenter = [0, 0, {}]\ninertia = [{}, {}, {}]\n", name, mass,
                       0.5 * length, a, b, c);
}

void SceneMaker::marker(const std::string& on, const std::string& name, double z, const char* axis) {
  text_ += fmt::format("[{}.marker.{}]\nposition = [0, 0, {}]\naxis = {}\n", on, name, z, axis);
}

void SceneMaker::joint(const std::string& name, const char* type, const std::string& from,
                       const std::string& to, const std::string& keys) {
  text_ +=
      fmt::format("[joint.{}]\ntype = \"{}\"\nfrom = \"{}\"\nto = \"{}\"\n{}", name, type, from, to, keys);
}

void SceneMaker::cranks(double width, double crank, double rocker, double tilt,
                        const std::string& keys_of_crank) {
  text_ += fmt::format(
      "[ground.marker.l]\naxis = [0, 1, 0]\n[ground.marker.r]\nposition = [{}, 0, 0]\naxis = [0, 1, 0]\n",
      width);
  for (const auto& [name, length, x] : {std::tuple{"l", crank, 0.0}, std::tuple{"r", rocker, width}}) {
    const std::string on = fmt::format("body.{}", name);
    body(name, length);
    text_ += fmt::format("position = [{}, 0, 0]\n", x);
    marker(on, "o", 0.0, "[0, 1, 0]");
    marker(on, "p", length, "[0, 1, 0]");
  }
  joint("l", "revolute", "ground.l", "l.o", keys_of_crank);
  joint("r", "revolute", "ground.r", "r.o");
  const std::string start = fmt::format("angle = {:.17g}\n", tilt);
  joint("lc", "revolute", "l.p", "c.l", start);
  joint("rc", "revolute", "r.p", "c.r", start);
}

void SceneMaker::coupler(const std::string& a, const std::string& b) {
  const std::string offset = followed();
  if (chance_.flip(0.5)) {
    text_ += fmt::format(
        "[constraint.k]\ntype = \"expression\"\nvalue = \"{0}.angle + {2}*sin({1}.angle)*(1 + 0.5*({3})) - "
        "({3})\"\n",
        a, b, chance_.either_sign(0.3, 2.0), offset);
    return;
  }
  text_ += fmt::format(
      "[constraint.k]\ntype = \"coupler\"\njoints = [\"{}\", \"{}\"]\nfactors = [1, {}]\noffset = "
      "\"{}\"\n",
      a, b, chance_.either_sign(0.3, 2.0), offset);
}

void SceneMaker::joint_force(const std::string& name, const std::string& joint, const std::string& value) {
  text_ +=
      fmt::format("[force.{}]\ntype = \"joint_force\"\njoint = \"{}\"\nvalue = \"{}\"\n", name, joint, value);
}

void SceneMaker::motion(const std::string& name) {
  motions_ += fmt::format("{}\"{}\"", motions_.empty() ? "" : ", ", name);
  ++n_motions_;
}

void SceneMaker::further(const std::string& name) {
  further_ += fmt::format(", \"{}\"", name);
}

void SceneMaker::place(const std::string& marker, const char* direction) {
  const std::string name = fmt::format("m{}", ++n_measures_);
  for (const char* type : {"position", "acceleration"})
    text_ += fmt::format("[measure.{}_{}]\ntype = \"{}\"\nfrom = \"ground\"\nto = \"{}\"\ndirection = {}\n",
                         name, type, type, marker, direction);
  motion(name + "_position");
  further(name + "_acceleration");
}

void SceneMaker::load(const std::string& joint, const char* direction) {
  const std::string name = fmt::format("m{}", ++n_measures_);
  text_ += fmt::format("[measure.{}]\ntype = \"load_cell\"\njoint = \"{}\"\ndirection = {}\n", name, joint,
                       direction);
  further(name);
}

Scene SceneMaker::done(bool from_equilibrium) {
  return {head_,      text_ + fmt::format("[output]\ny = [{}{}]\n", motions_, further_),
          n_inputs_,  0.0,
          n_motions_, from_equilibrium};
}

}  // namespace flexura::properties
