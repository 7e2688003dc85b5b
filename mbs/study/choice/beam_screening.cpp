// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/beam_screening.hpp"

#include <algorithm>

namespace flexura::study {

using Eigen::Index;
using Eigen::VectorXd;

BeamScreening::BeamScreening(const mbs::Mechanism& as_ancf, const mbs::Mechanism& run,
                             const std::vector<std::string>& beams)
    : run_(run), scratch_(run.make_scratch()) {
  const mbs::MechanismDescription &bent = as_ancf.description(), &d = run.description();
  const auto infos = run.quantities();
  std::vector<std::pair<int, bool>> uses;  // of outputs_: beam, and whether it is a torque
  for (const std::string& name : beams) {
    const auto deforms = std::ranges::find(bent.bodies, name, &mbs::BodyDescription::name)->flexible;
    const mbs::SlenderBeam beam = deforms->slender().value();
    const int index = static_cast<int>(beams_.size());
    beams_.push_back({name, beam.length, beam.bending_stiffness, 0.0, 0.0});
    const auto body =
        static_cast<int>(std::ranges::find(d.bodies, name, &mbs::BodyDescription::name) - d.bodies.begin());
    for (const mbs::JointDescription& joint : d.joints) {
      if (d.markers[static_cast<std::size_t>(joint.marker_F)].body != body &&
          d.markers[static_cast<std::size_t>(joint.marker_M)].body != body)
        continue;
      for (std::size_t i = 0; i < infos.size(); ++i)
        if (infos[i].name == joint.name + ".force" || infos[i].name == joint.name + ".torque") {
          outputs_.push_back(static_cast<int>(i));
          uses.emplace_back(index, infos[i].name.ends_with(".torque"));
        }
    }
  }
  from_force_ = from_torque_ =
      Eigen::MatrixXd::Zero(static_cast<Index>(beams_.size()), static_cast<Index>(uses.size()));
  for (std::size_t i = 0; i < uses.size(); ++i)
    (uses[i].second ? from_torque_ : from_force_)(uses[i].first, static_cast<Index>(i)) = 1.0;
}

void BeamScreening::take(const mbs::State& s, const VectorXd& v_dot) {
  y_.resize(static_cast<Index>(outputs_.size()));
  run_.evaluate(outputs_, s, v_dot, *scratch_, y_);
  const VectorXd F = from_force_ * y_.cwiseAbs(), T = from_torque_ * y_.cwiseAbs();
  for (std::size_t k = 0; k < beams_.size(); ++k) {
    ScreenedBeam& beam = beams_[k];
    const double f = F(static_cast<Index>(k)), t = T(static_cast<Index>(k)), L = beam.length;
    beam.force = std::max(beam.force, f);
    beam.deflection = std::max(beam.deflection, (f * L * L / 3.0 + t * L / 2.0) / beam.bending_stiffness);
  }
}

}  // namespace flexura::study
