// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>

#include "mbs/forces/contacts/contact_law.hpp"
#include "mbs/forces/force.hpp"
#include "mbs/formulas/space_curve.hpp"
#include "mbs/kinematics/picture.hpp"

namespace flexura::mbs {

/// What the sphere touches: the gap's part that does not come from the sphere's radius, and its gradient,
/// which is the normal towards the sphere, at the sphere's centre p in F.
struct ContactSurface {
  enum class Kind { plane, sphere, cylinder, curve } kind = Kind::plane;
  double radius = 0.0;
  bool inside = false;
  std::shared_ptr<const SpaceCurve> curve = {};  ///< in the xy plane, drawn out along z

  double distance(const Vector3d& p, Vector3d& normal) const {
    if (kind == Kind::plane) {
      normal = Vector3d::UnitZ();
      return p.z();
    }
    if (kind == Kind::curve) {
      const Vector3d P(p.x(), p.y(), 0.0);
      const SpaceCurve::Point foot = curve->at(curve->nearest(P));
      normal = curve->frame(foot).n[0];
      if (inside) normal = -normal;
      return normal.dot(P - foot.r);
    }
    const Vector3d r = kind == Kind::cylinder ? Vector3d(p.x(), p.y(), 0.0) : p;
    const double length = r.norm();
    normal = length > 0.0 ? Vector3d(r / length) : Vector3d(Vector3d::UnitX());
    if (!inside) return length - radius;
    normal = -normal;
    return radius - length;
  }
  /// For pictures: a curve by so many pieces.
  DrawnSurface drawn() const {
    static constexpr const char* names[] = {"plane", "sphere", "cylinder", "curve"};
    DrawnSurface picture{.kind = names[static_cast<int>(kind)], .radius = radius};
    constexpr int pieces = 200;
    for (int i = 0; curve && i <= pieces; ++i)
      picture.points.push_back(curve->at(curve->length() * i / pieces).r);
    picture.is_closed = curve && curve->is_closed();
    return picture;
  }
  /// d normal / dp.
  Matrix3d turning(const Vector3d& p, const Vector3d& normal) const {
    if (kind == Kind::plane) return Matrix3d::Zero();
    if (kind == Kind::curve) {
      // The foot s moves by r' . dp / D.
      const Vector3d P(p.x(), p.y(), 0.0);
      const SpaceCurve::Point foot = curve->at(curve->nearest(P));
      const double D = foot.r_1.squaredNorm() - (P - foot.r).dot(foot.r_2);
      Vector3d along = foot.r_1 / D;
      along.z() = 0.0;
      return (inside ? -1.0 : 1.0) * curve->frame(foot).n_1[0] * along.transpose();
    }
    Matrix3d across = Matrix3d::Identity() - normal * normal.transpose();
    if (kind == Kind::cylinder) across(2, 2) = 0.0;
    const double length = kind == Kind::cylinder ? std::hypot(p.x(), p.y()) : p.norm();
    return length > 0.0 ? Matrix3d((inside ? -1.0 : 1.0) / length * across) : Matrix3d(Matrix3d::Zero());
  }
};

/// A sphere of radius r about Mo touches a surface fixed in F and lets go again (contact_law.hpp).
///
///     gap = distance(p_FoMo) - r,    N along the normal n at the point c = -r n from Mo
///     friction: -mu N tanh(|v_t| / v_0) v_t / |v_t|
///
/// with v_t the sliding velocity of M's point there as seen from F.
class Contact final : public ForceElement, public HasPicture {
 public:
  struct Friction {
    double mu = 0.0, v_0 = 1e-3;  ///< coefficient; speed over which it sets in [m/s]
  };
  /// `radius` of the sphere [m]; 0: a point.
  Contact(std::string name, int F, int M, double radius, ContactSurface surface, ContactLaw law,
          Friction friction = {0.0, 1e-3})
      : ForceElement(std::move(name)),
        F_(F),
        M_(M),
        radius_(radius),
        surface_(std::move(surface)),
        law_(law),
        mu_(friction.mu),
        v_0_(friction.v_0) {}
  std::string_view type() const override { return "contact"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, M_}; }
  bool has_friction() const { return mu_ > 0.0; }
  double transition_speed() const { return v_0_; }  ///< [m/s]
  std::optional<DrawnSurface> drawn_surface() const override {
    DrawnSurface picture = surface_.drawn();
    picture.touching = radius_;
    return picture;
  }
  int n_states() const override { return law_.n_states(); }
  bool is_held(int) const override { return true; }
  int n_switches() const override { return ContactLaw::n_switches; }
  std::string switch_name(int i) const override { return i == 0 ? "gap" : "push"; }
  bool jumps_at(int which) const override { return ContactLaw::jumps_at(which); }
  void start(double* c) const override { std::fill_n(c, n_states(), 1.0); }
  void rates(const Kinematics&, const double*, double* c_rate) const override {
    std::fill_n(c_rate, n_states(), 0.0);
  }
  void switching(const Kinematics& kin, const double*, double* values) const override {
    const Touch at(*this, kin);
    law_.switching(at.gap, at.gap_rate, kin.own.root, kin.own.c, values);
  }
  void start_switches(const Kinematics& kin, const double*, int* root, double* c) const override {
    const Touch at(*this, kin);
    law_.start(at.gap, at.gap_rate, root, c);
  }
  void change_switch(int which, const Kinematics& kin, const double*, int* root, double* c) const override {
    law_.change(which, Touch(*this, kin).gap_rate, root, c);
  }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    if (!ContactLaw::active(kin.own.root)) return;
    const Touch at(*this, kin);
    const Vector3d f = at.N * at.normal + at.friction;
    Vector6d on_M;
    on_M << (-radius_ * at.normal).cross(f), f;
    loads.apply_between(kin, F_, M_, on_M);
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    if (!ContactLaw::active(kin.own.root)) return;
    const Relative rel = kin.relative_motion(F_, M_);
    const Vector3d w = rel.V.head<3>(), u = rel.V.tail<3>();
    const Touch at(*this, kin);
    const ContactLaw::Slopes slopes = law_.slopes(at.gap, at.gap_rate, kin.own.root, kin.own.c);
    const Matrix3d turn = surface_.turning(rel.X_FM.p, at.normal);
    const double speed = at.sliding.norm(), z = speed / v_0_, step = std::tanh(z);
    // friction = -mu N phi(|v_t|) v_t, phi(x) = tanh(x / v_0) / x.
    const double phi = speed > 0.0 ? step / speed : 1.0 / v_0_;
    const double phi_slope = speed > 0.0 ? ((1.0 - step * step) / v_0_ - phi) / speed : 0.0;
    const Vector3d &n = at.normal, f = at.N * n + at.friction;
    const auto on_M = [&](double dN, const Vector3d& dn, const Vector3d& dsliding) {
      const double dspeed = speed > 0.0 ? at.sliding.dot(dsliding) / speed : 0.0;
      const Vector3d df = dN * n + at.N * dn -
                          mu_ * ((dN * phi + at.N * phi_slope * dspeed) * at.sliding + at.N * phi * dsliding);
      Vector6d change;
      change << -radius_ * (dn.cross(f) + n.cross(df)), df;
      return change;
    };
    // The sphere looks alike from all sides: turning it changes nothing.
    Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
    for (int j = 3; j < 12; ++j) {
      const Vector3d dp = j < 6 ? Vector3d(Vector3d::Unit(j - 3)) : Vector3d(Vector3d::Zero());
      const Vector3d dw = j >= 6 && j < 9 ? Vector3d(Vector3d::Unit(j - 6)) : Vector3d(Vector3d::Zero());
      const Vector3d du = j >= 9 ? Vector3d(Vector3d::Unit(j - 9)) : Vector3d(Vector3d::Zero());
      const Vector3d dn = turn * dp;
      const double drate = dn.dot(u) + n.dot(du);
      const Vector3d dsliding = du - radius_ * (dw.cross(n) + w.cross(dn)) - dn * n.dot(u) - n * drate;
      W.col(j) = on_M(slopes.by_gap * n.dot(dp) + slopes.by_rate * drate, dn, dsliding);
    }
    Vector6d wrench;
    wrench << -radius_ * n.cross(f), f;
    d.between(F_, M_, wrench);
    d.by_relative(F_, M_, W);
    if (law_.n_states() > 0) d.by_state(0, on_M(slopes.by_state, Vector3d::Zero(), Vector3d::Zero()));
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    if (!ContactLaw::active(kin.own.root)) return;
    const Touch at(*this, kin);
    powers.potential += law_.energy(at.gap, kin.own.root);
    powers.dissipated +=
        law_.lost_power(at.gap, at.gap_rate, kin.own.root, kin.own.c) - at.friction.dot(at.sliding);
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"gap", input::dim::length, "between the surfaces; negative: penetration"},
            {"normal_force", input::dim::force, "between the surfaces"},
            {"friction_force", input::dim::force, "size"},
            {"sliding_speed", input::dim::velocity, "size, at the point of contact"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    const Touch at(*this, kin);
    values[0] = at.gap;
    values[1] = at.N;
    values[2] = at.friction.norm();
    values[3] = at.sliding.norm();
  }

 private:
  struct Touch {
    Touch(const Contact& contact, const Kinematics& kin) {
      const Relative rel = kin.relative_motion(contact.F_, contact.M_);
      gap = contact.surface_.distance(rel.X_FM.p, normal) - contact.radius_;
      gap_rate = normal.dot(rel.V.tail<3>());
      N = contact.law_.force(gap, gap_rate, kin.own.root, kin.own.c);
      sliding = rel.V.tail<3>() + rel.V.head<3>().cross(-contact.radius_ * normal);
      sliding -= normal * normal.dot(sliding);
      const double speed = sliding.norm();
      if (speed > 0.0 && contact.mu_ > 0.0)
        friction = -contact.mu_ * N * std::tanh(speed / contact.v_0_) / speed * sliding;
    }
    double gap, gap_rate, N;
    Vector3d normal, sliding, friction = Vector3d::Zero();
  };

  int F_, M_;
  double radius_;
  ContactSurface surface_;
  ContactLaw law_;
  double mu_, v_0_;
};

}  // namespace flexura::mbs
