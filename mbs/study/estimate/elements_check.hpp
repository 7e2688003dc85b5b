// Copyright the Flexura developers. SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "mbs/solver/start/prepare.hpp"
#include "mbs/study/estimate/judged_outputs.hpp"
#include "mbs/study/estimate/output_rows.hpp"

/// What the number of elements of beams (geometrically exact, ANCF, segments) costs a run in accuracy, from two runs more.
///
/// The error of an output goes with a power of the elements' length h, y(h) = y(0) + c h^p.  Two runs with a half and a
/// quarter of the elements (twice and four times as many where a beam has fewer than four) give c and p of each output
/// from the rms of the differences D between neighbours, h_1 < h_2 < h_3:
///
///     D_23 / D_12 = (h_3^p - h_2^p) / (h_2^p - h_1^p),      E = D_12 h^p / (h_2^p - h_1^p)
///
/// with h of the run itself.  p is taken to be 4 at most, since a better order is more often an accident than a property.
/// Where the differences do not fall with the first power of h the run is too coarse to tell: the error is unknown, and
/// at least the difference itself.  (Richardson's extrapolation; the observed order as by P. Roache, Verification and
/// Validation in Computational Science and Engineering, 1998, ch. 5.)
namespace flexura::study {

struct ElementsEstimate {
  std::vector<std::string> bodies;  ///< whose elements were judged
  double error = 0.0;               ///< relative rms of the worst output that counts
  std::string output;               ///< that output
  bool is_whole = true;             ///< else it is at least `error`
  std::string note;                 ///< what it is from, or why it is not whole
  double wall = 0.0;                ///< [s] that it took
};

/// For three lengths h_1 < h_2 < h_3 and the differences of their outputs: the order p, at most 4, or 0 where the differences
/// do not fall with the first power (a fifth is left to chance).
double observed_order(const std::array<double, 3>& h, double D_12, double D_23);

class ElementsCheck {
 public:
  /// Outputs of runs by the numbers of elements of their beams: what a check has seen a later one need not run again.
  using KnownRuns = std::map<std::vector<int>, OutputRows>;

  /// Null where no beam has elements whose number a run can set, or nothing is judged.  `run` outlives it; `known`, which may be null and outlives it, is of checks of runs that
  /// differ in the numbers of elements alone.
  static std::unique_ptr<ElementsCheck> make(const mbs::PreparedMechanism& run, KnownRuns* known = nullptr);

  /// The next row of the run; 800 at most are compared.
  void take(const mbs::State& s, const Eigen::VectorXd& v_dot);

  /// Runs again with other numbers of elements.  A run that does not come to its end, or takes five times as long as the
  /// run itself (`wall_of_run` [s]) and longer than 20 s, leaves the error unknown.
  /// `of_integrator`: the relative error of the run by its integrator, as far as it is known; what runs differ by within twice
  /// that tells nothing of elements but that they cost no more.
  ElementsEstimate estimate(const mbs::RunCallbacks& callbacks, double wall_of_run,
                            double of_integrator = 0.0);

 private:
  struct Beam {
    std::string name;
    int elements;
  };
  ElementsCheck(const mbs::PreparedMechanism& run, std::vector<Beam> beams, KnownRuns* known);
  /// By two runs with fewer elements of those beams that have many, or with more of those that have few.
  void judge(bool few, const mbs::RunCallbacks& callbacks, ElementsEstimate& out);
  /// The outputs of a run with these numbers of elements.  Throws std::runtime_error where it does not end.
  const OutputRows& run_with(const std::vector<int>& elements, const mbs::RunCallbacks& callbacks,
                             double& wall);

  const mbs::PreparedMechanism& run_;
  std::vector<Beam> beams_;
  std::unique_ptr<KnownRuns> own_;
  KnownRuns* known_;
  double of_integrator_ = 0.0, wall_of_run_ = 0.0;
  std::vector<OutputEstimate> outputs_;  // before which_, which fills it
  std::vector<int> which_;
  Families families_;
  OutputRows rows_;
};

}  // namespace flexura::study
