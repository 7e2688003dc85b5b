// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "mbs/forces/force.hpp"

namespace flexura::mbs {

/// What a rolling bearing is made of [m], [rad], [Pa].
struct RollingGeometry {
  enum class Kind { ball, roller } kind = Kind::ball;
  int count = 0;                                ///< Z
  double diameter = 0.0, pitch_diameter = 0.0;  ///< of a ball or roller; of the circle of their centres
  double contact_angle = 0.0;                   ///< alpha; positive: carries M against + z
  double clearance = 0.0;                       ///< radial, of the diameter; negative: interference
  bool is_deep_groove = false;  ///< of balls: thrust both ways, the angle follows from the clearance
  double groove_inner = 0.52, groove_outer = 0.52;      ///< radii of the grooves over the balls' diameter
  double length = 0.0;                                  ///< effective, of a roller
  double youngs_modulus = 206e9, poissons_ratio = 0.3;  ///< of balls and grooves
};

/// A ball or roller bearing: the shaft M in the housing F, about the z axis of F, on Z rolling elements at rest, between
/// which the load is distributed by their deflections (ISO 16281:2025, after J. M. de Mul, J. M. Vree, D. A. Maas, J.
/// Tribology 111 (1989) 142-148, without centrifugal forces).  With p = p_FoMo, a the z axis of M, both in F, and e the
/// radial direction of an element, its inner raceway at (R, z) moves by u radially and w axially,
///
///     u = e . (p + z a),     w = p_z + z (a_z - 1) - R e . a
///
///     ball      delta = |A_0 + (u, w)| - A,              Q = c delta^(3/2),    A = (f_i + f_e - 1) D
///               R = d_m / 2 + (f_i - 1/2) D cos alpha,   c of both contacts after Hertz (hertz.hpp)
///     roller    delta = u cos alpha + w sin alpha - s / 2 cos alpha on each of 30 slices,
///               Q = c delta^(10/9),                      c = 35948 L^(8/9) N/mm^(10/9) of steel, over the slices
///
/// A_0 = A (cos alpha, sin alpha), of a deep groove (A - s / 2, 0).  Forces are the gradient of the energy, the sum of
/// Q delta / (n + 1); a viscous damping of p' and of the tilt stands beside them.
class RollingBearing final : public ForceElement {
 public:
  /// `damping` [N s/m] against p', `tilt_damping` [N m s/rad] against the tilt.  Throws std::invalid_argument where the
  /// geometry is none.
  RollingBearing(std::string name, int F, int M, const RollingGeometry& geometry, double damping,
                 double tilt_damping);
  std::string_view type() const override { return "rolling_bearing"; }
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

  /// c [N m^-n] of one rolling element, and n.
  double stiffness() const { return c_; }
  double exponent() const { return n_; }

 private:
  /// Where an element's inner raceway is touched.
  struct Slice {
    double R, z;
  };
  struct State;
  State state(const Pose& X, bool with_slopes) const;
  Vector6d on_M(const Relative& rel) const;

  int F_, M_;
  double c_, n_;
  double damping_, tilt_damping_;
  bool is_ball_;
  double A_ = 0.0;                 ///< between the groove's centres, where a ball just touches
  Eigen::Vector2d rest_, normal_;  ///< A_0; of a roller: the normal (cos alpha, sin alpha)
  double gap_ = 0.0;
  std::vector<Eigen::Vector2d> elements_;  ///< e
  std::vector<Slice> slices_;
};

}  // namespace flexura::mbs
