// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/start/prepare.hpp"

/// What a run with rigid beams says about the beams ([body.NAME.beam]) whose fidelity is to be chosen.
///
/// A beam that no superelement describes is either rigid or a beam in absolute nodal coordinates (ANCF).  Its
/// joints' forces balance all that acts on it, inertia included, so their sum F and that of their torques T,
/// as end loads of a cantilever,
///
///     deflection = F L^3 / (3 EI) + T L^2 / (2 EI),
///
/// bound how far it would bend in the linear theory.  EI is that of the softer direction (FlexibleBody::slender).
namespace flexura::study {

struct ScreenedBeam {
  std::string body;
  double length = 0.0;             ///< [m]
  double bending_stiffness = 0.0;  ///< EI of the softer direction [N m^2]
  double force = 0.0;              ///< [N], largest sum of its joints' forces
  double deflection = 0.0;         ///< over the length
};

class BeamScreening {
 public:
  /// `beams`: bodies of `as_ancf` (where they are slender beams) that are rigid in `run`.
  BeamScreening(const mbs::Mechanism& as_ancf, const mbs::Mechanism& run,
                const std::vector<std::string>& beams);

  /// The next row of the run.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  const std::vector<ScreenedBeam>& beams() const { return beams_; }

 private:
  const mbs::Mechanism& run_;
  std::unique_ptr<mbs::Equations::Scratch> scratch_;
  std::vector<ScreenedBeam> beams_;
  std::vector<int> outputs_;
  Eigen::MatrixXd from_force_, from_torque_;  ///< beams x outputs: 1 where the output is one of its joints'
  Eigen::VectorXd y_;
};

}  // namespace flexura::study
