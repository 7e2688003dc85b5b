// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "mbs/forces/force.hpp"

namespace flexura::mbs {

/// A plain bearing: the journal M turns in the sleeve F, about the z axis of F, on a film of oil.  Reynolds' equation of the
/// short bearing (F. W. Ocvirk, NACA TN 2808, 1952; G. Capone, L'Energia Elettrica 63 (1986) 105-114) with d = (x, y) of
/// p_FoMo, the journal's speed of turning omega, both seen from F, and h = c - d . e the film in the direction e:
///
///     u = d' + omega / 2 (y, -x),     pressure over the length: P(e) = mu L^3 (u . e) / h^3
///     force on the journal     f = - integral of P e R,  over the half where P > 0 (half), or all around (full)
///     torque about its centre  - (x f_y - y f_x) / 2 - integral of mu R^3 L omega / h, all around
///
/// so that force and torque together lose the power that the film takes: integral of R (u . e) P plus that of shear.
/// The integrals are derivatives of J = integral of 1 / (1 - a cos phi - b sin phi), in closed form.
class JournalBearing final : public ForceElement {
 public:
  enum class Film { half, full };
  struct Geometry {
    double radius, length, clearance;  ///< R, L, c [m]
    double viscosity;                  ///< mu [Pa s]
    Film film = Film::half;
  };
  JournalBearing(std::string name, int F, int M, const Geometry& geometry)
      : ForceElement(std::move(name)), F_(F), M_(M), g_(geometry) {}
  std::string_view type() const override { return "journal_bearing"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, M_}; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply_between(kin, F_, M_, on_M(kin.relative_motion(F_, M_)));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override;
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override;
  std::vector<OutputInfo> outputs() const override;
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override;

 private:
  struct FilmState;
  FilmState film(const Relative& rel) const;
  Vector6d on_M(const Relative& rel) const;

  int F_, M_;
  Geometry g_;
};

}  // namespace flexura::mbs
