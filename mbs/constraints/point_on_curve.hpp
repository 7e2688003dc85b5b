// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <limits>

#include "mbs/constraints/constraint.hpp"
#include "mbs/formulas/space_curve.hpp"

namespace flexura::mbs {

/// Mo stays on a curve fixed in F.
///
/// With P = p_FoMo, d = P - r(s), s the foot of P on the curve and n_i(s) the curve's two normals,
///
///     g_i   = n_i . d
///     g_i'  = n_i . P' + (n_i' . d) s',             s' = r' . P' / D,   D = r' . r' - d . r''
///     g_i'' = n_i . P'' + n_i' . (2 P' - r' s') s' + (n_i'' . d) s'^2 + (n_i' . d) s''
///     s''   = (r' . P'' + r'' . P' s' - D' s') / D,  D' = 3 (r' . r'') s' - P' . r'' - (d . r''') s'
///
/// (n_i . r' = 0; on the curve d = 0 and what is left of g' is n_i . P'.)  The foot's parameter is the
/// algebraic state, 0 = (P - r(a)) . r'(a); rows find it from there by themselves, so that g depends on P
/// alone.
class PointOnCurve final : public RelativeRows {
 public:
  PointOnCurve(SpaceCurve curve, double near) : curve_(std::move(curve)), near_(near) {}
  int n_rows() const override { return 2; }
  std::string row_name(int i) const override { return i == 0 ? "side" : "up"; }
  bool has_contact() const override { return true; }

  void constrain(Rows& rows) const override {
    const Vector3d& P = rows.X_FM().p;
    const Vector3d u = rows.linear();
    const bool known = rows.contact && std::isfinite(*rows.contact);
    const double s = curve_.foot(P, known ? *rows.contact : near_);
    if (rows.contact) *rows.contact = s;
    const SpaceCurve::Point c = curve_.at(s);
    const SpaceCurve::Frame f = curve_.frame(c);
    const Vector3d d = P - c.r;
    const double D = c.r_1.squaredNorm() - d.dot(c.r_2), s_dot = c.r_1.dot(u) / D;
    const double D_dot = 3.0 * c.r_1.dot(c.r_2) * s_dot - u.dot(c.r_2) - d.dot(c.r_3) * s_dot;
    const double s_bias = (c.r_2.dot(u) - D_dot) * s_dot / D;
    for (int i = 0; i < 2; ++i) {
      const double turn = f.n_1[i].dot(d);
      rows.add(
          f.n[i].dot(d), Vector3d::Zero(), f.n[i] + turn / D * c.r_1,
          f.n_1[i].dot(2.0 * u - c.r_1 * s_dot) * s_dot + f.n_2[i].dot(d) * s_dot * s_dot + turn * s_bias);
    }
  }
  double contact_residual(const Pose& X_FM, double a) const override {
    const SpaceCurve::Point c = curve_.at(a);
    return (X_FM.p - c.r).dot(c.r_1);
  }
  Eigen::Vector4d contact_derivatives(const Pose& X_FM, double a) const override {
    const SpaceCurve::Point c = curve_.at(a);
    Eigen::Vector4d by;
    by << c.r_1, (X_FM.p - c.r).dot(c.r_2) - c.r_1.squaredNorm();
    return by;
  }
  double start_contact(const Pose& X_FM) const override { return curve_.foot(X_FM.p, near_); }

 private:
  SpaceCurve curve_;
  double near_;  // NaN: anywhere
};

}  // namespace flexura::mbs
