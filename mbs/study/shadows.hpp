// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/prepare.hpp"

/// What a run loses by the modes it leaves out, estimated while it runs: the dropped modes follow as shadows,
/// driven one-way by the loads of the run.
///
/// Beside the mechanism that runs stands the same one with every mode of every superelement.  The state of
/// the run, put into it with the dropped modes at rest, satisfies all its equations but those of the dropped
/// modes, where the momentum balance leaves a residual r: the load that the modes would have felt (inertia of
/// the large motion, reactions at the interfaces, gravity).  The correction delta of all coordinates obeys,
/// to first order,
///
///     M(p) delta'' + D delta' + K delta + G(p)^T dlambda = -r(t),      G(p) delta = 0
///
/// with K and D the bodies' own modal stiffness and damping; what delta changes in applied forces, spins and
/// lever arms is left out (so the estimate is first order: it says little where the loss is of order one, and
/// nothing about instabilities).  One step of generalised-alpha (Arnold and Bruels 2007, rho_inf = 0.4) leads
/// from one stored row to the next, whatever the frequencies: modes that the rows do not resolve respond
/// statically.  r is split by the bodies it acts on; the equation is linear, so each body's share of the
/// error is known.
///
/// The error of an output y is y(p + delta, v + delta', v' + delta'', lambda + dlambda) - y(p, v, v',
/// lambda), both in the mechanism with all modes.
namespace flexura::study {

struct OutputEstimate {
  std::string name, unit;
  double max = 0.0, rms = 0.0, final = 0.0;  ///< of the error, in the output's unit
  double size_max = 0.0, size_rms = 0.0;     ///< of the corrected output
  bool counts = true;                        ///< false where the output is nothing beside others of its unit
  double relative_max() const;
  double relative_rms() const;
};

/// What a body would lose with its lowest `modes` only, from the shadows of a run with fewer.
struct ModesNeeded {
  int modes = 0;
  double error = 0.0;       ///< relative rms, of the worst output
  double highest_hz = 0.0;  ///< of the kept ones (free body)
};

struct SourceEstimate {
  std::string body;
  int available = 0;                ///< deformations of its superelement
  double error = 0.0;               ///< relative rms of the worst output, by this body alone
  std::string output;               ///< that output
  std::vector<ModesNeeded> ladder;  ///< only where it was asked for
};

struct TruncationEstimate {
  std::vector<OutputEstimate> outputs;
  std::vector<SourceEstimate> by_body;  ///< the largest first
  int shadows = 0;                      ///< dropped modes that were followed
  int worst = -1;      ///< the output of the largest relative rms error, -1 when there is none
  double error = 0.0;  ///< that error
  double wall = 0.0;   ///< [s] that the shadows took
};

class Shadows {
 public:
  /// Null where no superelement has dropped modes.  `overrides` are those the run was prepared with;
  /// with_ladder also asks what each body would lose with 1, 2, 3, 4, 6, 8, 12, ... modes.
  static std::unique_ptr<Shadows> make(const mbs::PreparedMechanism& run, const std::filesystem::path& file,
                                       const std::vector<std::string>& overrides, bool with_ladder = false);
  ~Shadows();

  /// The next row of the run.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  TruncationEstimate estimate() const;

 private:
  struct Impl;
  explicit Shadows(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace flexura::study
