// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/model/forces/types.hpp"

namespace flexura::mbs {
namespace {

/// Along the line between two points P, Q of length L = |p_PQ|: tension
///
///     k (L - L_0) + f(L - L_0) + d L' + h(L') + preload,        f and h curves
class SpringDamper final : public ForceElement {
 public:
  SpringDamper(std::string name, int P, int Q, double stiffness, double damping, double free_length,
               double preload, std::shared_ptr<const Curve> curve, std::shared_ptr<const Curve> damping_curve)
      : ForceElement(std::move(name)),
        P_(P),
        Q_(Q),
        stiffness_(stiffness),
        damping_(damping),
        free_length_(free_length),
        preload_(preload),
        curve_(std::move(curve)),
        damping_curve_(std::move(damping_curve)) {}
  std::string_view type() const override { return "spring_damper"; }
  /// What the free length and the curves hold at the start belongs to the structure.
  ForceNature nature() const override {
    return preload_ != 0.0 ? ForceNature::load : ForceNature::response;
  }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double*) const override {
    auto rest = std::make_shared<SpringDamper>(*this);
    rest->preload_ = 0.0;
    return rest;
  }
  std::pair<int, int> markers() const override { return {P_, Q_}; }

  void apply(const Kinematics& kin, const double*, Loads& loads) const override {
    const Line line = along(kin);
    const Vector3d f = tension(line) * line.direction;
    loads.apply(P_, Spatial{Vector3d::Zero(), f});
    loads.apply(Q_, Spatial{Vector3d::Zero(), -f});
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double*, Derivatives& d) const override {
    const Relative rel = kin.relative_motion(P_, Q_);
    const double length = rel.X_FM.p.norm();
    if (length == 0.0) return;
    const Vector3d e = rel.X_FM.p / length, u = rel.V.tail<3>();
    const Line line{e, length, e.dot(u)};
    const double stretch = length - free_length_, T = tension(line);
    const double k = stiffness_ + (curve_ ? curve_->at(stretch).first : 0.0);
    const double c = damping_ + (damping_curve_ ? damping_curve_->at(line.rate).first : 0.0);
    // e' turns as e is pulled sideways: (1 - e e^T) / L.
    const Matrix3d turn = (Matrix3d::Identity() - e * e.transpose()) / length;
    Eigen::Matrix<double, 6, 12> W = Eigen::Matrix<double, 6, 12>::Zero();
    W.block<3, 3>(3, 3) = -e * (k * e + c * turn * u).transpose() - T * turn;
    W.block<3, 3>(3, 9) = -c * e * e.transpose();
    Vector6d on_Q;
    on_Q << Vector3d::Zero(), -T * e;
    d.between(P_, Q_, on_Q);
    d.by_relative(P_, Q_, W);
  }
  void add_powers(const Kinematics& kin, const double*, Powers& powers) const override {
    const Line line = along(kin);
    const double stretch = line.length - free_length_;
    powers.potential += 0.5 * stiffness_ * stretch * stretch + preload_ * line.length;
    powers.dissipated += damping_ * line.rate * line.rate;
    if (curve_) powers.potential += curve_->integral(stretch);
    if (damping_curve_) powers.dissipated += (*damping_curve_)(line.rate) * line.rate;
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"force", input::dim::force, "tension of the spring and damper"},
            {"length", input::dim::length, "distance of its ends"}};
  }
  void evaluate_outputs(const Kinematics& kin, const double*, double* values) const override {
    const Line line = along(kin);
    values[0] = tension(line);
    values[1] = line.length;
  }

 private:
  struct Line {
    Vector3d direction;
    double length, rate;
  };
  Line along(const Kinematics& kin) const {
    const MarkerState &P = kin.markers[P_], &Q = kin.markers[Q_];
    const Vector3d r = Q.X_WP.p - P.X_WP.p;
    Line line;
    line.length = r.norm();
    // Ends that coincide leave the direction open; there no force acts.
    line.direction = line.length > 0.0 ? Vector3d(r / line.length) : Vector3d::Zero();
    line.rate = line.direction.dot(Q.V.linear - P.V.linear);
    return line;
  }
  double tension(const Line& line) const {
    const double stretch = line.length - free_length_;
    double tension = stiffness_ * stretch + damping_ * line.rate + preload_;
    if (curve_) tension += (*curve_)(stretch);
    if (damping_curve_) tension += (*damping_curve_)(line.rate);
    return tension;
  }

  int P_, Q_;
  double stiffness_, damping_, free_length_, preload_;
  std::shared_ptr<const Curve> curve_, damping_curve_;
};

}  // namespace

ForceType spring_damper_force() {
  using namespace input;
  return {"spring_damper",
          "Spring and damper along the line between two markers.",
          {text("from", "one end, \"body.marker\"").required(), text("to", "the other end").required(),
           quantity("stiffness", dim::stiffness, "force per stretch").or_default("0 N/m").at_least(0.0),
           quantity("damping", dim::damping, "force per rate of stretch").or_default("0 N*s/m").at_least(0.0),
           quantity("free_length", dim::length, "length without force").or_default("0 m").at_least(0.0),
           quantity("preload", dim::force, "tension at free length").or_default("0 N"),
           text("curve", "table of the spring's tension against the stretch, added"),
           text("damping_curve", "table of the damper's tension against the rate of stretch, added")},
          [](const std::string& name, const Section& s,
             const ReadContext& context) -> std::shared_ptr<const ForceElement> {
            return std::make_shared<SpringDamper>(
                name, context.marker(s, "from"), context.marker(s, "to"), s.quantity("stiffness"),
                s.quantity("damping"), s.quantity("free_length"), s.quantity("preload"),
                s.has("curve") ? context.table(s, "curve") : nullptr,
                s.has("damping_curve") ? context.table(s, "damping_curve") : nullptr);
          }};
}

}  // namespace flexura::mbs
