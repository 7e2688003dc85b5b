// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#include "mbs/study/choice/beam_screening.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace flexura::study {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

// The angle over which a beam is bent to have its stiffness: the energy's terms of higher order are its
// square, far below what a screening needs.
constexpr double kArc = 1e-3;

}  // namespace

double softer_bending_stiffness(const beam::ancf::AncfBody& beam) {
  const VectorXd& rest = beam.rest();
  const Vector3d root = rest.segment<3>(beam.index(0, 0)), x = rest.segment<3>(beam.index(0, 1)).normalized();
  const double L = beam.length(), kappa = kArc / L;
  double least = std::numeric_limits<double>::infinity();
  for (const int across : {2, 3}) {
    const Vector3d y = rest.segment<3>(beam.index(0, across)).normalized(), z = x.cross(y);
    VectorXd q = rest;
    for (int node = 0; node < beam.n_nodes(); ++node) {
      const double s = x.dot(rest.segment<3>(beam.index(node, 0)) - root);
      q.segment<3>(beam.index(node, 0)) =
          root + x * (std::sin(kappa * s) / kappa) + y * ((1.0 - std::cos(kappa * s)) / kappa);
      const Eigen::AngleAxisd turn(kappa * s, z);
      for (int k = 1; k < beam.vectors(); ++k)
        q.segment<3>(beam.index(node, k)) = turn * Vector3d(rest.segment<3>(beam.index(node, k)));
    }
    least = std::min(least, 2.0 * beam.strain_energy(q) / (kappa * kappa * L));
  }
  return least;
}

BeamScreening::BeamScreening(const mbs::Mechanism& as_ancf, const mbs::Mechanism& run,
                             const std::vector<std::string>& beams)
    : run_(run), scratch_(run.make_scratch()) {
  const mbs::MechanismDescription &bent = as_ancf.description(), &d = run.description();
  const auto infos = run.quantities();
  std::vector<std::pair<int, bool>> uses;  // of outputs_: beam, and whether it is a torque
  for (const std::string& name : beams) {
    const auto& part = dynamic_cast<const mbs::AncfPart&>(
        *std::ranges::find(bent.bodies, name, &mbs::BodyDescription::name)->flexible);
    const int index = static_cast<int>(beams_.size());
    beams_.push_back({name, part.beam().length(), softer_bending_stiffness(part.beam()), 0.0, 0.0});
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
