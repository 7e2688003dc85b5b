// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "mbs/model/contact_law.hpp"
#include "mbs/model/forces/types.hpp"
#include "mbs/model/space_curve.hpp"

namespace flexura::mbs {
namespace {

/// What the sphere touches: the gap's part that does not come from the sphere's radius, and its gradient,
/// which is the normal towards the sphere, at the sphere's centre p in F.
struct Surface {
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
///     friction: -mu N tanh(|v_t| / v_0) v_t / |v_t|,   v_t the sliding velocity of M's point there as seen
///     from F
class Contact final : public ForceElement {
 public:
  Contact(std::string name, int F, int M, double radius, Surface surface, ContactLaw law, double mu,
          double v_0)
      : ForceElement(std::move(name)),
        F_(F),
        M_(M),
        radius_(radius),
        surface_(surface),
        law_(law),
        mu_(mu),
        v_0_(v_0) {}
  std::string_view type() const override { return "contact"; }
  ForceNature nature() const override { return ForceNature::response; }
  std::pair<int, int> markers() const override { return {F_, M_}; }
  int n_states() const override { return law_.n_states(); }
  int n_switches() const override { return ContactLaw::n_switches; }
  std::string switch_name(int i) const override { return i == 0 ? "gap" : "push"; }
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
  Surface surface_;
  ContactLaw law_;
  double mu_, v_0_;
};

}  // namespace

ForceType contact_force() {
  using namespace input;
  std::vector<Key> keys = {
      text("from", "marker F that carries the surface").required(),
      text("to", "marker M at the centre of the sphere").required(),
      quantity("radius", dim::length, "of the sphere; 0: a point").required().at_least(0.0),
      choice("surface", {"plane", "sphere", "cylinder", "curve"},
             "what it touches: the xy plane of F from above, a sphere about F, a cylinder about the z axis "
             "of F, or a curve in the xy plane of F drawn out along z, on its left side as one walks from "
             "point to point")
          .or_default("plane"),
      quantity("surface_radius", dim::length, "of the sphere or cylinder").above(0.0),
      vectors3("points", dim::length, "of the curve, z = 0; a cubic spline runs through them"),
      flag("closed", "the curve runs from the last point back to the first").or_default("false"),
      flag("inside", "the sphere rolls inside the surface; of a curve: on its right side")
          .or_default("false")};
  for (Key& key : contact_law_keys()) keys.push_back(std::move(key));
  keys.push_back(
      quantity("friction", dim::none, "coefficient of sliding friction").or_default("0").at_least(0.0));
  keys.push_back(quantity("transition_speed", dim::velocity, "sliding speed over which friction sets in")
                     .or_default("1 mm/s")
                     .above(0.0));
  return {"contact",
          "A sphere touches a plane, a sphere, a cylinder or a curve and lets go of it: an elastic law with "
          "damping or restitution, touch and release located by the integrator.",
          std::move(keys),
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            Surface surface;
            const std::string kind = s.text("surface");
            surface.kind = kind == "plane"    ? Surface::Kind::plane
                           : kind == "sphere" ? Surface::Kind::sphere
                           : kind == "curve"  ? Surface::Kind::curve
                                              : Surface::Kind::cylinder;
            surface.inside = s.flag("inside");
            const double radius = s.quantity("radius");
            if (kind != "curve" && s.has("points"))
              s.refuse("points", "a " + kind + " has none", "write surface = \"curve\"");
            if (kind == "plane" || kind == "curve") {
              if (s.has("surface_radius"))
                s.refuse("surface_radius", "a " + kind + " has none", "take the key away");
              if (kind == "curve") {
                if (!s.has("points")) s.refuse("", "points is missing", "a curve needs it");
                for (const Vector3d& point : s.vectors3("points"))
                  if (point.z() != 0.0)
                    s.refuse("points", "do not all have z = 0",
                             "turn the marker so that its z axis stands on the curve");
                surface.curve = std::make_shared<SpaceCurve>(read_space_curve(s));
              } else if (surface.inside)
                s.refuse("inside", "a plane has no inside", "turn its marker round");
            } else {
              if (!s.has("surface_radius"))
                s.refuse("", "surface_radius is missing", "a " + kind + " needs it");
              surface.radius = s.quantity("surface_radius");
              if (surface.inside && radius >= surface.radius)
                s.refuse("radius", "the sphere does not fit inside", "make it smaller than surface_radius");
            }
            return std::make_shared<Contact>(name, context.marker(s, "from"), context.marker(s, "to"), radius,
                                             surface, read_contact_law(s, context), s.quantity("friction"),
                                             s.quantity("transition_speed"));
          }};
}

}  // namespace flexura::mbs
