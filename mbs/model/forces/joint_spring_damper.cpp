// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/types.hpp"

namespace flexura::mbs {
namespace {

/// Along a coordinate q of a joint: -k (q - q_0) - f(q - q_0) - d q' - h(q') - preload, f and h curves.  On a
/// revolute joint a torsion spring.
class JointSpringDamper final : public ForceElement {
 public:
  JointSpringDamper(std::string name, CoordinateRef c, double stiffness, double damping, double rest,
                    double preload, std::shared_ptr<const Curve> curve,
                    std::shared_ptr<const Curve> damping_curve)
      : ForceElement(std::move(name)),
        c_(c),
        stiffness_(stiffness),
        damping_(damping),
        rest_(rest),
        preload_(preload),
        curve_(std::move(curve)),
        damping_curve_(std::move(damping_curve)) {}
  std::string_view type() const override { return "joint_spring_damper"; }
  /// What the free length and the curves hold at the start belongs to the structure.
  ForceNature nature() const override {
    return preload_ != 0.0 ? ForceNature::load : ForceNature::response;
  }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double*) const override {
    auto rest = std::make_shared<JointSpringDamper>(*this);
    rest->preload_ = 0.0;
    return rest;
  }
  std::vector<CoordinateRef> coordinates() const override { return {c_}; }
  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    loads.apply(c_, force(kin));
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const double x = kin.coordinate(c_) - rest_, v = kin.speed(c_);
    d.force(c_, force(kin));
    d.by_coordinate(c_, -stiffness_ - (curve_ ? curve_->at(x).first : 0.0));
    d.by_speed(c_, -damping_ - (damping_curve_ ? damping_curve_->at(v).first : 0.0));
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const double q = kin.coordinate(c_), v = kin.speed(c_);
    powers.potential += 0.5 * stiffness_ * (q - rest_) * (q - rest_) + preload_ * q;
    powers.dissipated += damping_ * v * v;
    if (curve_) powers.potential += curve_->integral(q - rest_);
    if (damping_curve_) powers.dissipated += (*damping_curve_)(v)*v;
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", input::dim::none, "along the coordinate: N, or N m for an angle"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    values[0] = force(kin);
  }

 private:
  double force(const Kinematics& kin) const {
    const double x = kin.coordinate(c_) - rest_, v = kin.speed(c_);
    double f = -stiffness_ * x - damping_ * v - preload_;
    if (curve_) f -= (*curve_)(x);
    if (damping_curve_) f -= (*damping_curve_)(v);
    return f;
  }
  CoordinateRef c_;
  double stiffness_, damping_, rest_, preload_;
  std::shared_ptr<const Curve> curve_, damping_curve_;
};

}  // namespace

ForceType joint_spring_damper_force() {
  using namespace input;
  const auto any = [](const char* name, const char* doc) {
    // The unit depends on the joint's coordinate: N m/rad or N/m, so any unit may stand here.
    return expression(name, doc).or_default("0");
  };
  return {"joint_spring_damper",
          "Spring and damper along a joint's coordinate; on a revolute joint a torsion spring.",
          {text("joint", "the joint").required(),
           text("coordinate", "its coordinate, where it has more than one: \"angle\", \"position\", ..."),
           any("stiffness", "N/m, or N m/rad"), any("damping", "N s/m, or N m s/rad"),
           any("rest", "coordinate without force: m, or rad"),
           any("preload", "force against the coordinate at rest"),
           text("curve", "table of the spring's force or torque against coordinate - rest, added"),
           text("damping_curve", "table of the damper's against the speed, added")},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            const CoordinateRef c = context.speed(s, "joint", "coordinate");
            const auto constant = [&](const char* key) { return context.number(s, key); };
            const double stiffness = constant("stiffness"), damping = constant("damping");
            if (stiffness < 0.0) s.refuse("stiffness", "must not be negative");
            if (damping < 0.0) s.refuse("damping", "must not be negative");
            return std::make_shared<JointSpringDamper>(
                name, c, stiffness, damping, constant("rest"), constant("preload"),
                s.has("curve") ? context.table(s, "curve") : nullptr,
                s.has("damping_curve") ? context.table(s, "damping_curve") : nullptr);
          }};
}

}  // namespace flexura::mbs
