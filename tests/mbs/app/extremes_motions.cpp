// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "tests/mbs/app/extremes_numbers.hpp"

namespace flexura::extremes {
namespace {

using std::numbers::pi;

// ---- Equations of motion of the test's own, in units of the scene. --------------------------------------------------

// y' = f(y) by the classical Runge-Kutta formula in small steps, kept and interpolated by cubics: 1e-9 at 4000 steps of a motion
// that turns through some radians.
class Solution {
 public:
  using Rate = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;
  Solution(const Rate& f, const Eigen::VectorXd& start, double end, int steps = 4000)
      : h_(end / steps), f_(f) {
    y_.push_back(start);
    for (int i = 0; i < steps; ++i) {
      const Eigen::VectorXd& y = y_.back();
      const Eigen::VectorXd a = f(y), b = f(y + h_ / 2 * a), c = f(y + h_ / 2 * b), d = f(y + h_ * c);
      y_.push_back(y + h_ / 6 * (a + 2 * b + 2 * c + d));
    }
  }
  Eigen::VectorXd at(double t) const {
    const auto i =
        static_cast<std::size_t>(std::clamp(std::floor(t / h_), 0.0, static_cast<double>(y_.size() - 2)));
    const double x = t / h_ - static_cast<double>(i);
    const Eigen::VectorXd m = h_ * f_(y_[i]), q = h_ * f_(y_[i + 1]);
    return (1 + 2 * x) * (1 - x) * (1 - x) * y_[i] + x * (1 - x) * (1 - x) * m +
           x * x * (3 - 2 * x) * y_[i + 1] + x * x * (x - 1) * q;
  }

