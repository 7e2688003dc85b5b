// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include <fmt/format.h>

#include "mbs/model/expression.hpp"
#include "mbs/model/forces/types.hpp"

namespace flexura::mbs {
namespace {

/// A load case of a body's superelement times a formula (body_load.hpp).
class DistributedLoad final : public ForceElement {
 public:
  DistributedLoad(std::string name, int body, int load, int frame, std::shared_ptr<const Expression> factor)
      : ForceElement(std::move(name)), body_(body), load_(load), frame_(frame), factor_(std::move(factor)) {}
  std::string_view type() const override { return "distributed_load"; }
  std::pair<int, int> markers() const override { return {-1, frame_}; }
  std::pair<int, int> load_case() const override { return {body_, load_}; }
  std::vector<int> reads() const override { return factor_->reads(); }
  ForceNature nature() const override { return ForceNature::load; }
  std::shared_ptr<const ForceElement> without_load(const Kinematics&, const double* signals) const override {
    auto rest = std::make_shared<DistributedLoad>(*this);
    rest->taken_away_ = factor_->evaluate(signals);
    return rest;
  }

  void apply(const Kinematics& kin, const double* signals, Loads& loads) const override {
    const BodyLoad& load = of(kin);
    const double factor = this->factor(signals);
    const Vector6d wrench = factor * load.wrench_at(kin.bodies[body_].s).vector();
    loads.apply(frame_, kin.markers[frame_].X_WP.R * Spatial::from(wrench));
    if (load.modal.size() > 0) loads.apply_modal(body_, load.modal, factor);
  }
  bool has_derivatives() const override { return true; }
  void differentiate(const Kinematics& kin, const double* signals, Derivatives& d) const override {
    const BodyLoad& load = of(kin);
    const double factor = this->factor(signals);
    const double* s = kin.bodies[body_].s;
    const Vector6d wrench = load.wrench_at(s).vector();
    d.wrench(frame_, frame_, -1, factor * wrench);
    d.by_formula(*factor_, signals, wrench);
    for (int i = 0; s && i < load.moment.cols(); ++i)
      d.by_deformation(body_, i, factor * Spatial{load.moment.col(i), Vector3d::Zero()}.vector());
    if (!s) return;
    d.modal(body_, load.modal);
    d.by_formula(*factor_, signals);
  }
  void add_powers(const Kinematics& kin, const double* signals, Powers& powers) const override {
    const BodyLoad& load = of(kin);
    const BodyState& body = kin.bodies[body_];
    const MarkerState& frame = kin.markers[frame_];
    double power = (frame.X_WP.R * load.wrench_at(body.s)).dot(frame.V);
    if (body.s_dot) power += load.modal.dot(Eigen::Map<const Eigen::VectorXd>(body.s_dot, load.modal.size()));
    powers.input += factor(signals) * power;
  }
  std::vector<OutputInfo> outputs() const override {
    return {{"factor", input::dim::none, "factor of the load case"}};
  }
  void evaluate_outputs(const Kinematics&, const double* signals, double* values) const override {
    values[0] = factor(signals);
  }

 private:
  double factor(const double* signals) const { return factor_->evaluate(signals) - taken_away_; }
  const BodyLoad& of(const Kinematics& kin) const {
    return (*kin.bodies[body_].loads)[static_cast<std::size_t>(load_)];
  }

  int body_, load_, frame_;
  std::shared_ptr<const Expression> factor_;
  double taken_away_ = 0.0;
};

}  // namespace

ForceType distributed_load_force() {
  using namespace input;
  ForceType type;
  type.name = "distributed_load";
  type.doc =
      "A load case of a superelement (pressure, gravity, rotation or a field, `[load.NAME]` in its part "
      "file) times a formula. Its forces turn with the body; on a rigid body they act by their resultant.";
  type.keys = {text("body", "the body, of a superelement that was reduced with load cases").required(),
               text("load", "name of the load case").required(),
               expression("factor", "factor, a formula of t, parameters, joint coordinates and measures")
                   .or_default("1")};
  type.read = [](const std::string& name, const Section& s,
                 const ReadContext& c) -> std::shared_ptr<const ForceElement> {
    const int body = c.body(s, "body");
    const std::vector<BodyLoad>& loads = c.description().bodies[body].loads;
    const std::string wanted = s.text("load");
    std::vector<std::string> known;
    for (std::size_t i = 0; i < loads.size(); ++i) {
      if (loads[i].name == wanted)
        return std::make_shared<DistributedLoad>(name, body, static_cast<int>(i), c.marker(s, "body"),
                                                 c.expression(s, "factor"));
      known.push_back(loads[i].name);
    }
    s.refuse("load",
             fmt::format("body \"{}\" has no load case \"{}\"{}", s.text("body"), wanted,
                         input::suggestion(wanted, known)),
             c.description().bodies[body].superelement.empty()
                 ? "load cases belong to superelements: name a body made of one"
             : known.empty() ? "write [load." + wanted + "] into its part file and reduce it again"
                             : "");
  };
  return type;
}

}  // namespace flexura::mbs
