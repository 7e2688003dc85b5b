// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"
#include "mbs/forces/friction.hpp"

namespace flexura::mbs {

/// Friction along a joint's coordinate that truly sticks; v its speed. Three positions of one switch:
///
///     slip, s = +1 or -1    F = -s (F_c + (F_s - F_c) exp(-(v / v_s)^2)) - d v
///                           until s v falls to 0
///     stick, s = 0          F = -phi - d_k v - d v,   phi' = k v
///                           until |phi + d_k v| rises to F_s
///
/// A sticking joint is held by a spring k that starts without a jump of the force where the joint stopped: it
/// yields by (F_s - F_c) / k at most, and does not creep.  Both ends of sticking are located by the
/// integrator.  A stiff spring in place of the constraint: D. Karnopp, J. Dyn. Sys. Meas. Control 107 (1985)
/// 100-103, section on stiction.
class StickSlip final : public ForceElement {
 public:
  struct Law : FrictionLaw {
    double stick_stiffness, stick_damping;
    input::Dimension along = input::dim::none;  ///< of a force along the coordinate
  };
  StickSlip(std::string name, CoordinateRef c, const Law& law)
      : ForceElement(std::move(name)), c_(c), law_(law) {}
  std::string_view type() const override { return "stick_slip"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::vector<CoordinateRef> coordinates() const override { return {c_}; }
  int n_states() const override { return 1; }
  int n_switches() const override { return 1; }
  std::string switch_name(int) const override { return "stick"; }
  void start(double* c) const override { c[0] = 0.0; }
  void rates(const Kinematics& kin, const double*, double* c_rate) const override {
    c_rate[0] = kin.own.root[0] == 0 ? law_.stick_stiffness * kin.speed(c_) : 0.0;
  }
  void switching(const Kinematics& kin, const double*, double* values) const override {
    const double v = kin.speed(c_);
    const int s = kin.own.root[0];
    values[0] = s != 0 ? s * v : law_.static_force - std::abs(holding(v, kin.own.c));
  }
  void start_switches(const Kinematics& kin, const double*, int* root, double* c) const override {
    const double v = kin.speed(c_);
    // A state that was read holds still, whatever is left of a speed.
    const bool holds = c[0] != 0.0 && std::abs(holding(v, c)) <= law_.static_force;
    root[0] = holds || std::abs(v) < 1e-12 ? 0 : v > 0.0 ? 1 : -1;
    if (root[0] != 0) c[0] = 0.0;
  }
  void change_switch(int, const Kinematics& kin, const double*, int* root, double* c) const override {
    if (root[0] != 0) {
      // A little below the limit, so that a joint which only turns round breaks away by crossing it.
      c[0] = 0.9 * root[0] * law_.coulomb;
      root[0] = 0;
    } else {
      root[0] = holding(kin.speed(c_), c) > 0.0 ? 1 : -1;
      c[0] = 0.0;
    }
  }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(c_, force(kin));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const double v = kin.speed(c_);
    const int s = kin.own.root[0];
    d.force(c_, force(kin));
    d.by_speed(c_, (s == 0 ? -law_.stick_damping : -s * law_.sliding_slope(v)) - law_.viscous);
    if (s != 0) return;
    d.by_state(0, -1.0);
    d.rate(0);
    d.by_speed(c_, law_.stick_stiffness);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const double v = kin.speed(c_);
    if (kin.own.root[0] == 0) {
      const double phi = kin.own.c[0];
      powers.potential += 0.5 * phi * phi / law_.stick_stiffness;
      powers.dissipated += (law_.stick_damping + law_.viscous) * v * v;
    } else {
      powers.dissipated -= force(kin) * v;
    }
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", law_.along, "along the coordinate"},
            {"sticks", input::dim::none, "1 while it sticks, else 0"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    values[0] = force(kin);
    values[1] = kin.own.root[0] == 0 ? 1.0 : 0.0;
  }

 private:
  double holding(double v, const double* c) const { return c[0] + law_.stick_damping * v; }
  double force(const Kinematics& kin) const {
    const double v = kin.speed(c_);
    const int s = kin.own.root[0];
    return (s == 0 ? -holding(v, kin.own.c) : -s * law_.sliding(v)) - law_.viscous * v;
  }
  CoordinateRef c_;
  Law law_;
};

}  // namespace flexura::mbs