 private:
  double h_;
  Rate f_;
  std::vector<Eigen::VectorXd> y_;
};

// The lighter of two bodies: a light one before a heavy one would vibrate by itself.
double light(const Scales& s) {
  return std::min(s.ratio, 1.0 / s.ratio);
}

Scene solved(const Scales& s, double end, double scale, std::string text, std::string output,
             const Solution::Rate& f, const Eigen::VectorXd& start,
             const std::function<double(const Eigen::VectorXd&)>& of) {
  const auto solution = std::make_shared<const Solution>(f, start, end);
  Scene out;
  out.text = std::move(text);
  out.output = std::move(output);
  out.end_time = end * s.time;
  out.scale = scale;
  out.exact = [=](double t) { return scale * of(solution->at(t / s.time)); };
  return out;
}

// J phi'' = -m g l sin(phi), from a wide swing; about the axis y a positive angle lifts -x: signs do not matter.
Scene swinging_bar(const Scales& s, Chance& chance) {
  const Units u(s);
  const double m = chance.within(0.5, 2.0), l = chance.within(0.5, 1.0),
               J = chance.within(0.05, 0.3) + m * l * l, a = chance.within(0.5, 2.5), g = 1.0;
  return solved(
      s, 4.0 * pi * std::sqrt(J / (m * g * l)), 1.0,
      "gravity = " + list(0.0, 0.0, -g * u.length / (s.time * s.time)) +
          "\n[ground.marker.pivot]\naxis = [0, 1, 0]\n[body.bar]\nmass = " + n(m * u.mass) +
          "\ncenter = " + list(0.0, 0.0, -l * u.length) + "\ninertia = " +
          list((J - m * l * l) * u.inertia, (J - m * l * l) * u.inertia, (J - m * l * l) * u.inertia) +
          "\nmarker.eye = { axis = [0, 1, 0] }\n[joint.pivot]\ntype = \"revolute\"\nfrom = "
          "\"ground.pivot\"\nto = \"bar.eye\"\n"
          "angle = " +
          n(a) + "\n",
      "pivot.angle",
      [=](const Eigen::VectorXd& y) {
        return Eigen::VectorXd{{y(1), -m * g * l / J * std::sin(y(0))}};
      },
      Eigen::VectorXd{{a, 0.0}}, [](const Eigen::VectorXd& y) { return y(0); });
}

// Two bars in a row, angles phi, psi from below: (J1 + m2 L^2) phi'' + m2 L l2 (cos d psi'' + sin d psi'^2) = -(m1 l1 + m2 L) g sin phi,
// J2 psi'' + m2 L l2 (cos d phi'' - sin d phi'^2) = -m2 l2 g sin psi with d = phi - psi.
Scene double_pendulum(const Scales& s, Chance& chance) {
  const Units u(s);
  const double m1 = chance.within(0.5, 2.0), m2 = light(s) * chance.within(0.5, 2.0), L = 1.0,
               l1 = chance.within(0.4, 0.6), l2 = chance.within(0.4, 0.6), I1 = 0.08 * m1, I2 = 0.08 * m2,
               a = chance.within(0.3, 1.0), b = chance.within(-0.5, 0.5), g = 1.0;
  const auto bar = [&](const char* name, double m, double l, double I) {
    return fmt::format(
        "[body.{}]\nmass = {}\ncenter = {}\ninertia = {}\nmarker.top = {{ axis = [0, 1, 0] }}\n"
        "marker.end = {{ position = {}, axis = [0, 1, 0] }}\n",
        name, n(m * u.mass), list(0.0, 0.0, -l * u.length), list(I * u.inertia, I * u.inertia, I * u.inertia),
        list(0.0, 0.0, -L * u.length));
  };
  const auto rate = [=](const Eigen::VectorXd& y) {
    const double d = y(0) - y(1), c = m2 * L * l2 * std::cos(d), z = m2 * L * l2 * std::sin(d);
    const Eigen::Matrix2d M{{I1 + m1 * l1 * l1 + m2 * L * L, c}, {c, I2 + m2 * l2 * l2}};
    const Eigen::Vector2d f{-(m1 * l1 + m2 * L) * g * std::sin(y(0)) - z * y(3) * y(3),
                            -m2 * l2 * g * std::sin(y(1)) + z * y(2) * y(2)};
    const Eigen::Vector2d w = M.inverse() * f;
    return Eigen::VectorXd{{y(2), y(3), w(0), w(1)}};
  };
  return solved(
      s, 8.0, 1.0,
      "gravity = " + list(0.0, 0.0, -g * u.length / (s.time * s.time)) +
          "\n[ground.marker.pivot]\naxis = [0, 1, 0]\n" + bar("first", m1, l1, I1) +
          bar("second", m2, l2, I2) +
          "[joint.pivot]\ntype = \"revolute\"\nfrom = \"ground.pivot\"\nto = \"first.top\"\nangle = " + n(a) +
          "\n[joint.knee]\ntype = \"revolute\"\nfrom = \"first.end\"\nto = \"second.top\"\nangle = " +
          n(b - a) + "\n",
      "pivot.angle", rate, Eigen::VectorXd{{a, b, 0.0, 0.0}}, [](const Eigen::VectorXd& y) { return y(0); });
}

// Crank r (inertia J), massless but for its middle; rod l with its mass at the pins' middle; slider m3, along x.  All follows from the
// crank's angle q: rod angle sin b = r sin q / l.  M(q) q'' + M'(q) q'^2 / 2 = -k (q - q0), M(q) twice the kinetic energy at q' = 1.
Scene sprung_slider_crank(const Scales& s, Chance& chance) {
  const Units u(s);
  const double r = 0.5, l = chance.within(1.0, 2.0), J = chance.within(0.2, 0.6),
               m2 = chance.within(0.3, 1.0), I2 = 0.1 * m2 * l * l, m3 = light(s) * chance.within(0.3, 1.0),
               k = chance.within(0.5, 2.0), q0 = 2.2, a = chance.within(0.3, 1.2);
  const auto M = [=](double q) {
    const double sb = r * std::sin(q) / l, cb = std::sqrt(1.0 - sb * sb), b1 = r * std::cos(q) / (l * cb);
    const double x3 = -r * std::sin(q) - l * sb * b1, x2 = -r * std::sin(q) - 0.5 * l * sb * b1,
                 y2 = 0.5 * r * std::cos(q);
    return J + m2 * (x2 * x2 + y2 * y2) + I2 * b1 * b1 + m3 * x3 * x3;
  };
  const double b = std::asin(r * std::sin(a) / l);
  const auto rate = [=](const Eigen::VectorXd& y) {
    constexpr double e = 1e-4;  // differences of fourth order: 1e-12
    const double slope =
        (8.0 * (M(y(0) + e) - M(y(0) - e)) - (M(y(0) + 2 * e) - M(y(0) - 2 * e))) / (12.0 * e);
    return Eigen::VectorXd{{y(1), (-k * (y(0) - q0) - 0.5 * slope * y(1) * y(1)) / M(y(0))}};
  };
  const auto body = [&](const char* name, double mass, double cx, double I) {
    return fmt::format("[body.{}]\nmass = {}\ncenter = {}\ninertia = {}\n", name, n(mass * u.mass),
                       list(cx * u.length, 0.0, 0.0), list(I * u.inertia, I * u.inertia, I * u.inertia));
  };
  std::string text =
      "gravity = [0, 0, 0]\n[ground.marker.axle]\naxis = [0, 0, 1]\n[ground.marker.rail]\naxis = [1, 0, "
      "0]\n" +
      body("crank", 1.0, 0.0, J) +
      "marker.axle = { axis = [0, 0, 1] }\nmarker.pin = { position = " + list(r * u.length, 0.0, 0.0) +
      ", axis = [0, 0, 1] }\n" + body("rod", m2, 0.5 * l, I2) +
      "position = " + list(r * std::cos(a) * u.length, r * std::sin(a) * u.length, 0.0) +
      "\nmarker.big = { axis = [0, 0, 1] }\nmarker.small = { position = " + list(l * u.length, 0.0, 0.0) +
      " }\n" + body("slider", m3, 0.0, 0.1) +
      "position = " + list((r * std::cos(a) + l * std::cos(b)) * u.length, 0.0, 0.0) +
      "\nmarker.pin = {}\nmarker.rail = { axis = [1, 0, 0] }\n[joint.axle]\ntype = \"revolute\"\nfrom = "
      "\"ground.axle\"\n"
      "to = \"crank.axle\"\nangle = " +
      n(a) +
      "\n[joint.big]\ntype = \"revolute\"\nfrom = \"crank.pin\"\nto = \"rod.big\"\nangle = " + n(-a - b) +
      "\n[joint.slide]\ntype = \"prismatic\"\nfrom = \"ground.rail\"\nto = \"slider.rail\"\nposition = " +
      n((r * std::cos(a) + l * std::cos(b)) * u.length) +
      "\n[joint.small]\ntype = \"spherical\"\nfrom = \"rod.small\"\nto = \"slider.pin\"\n"
      "[force.spring]\ntype = \"joint_spring_damper\"\njoint = \"axle\"\nstiffness = " +
      n(k * u.torque) + "\nrest = " + n(q0) + "\n";
  return solved(s, 8.0, s.length, std::move(text), "slide.position", rate, Eigen::VectorXd{{a, 0.0}},
                [=](const Eigen::VectorXd& y) {
                  const double sb = r * std::sin(y(0)) / l;
                  return r * std::cos(y(0)) + l * std::sqrt(1.0 - sb * sb);
                });
}

// Euler's equations, spun about the middle axis nearly, with the turning R' = R [w]; where a point of it goes along x.
Scene tumbling_body(const Scales& s, Chance& chance) {
  const Units u(s);
  const Eigen::Vector3d I{1.0, chance.within(1.3, 1.7), 2.2};
  const Eigen::Vector3d w{chance.within(0.05, 0.3), chance.within(1.0, 2.0), chance.within(0.05, 0.3)};
  const auto rate = [=](const Eigen::VectorXd& y) {
    const Eigen::Quaterniond q(y(0), y(1), y(2), y(3));
    const Eigen::Vector3d v = y.segment<3>(4);
    const Eigen::Quaterniond half(0.0, 0.5 * v.x(), 0.5 * v.y(), 0.5 * v.z());
    const Eigen::Quaterniond d = q * half;
    Eigen::VectorXd f(7);
    f << d.w(), d.x(), d.y(), d.z(), (I.cwiseProduct(v).cross(v)).cwiseQuotient(I);
    return f;
  };
  Eigen::VectorXd start(7);
  start << 1.0, 0.0, 0.0, 0.0, w;
  const Eigen::Vector3d p{0.6, 0.5, -0.4};
  return solved(
      s, 10.0, s.length,
      "gravity = [0, 0, 0]\n[ground.marker.space]\n[body.stone]\nmass = " + n(u.mass) +
          "\ninertia = " + list(I.x() * u.inertia, I.y() * u.inertia, I.z() * u.inertia) +
          "\nmarker.middle = {}\nmarker.point = { position = " +
          list(p.x() * u.length, p.y() * u.length, p.z() * u.length) +
          " }\n[joint.free]\ntype = \"free\"\nfrom = \"ground.space\"\nto = \"stone.middle\"\nomega_x = " +
          n(w.x() / s.time) + "\nomega_y = " + n(w.y() / s.time) + "\nomega_z = " + n(w.z() / s.time) +
          "\n[measure.x]\ntype = \"position\"\nfrom = \"ground.space\"\nto = \"stone.point\"\ndirection = "
          "[1, 0, 0]\n",
      "x", rate, start, [=](const Eigen::VectorXd& y) {
        const Eigen::Quaterniond q(y(0), y(1), y(2), y(3));
        return (q * p).x();
      });
}

// A slender clamped bar (Euler and Bernoulli), a force F at its tip from t = 0 on: every mode has the mass m / 4 at the tip, so
// u = sum of 4 F / (m w_n^2) (1 - cos w_n t).  Its superelement has six cubic elements: 3e-4 in the frequency of the second mode, 2e-3
// in that of the third, whose parts are a fortieth and a three-hundredth: one period, before they are out of phase.
Scene cantilever(const Scales& s, Chance& chance) {
  const Units u(s);
  constexpr double betas[] = {1.8751040687119611, 4.6940911329741746, 7.8547574382376126, 10.995540734875467,
                              14.137168391046471};
  const double m = chance.within(0.5, 2.0), w1 = 2.0, EI = m * std::pow(w1 / (betas[0] * betas[0]), 2),
               u_static = chance.within(1e-4, 1e-3), F = u_static * 3.0 * EI, d = 0.05;
  const double line = u.mass / u.length, bending = u.force * u.length * u.length;
  Scene out;
  // Its section is wide, so that torsion does not hold up the explicit method; along the load it has no rotary inertia to speak of.
  out.bar = {.length = u.length,
             .elements = 6,
             .EA = 16.0 * EI / (d * d) * u.force,
             .GI_t = 0.8 * EI * bending,
             .EI_y = EI * bending,
             .EI_z = EI * bending,
             .mass_per_length = m * line,
             .rho_I_y = m * 1e-6 * line * u.length * u.length,
             .rho_I_z = m * 2e-4 * line * u.length * u.length};
  out.text =
      "gravity = [0, 0, 0]\n[ground.marker.wall]\n[body.bar]\nsuperelement = "
      "\"bar.se.h5\"\n[joint.wall]\ntype = \"fixed\"\n"
      "from = \"ground.wall\"\nto = \"bar.root\"\n[force.load]\ntype = \"force\"\nmarker = \"bar.tip\"\nz "
      "= " +
      n(F * u.force) +
      "\n[measure.sag]\ntype = \"position\"\nfrom = \"ground.wall\"\nto = \"bar.tip\"\ndirection = [0, 0, "
      "1]\n";
  out.output = "sag";
  out.end_time = 2.0 * pi / w1 * s.time;
  out.scale = u_static * s.length;
  out.exact = [=, length = s.length, time = s.time](double t) {
    double sum = 0.0;
    for (const double beta : betas) {
      const double w = w1 * std::pow(beta / betas[0], 2);
      sum += 4.0 * F / (m * w * w) * (1.0 - std::cos(w * t / time));
    }
    return sum * length;
  };
  return out;
}

}  // namespace

const std::vector<Mechanism>& other_mechanisms() {
  static const std::vector<Mechanism> all = {{"swinging bar", swinging_bar},
                                             {"double pendulum", double_pendulum},
                                             {"sprung slider-crank", sprung_slider_crank},
                                             {"tumbling body", tumbling_body},
                                             {"cantilever", cantilever}};
  return all;
}

}  // namespace flexura::extremes
