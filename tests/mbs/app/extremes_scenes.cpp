// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/mbs/app/damped_vibration.hpp"
#include "tests/mbs/app/extremes_numbers.hpp"

namespace flexura::extremes {
namespace {

using std::numbers::pi;

// ---- Linear ones: omega = 1 / time, so that stiffness = mass / time^2. ----------------------------------------------

Scene vibration(const Scales& s, double amplitude, double scale, std::string text, std::string output) {
  Scene out;
  out.text = std::move(text);
  out.output = std::move(output);
  out.end_time = 4.0 * pi * s.time;
  out.scale = std::abs(amplitude * scale);
  out.exact = [=](double t) { return scale * damped_vibration(1.0 / s.time, s.damping, amplitude, t); };
  return out;
}

Scene mass_on_a_rail(const Scales& s, Chance& chance) {
  const Units u(s);
  const double m = chance.within(0.5, 2.0), a = chance.within(0.05, 0.5);
  return vibration(
      s, a, s.length,
      "gravity = [0, 0, 0]\n[ground.marker.rail]\naxis = [1, 2, 2]\n[body.mass]\nmass = " + n(m * u.mass) +
          "\ninertia = " + list(u.inertia, u.inertia, u.inertia) +
          "\nmarker.pin = { axis = [1, 2, 2] }\n[joint.slide]\ntype = \"prismatic\"\nfrom = \"ground.rail\"\n"
          "to = \"mass.pin\"\nposition = " +
          n(a * u.length) +
          "\n[force.spring]\ntype = \"joint_spring_damper\"\njoint = \"slide\"\nstiffness = " +
          n(m * u.stiffness) + "\ndamping = " + n(2.0 * s.damping * m * u.stiffness * s.time) + "\n",
      "slide.position");
}

Scene wheel_on_a_torsion_spring(const Scales& s, Chance& chance) {
  const Units u(s);
  const double J = chance.within(0.5, 2.0), a = chance.within(0.05, 1.5);
  return vibration(
      s, a, 1.0,
      "gravity = [0, 0, 0]\n[ground.marker.axle]\naxis = [2, -1, 2]\n[body.wheel]\nmass = " + n(u.mass) +
          "\ninertia = " + list(J * u.inertia, J * u.inertia, J * u.inertia) +
          "\nmarker.hub = { axis = [2, -1, 2] }\n[joint.axle]\ntype = \"revolute\"\nfrom = \"ground.axle\"\n"
          "to = \"wheel.hub\"\nangle = " +
          n(a) + "\n[force.spring]\ntype = \"joint_spring_damper\"\njoint = \"axle\"\nstiffness = " +
          n(J * u.torque) + "\ndamping = " + n(2.0 * s.damping * J * u.torque * s.time) + "\n",
      "axle.angle");
}

// Along y alone; turning and the other directions have springs of their own that stay at rest.
Scene body_on_a_bushing(const Scales& s, Chance& chance) {
  const Units u(s);
  const double m = chance.within(0.5, 2.0), a = chance.within(0.05, 0.5),
               c = 2.0 * s.damping * m * u.stiffness * s.time;
  return vibration(s, a, s.length,
                   "gravity = [0, 0, 0]\n[ground.marker.seat]\n[body.block]\nmass = " + n(m * u.mass) +
                       "\ninertia = " + list(u.inertia, 2.0 * u.inertia, 2.5 * u.inertia) +
                       "\nmarker.middle = {}\n[joint.free]\ntype = \"free\"\nfrom = \"ground.seat\"\nto = "
                       "\"block.middle\"\n"
                       "y = " +
                       n(a * u.length) +
                       "\n[force.bushing]\ntype = \"bushing\"\nfrom = \"ground.seat\"\n"
                       "to = \"block.middle\"\nstiffness = " +
                       list(2.0 * m * u.stiffness, m * u.stiffness, 3.0 * m * u.stiffness) +
                       "\nrotational_stiffness = " + list(u.torque, u.torque, u.torque) +
                       "\ndamping = " + list(c, c, c) + "\n",
                   "free.y");
}

// A line that keeps its direction is a linear spring.
Scene mass_between_points(const Scales& s, Chance& chance) {
  const Units u(s);
  const double m = chance.within(0.5, 2.0), a = chance.within(0.05, 0.5), far = 3.0, k = m * u.stiffness;
  return vibration(
      s, a, s.length,
      "gravity = [0, 0, 0]\n[ground.marker.rail]\naxis = [0, 1, 0]\n[ground.marker.far]\nposition = " +
          list(0.0, -far * u.length, 0.0) + "\n[body.mass]\nmass = " + n(m * u.mass) +
          "\ninertia = " + list(u.inertia, u.inertia, u.inertia) +
          "\nmarker.pin = { axis = [0, 1, 0] }\n[joint.slide]\ntype = \"prismatic\"\nfrom = \"ground.rail\"\n"
          "to = \"mass.pin\"\nposition = " +
          n(a * u.length) +
          "\n[force.spring]\ntype = \"spring_damper\"\nfrom = \"ground.far\"\nto = \"mass.pin\"\nstiffness "
          "= " +
          n(k) + "\ndamping = " + n(2.0 * s.damping * k * s.time) + "\nfree_length = " + n(far * u.length) +
          "\n",
      "slide.position");
}

// Two equal cranks of length r carry a coupler, which does not turn: (2 J + m r^2) phi'' + k phi = 0 without gravity.
Scene parallelogram(const Scales& s, Chance& chance) {
  const Units u(s);
  const double r = chance.within(0.5, 1.0), m = s.ratio * chance.within(0.5, 2.0),
               J = chance.within(0.05, 0.2), a = chance.within(0.1, 0.5), d = chance.within(1.0, 2.0),
               k = 2.0 * J + m * r * r;
  // The coordinates of the joints are zero where the cranks stand upright.
  std::string text = "gravity = [0, 0, 0]\n[body.coupler]\nmass = " + n(m * u.mass) +
                     "\ncenter = " + list(0.4 * d * u.length, 0.0, 0.0) +
                     "\ninertia = " + list(u.inertia, u.inertia, u.inertia) + "\n";
  for (const int i : {0, 1}) {
    const double x = i * d * u.length;
    text += fmt::format(
        "[ground.marker.foot{0}]\nposition = {1}\naxis = [0, 1, 0]\n[body.crank{0}]\nmass = {2}\ninertia = "
        "{3}\n"
        "position = {1}\nmarker.foot = {{ axis = [0, 1, 0] }}\nmarker.head = {{ position = {4}, axis = [0, "
        "1, 0] }}\n"
        "[body.coupler.marker.pin{0}]\nposition = {1}\naxis = [0, 1, 0]\n[joint.foot{0}]\ntype = "
        "\"revolute\"\n"
        "from = \"ground.foot{0}\"\nto = \"crank{0}.foot\"\nangle = {5}\n[joint.head{0}]\ntype = "
        "\"revolute\"\n"
        "from = \"crank{0}.head\"\nto = \"coupler.pin{0}\"\n",
        i, list(x, 0.0, 0.0), n(u.mass), list(J * u.inertia, J * u.inertia, J * u.inertia),
        list(0.0, 0.0, r * u.length), n(a));
    if (i == 0) text += "angle = " + n(-a) + "\n";  // the other closes the loop
  }
  text +=
      "[force.spring]\ntype = \"joint_spring_damper\"\njoint = \"foot0\"\nstiffness = " + n(k * u.torque) +
      "\ndamping = " + n(2.0 * s.damping * k * u.torque * s.time) + "\n";
  return vibration(s, a, 1.0, std::move(text), "foot0.angle");
}

// ---- Driven ones: the crank at 0.3 + t / time. ----------------------------------------------------------------------

constexpr double kBegins = 0.3;

Scene driven(const Scales& s, double scale, std::string text, std::string output,
             std::function<double(double angle)> of) {
  Scene out;
  out.text =
      "gravity = [0, 0, 0]\n[ground.marker.axle]\naxis = [0, 0, 1]\n" + std::move(text) +
      "[joint.axle]\ntype = \"revolute\"\nfrom = \"ground.axle\"\nto = \"crank.axle\"\ndrive = \"0.3 + t/" +
      n(s.time) + "\"\n";
  out.output = std::move(output);
  out.end_time = 2.0 * pi * s.time;
  out.scale = scale;
  out.exact = [=, time = s.time](double t) { return scale * of(kBegins + t / time); };
  return out;
}

// A bar of length l along its x axis at an angle, with markers at its ends that turn about z.
std::string bar(const Units& u, const char* name, double x, double y, double angle, double l,
                const char* root, const char* tip) {
  return fmt::format(
      "[body.{}]\nmass = {}\ninertia = {}\nposition = {}\nrotation = [0, 0, {}]\nmarker.{} = {{ axis = [0, "
      "0, 1] }}\n"
      "marker.{} = {{ position = {}, axis = [0, 0, 1] }}\n",
      name, n(u.mass), list(0.1 * u.inertia, 0.1 * u.inertia, 0.1 * u.inertia),
      list(x * u.length, y * u.length, 0.0), n(angle), root, tip, list(l * u.length, 0.0, 0.0));
}

Scene driven_slider_crank(const Scales& s, Chance& chance) {
  const Units u(s);
  const double r = chance.within(0.2, 1.0), l = r * (1.0 + s.gap), cx = r * std::cos(kBegins),
               cy = r * std::sin(kBegins), b = -std::asin(cy / l);
  const auto place = [=](double q) {
    return r * std::cos(q) + std::sqrt(std::max(0.0, l * l - std::pow(r * std::sin(q), 2)));
  };
  return driven(
      s, s.length,
      "[ground.marker.rail]\naxis = [1, 0, 0]\n" + bar(u, "crank", 0.0, 0.0, kBegins, r, "axle", "pin") +
          bar(u, "rod", cx, cy, b, l, "big", "small") + "[body.slider]\nmass = " + n(u.mass) +
          "\ninertia = " + list(u.inertia, u.inertia, u.inertia) +
          "\nposition = " + list(place(kBegins) * u.length, 0.0, 0.0) +
          "\nmarker.pin = {}\nmarker.rail = { axis = [1, 0, 0] }\n[joint.slide]\ntype = \"prismatic\"\n"
          "from = \"ground.rail\"\nto = \"slider.rail\"\nposition = " +
          n(place(kBegins) * u.length) +
          "\n[joint.big]\ntype = \"revolute\"\nfrom = \"crank.pin\"\nto = \"rod.big\"\n[joint.small]\ntype = "
          "\"spherical\"\n"
          "from = \"rod.small\"\nto = \"slider.pin\"\n",
      "slide.position", place);
}

// Crank 1, ground 3, coupler 2.5, rocker 1.5 + gap (at most 2.5): the rocker's angle from the diagonal by the law of cosines.
Scene driven_four_bar(const Scales& s, Chance&) {
  const Units u(s);
  const double a = 1.0, d = 3.0, b = 2.5, c = 1.5 + std::min(s.gap, 1.0);
  const auto rocker = [=](double q) {
    const double x = a * std::cos(q) - d, y = a * std::sin(q), e = std::hypot(x, y);
    return std::atan2(y, x) - std::acos(std::clamp((e * e + c * c - b * b) / (2.0 * e * c), -1.0, 1.0));
  };
  const double w = rocker(kBegins), cx = a * std::cos(kBegins), cy = a * std::sin(kBegins),
               tx = d + c * std::cos(w), ty = c * std::sin(w);
  return driven(
      s, 1.0,
      "[ground.marker.pivot]\nposition = " + list(d * u.length, 0.0, 0.0) + "\naxis = [0, 0, 1]\n" +
          bar(u, "crank", 0.0, 0.0, kBegins, a, "axle", "pin") +
          bar(u, "coupler", cx, cy, std::atan2(ty - cy, tx - cx), b, "big", "small") +
          bar(u, "rocker", d, 0.0, w, c, "foot", "head") +
          "[joint.pivot]\ntype = \"revolute\"\nfrom = \"ground.pivot\"\nto = \"rocker.foot\"\nangle = " +
          n(w) +
          "\n[joint.big]\ntype = \"revolute\"\nfrom = \"crank.pin\"\nto = "
          "\"coupler.big\"\n[joint.small]\ntype = \"spherical\"\n"
          "from = \"coupler.small\"\nto = \"rocker.head\"\n[measure.cosine]\ntype = \"expression\"\nvalue = "
          "\"cos(pivot.angle)\"\n",
      "cosine", [=](double q) { return std::cos(rocker(q)); });
}

// The pin of a crank r slides along a bar whose swivel lies r (1 + gap) from the crank's axle.
Scene driven_swivel(const Scales& s, Chance& chance) {
  const Units u(s);
  const double r = chance.within(0.2, 1.0), d = -r * (1.0 + s.gap);
  const auto angle = [=](double q) { return std::atan2(r * std::sin(q), r * std::cos(q) - d); };
  return driven(
      s, 1.0,
      "[ground.marker.swivel]\nposition = " + list(d * u.length, 0.0, 0.0) + "\naxis = [0, 0, 1]\n" +
          bar(u, "crank", 0.0, 0.0, kBegins, r, "axle", "pin") +
          bar(u, "bar", d, 0.0, angle(kBegins), r, "swivel", "end") +
          "[body.bar.marker.line]\naxis = [1, 0, 0]\n[joint.swivel]\ntype = \"revolute\"\nfrom = "
          "\"ground.swivel\"\nto = \"bar.swivel\"\nangle = " +
          n(angle(kBegins)) +
          "\n[constraint.guide]\ntype = \"point_on_line\"\nfrom = \"bar.line\"\nto = \"crank.pin\"\n",
      "swivel.angle", angle);
}

}  // namespace

double Chance::decades(double from, double to) {
  return std::pow(10.0, within(std::log10(from), std::log10(to)));
}

const std::vector<Mechanism>& linear_mechanisms() {
  static const std::vector<Mechanism> all = {{"mass on a rail", mass_on_a_rail},
                                             {"wheel on a torsion spring", wheel_on_a_torsion_spring},
                                             {"body on a bushing", body_on_a_bushing},
                                             {"mass between points", mass_between_points},
                                             {"parallelogram", parallelogram}};
  return all;
}

const std::vector<Mechanism>& driven_mechanisms() {
  static const std::vector<Mechanism> all = {{"driven slider-crank", driven_slider_crank},
                                             {"driven four-bar", driven_four_bar},
                                             {"driven swivel", driven_swivel}};
  return all;
}

}  // namespace flexura::extremes
