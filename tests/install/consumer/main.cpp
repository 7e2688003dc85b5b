// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <cmath>
#include <cstdio>

#include "mbs/forces/force.hpp"
#include "mbs/joints/revolute.hpp"
#include "mbs/library/builder.hpp"
#include "mbs/library/simulation.hpp"

using namespace flexura::mbs;

/// A force element of the user's own: a torque against the speed of a hinge.
class Brake final : public ForceElement {
 public:
  Brake(std::string name, CoordinateRef hinge, double damping)
      : ForceElement(std::move(name)), hinge_(hinge), damping_(damping) {}
  std::string_view type() const override { return "brake"; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(hinge_, -damping_ * kin.speed(hinge_));
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    powers.dissipated += damping_ * kin.speed(hinge_) * kin.speed(hinge_);
  }

 private:
  CoordinateRef hinge_;
  double damping_;
};

// A wheel of 0.5 kg m^2 that runs down from 3 rad/s: 3 exp(-0.2 t / 0.5).
extern "C" int run_down() {
  MechanismBuilder b("wheel");
  const auto wheel =
      b.add("wheel", RigidBody{.mass = 10.0, .inertia = Eigen::Vector3d(0.3, 0.3, 0.5).asDiagonal()});
  auto axle = b.add<Revolute>("axle", b.ground().marker(), wheel.marker());
  axle.speed(3.0);
  b.add<Brake>("brake", axle.coordinate(), 0.2);
  Simulation s(b.build(), {.tolerance = 1e-8});
  while (s.time() < 0.999) s.advance(0.1);
  const double speed = s.output("axle.speed"), exact = 3.0 * std::exp(-0.2 * s.time() / 0.5);
  std::printf("%.9g rad/s at %.9g s, exact %.9g\n", speed, s.time(), exact);
  return std::abs(speed - exact) < 1e-6 ? 0 : 1;
}

int main() {
  return run_down();
}
